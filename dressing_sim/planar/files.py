"""Other people's planar demonstrations.

* ``.npz``: ``t`` (T,), ``xy`` (M, T, 2), ``A`` (M, P, 2, 2), ``b`` (M, P, 2); where the file has a
  validation set, ``validation_xy``, ``validation_A`` and ``validation_b`` likewise.
* ``.mat``: the layout of the paper's authors. A struct array ``s``, one entry a demonstration, with
  ``Data0`` (3, T), rows time, x and y, and ``p``, one entry a frame, with ``A`` (3, 3) and ``b``
  (3,), whose first row and column stand for time.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from dressing_sim.archives import read_npz
from dressing_sim.checks import of_kind, real_array
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import SyntheticDemonstration, check_demonstrations
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.planar.generator import PlanarData
from dressing_sim.planar.matlab import read_structs

#: Arrays of an .npz file, and how those of its validation set are called.
_NEEDED, _VALIDATION = ("t", "xy", "A", "b"), "validation_"


def load(path: Path, validation: Path | None = None) -> PlanarData:
    """Demonstrations from a file; no validation set where the file has none.

    Args:
        path: what to train on.
        validation: a file whose demonstrations, its training set, are to validate on instead.

    Raises:
        InvalidInputError: no such file, another layout, or demonstrations that cannot be used.
    """
    for one in filter(None, (path, validation)):
        of_kind(one, Path, "a file of demonstrations", "a path")
    data = _load(path)
    if validation is None:
        return data
    others = _load(validation).training
    try:
        check_demonstrations((*data.training, *others))
    except InvalidInputError as error:
        raise InvalidInputError(f"{validation} does not go with {path}: {error}") from error
    return PlanarData(data.training, others)


def _load(path: Path) -> PlanarData:
    if not path.is_file():
        raise InvalidInputError(f"no file {path}")
    readers = {".npz": _from_npz, ".mat": _from_mat}
    if path.suffix not in readers:
        raise InvalidInputError(f"{path}: demonstrations come as .npz or .mat")
    try:
        data = readers[path.suffix](path)
        check_demonstrations(data.training)
        if data.validation:
            check_demonstrations(data.validation)
    except InvalidInputError as error:
        told = str(error)
        raise InvalidInputError(told if str(path) in told else f"{path}: {told}") from error
    return data


def _from_npz(path: Path) -> PlanarData:
    arrays = read_npz(path, _NEEDED)
    times = real_array(arrays["t"], ("T",), "t has", "s")
    dt = _step(times)
    training = _demonstrations(dt, arrays, "")
    if len(times) != len(training[0].positions):
        raise InvalidInputError(
            f"t has {len(times)} times where xy has {len(training[0].positions)} positions"
        )
    if not any(name.startswith(_VALIDATION) for name in arrays):
        return PlanarData(training, ())
    missing = [name for name in _NEEDED[1:] if f"{_VALIDATION}{name}" not in arrays]
    if missing:
        raise InvalidInputError(f"no array {_VALIDATION}{missing[0]}, but others of validation")
    return PlanarData(training, _demonstrations(dt, arrays, _VALIDATION))


def _step(times: FloatArray) -> float:
    steps = np.diff(times)
    if len(steps) == 0 or not (steps > 0.0).all():
        raise InvalidInputError("the time steps are not even: times do not increase")
    if not np.allclose(steps, steps[0], rtol=1e-3, atol=0.0):
        raise InvalidInputError("the time steps are not even")
    return float(steps.mean())


def _demonstrations(
    dt: float, arrays: Mapping[str, object], prefix: str
) -> tuple[SyntheticDemonstration, ...]:
    def array(name: str, *shape: int | str) -> FloatArray:
        return real_array(arrays[f"{prefix}{name}"], shape, f"{prefix}{name} has", fewest=1)

    paths = array("xy", "M", "T", 2)
    bases, origins = array("A", len(paths), "P", 2, 2), array("b", len(paths), "P", 2)
    if bases.shape[1] != origins.shape[1]:
        raise InvalidInputError(
            f"{prefix}A has {bases.shape[1]} frames and {prefix}b has {origins.shape[1]}"
        )
    return tuple(
        SyntheticDemonstration(path, dt, tuple(map(Frame, a, b)))
        for path, a, b in zip(paths, bases, origins, strict=True)
    )


def _from_mat(path: Path) -> PlanarData:
    training = []
    for index, entry in enumerate(read_structs(path, "s")):
        named = f"s({index + 1})"
        data = real_array(_field(entry, "Data0", named), (3, "T"), f"{named}.Data0 has")
        frames = []
        for one in np.atleast_1d(_field(entry, "p", named)):
            basis = real_array(_field(one, "A", f"{named}.p"), (3, 3), f"{named}.p.A has")
            origin = real_array(_field(one, "b", f"{named}.p"), (3,), f"{named}.p.b has")
            frames.append(Frame(basis[1:, 1:], origin[1:]))
        training.append(SyntheticDemonstration(data[1:].T, _step(data[0]), tuple(frames)))
    return PlanarData(tuple(training), ())


def _field(entry: object, name: str, named: str) -> Any:
    if not hasattr(entry, name):
        raise InvalidInputError(f"{named} has no field {name}")
    return getattr(entry, name)
