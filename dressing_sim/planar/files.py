"""Other people's planar demonstrations.

* ``.npz``: ``t`` (T,), ``xy`` (M, T, 2), ``A`` (M, P, 2, 2), ``b`` (M, P, 2); where the file has a
  validation set, ``validation_xy``, ``validation_A`` and ``validation_b`` likewise.
* ``.mat``: the layout of the paper's authors. A struct array ``s``, one entry a demonstration, with
  ``Data0`` (3, T), rows time, x and y, and ``p``, one entry a frame, with ``A`` (3, 3) and ``b``
  (3,), whose first row and column stand for time.
"""

from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import SyntheticDemonstration, check_demonstrations
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.planar.generator import PlanarData


def load(path: Path, validation: Path | None = None) -> PlanarData:
    """Demonstrations from a file; no validation set where the file has none.

    Args:
        path: what to train on.
        validation: a file whose demonstrations, its training set, are to validate on instead.

    Raises:
        InvalidInputError: no such file, another layout, or demonstrations that cannot be used.
    """
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
        raise InvalidInputError(f"{path}: {error}") from error
    except (AttributeError, IndexError, KeyError, TypeError, ValueError, OSError) as error:
        raise InvalidInputError(f"{path} does not have the expected layout: {error}") from error
    return data


def _from_npz(path: Path) -> PlanarData:
    try:
        contents = np.load(path, allow_pickle=False)
    except BadZipFile as error:
        raise InvalidInputError("not an npz archive") from error
    with contents as archive:
        missing = {"t", "xy", "A", "b"} - set(archive.files)
        if missing:
            raise InvalidInputError(f"no array {', '.join(sorted(missing))}")
        dt = _step(archive["t"])
        training = _demonstrations(dt, archive["xy"], archive["A"], archive["b"])
        validation: tuple[SyntheticDemonstration, ...] = ()
        if "validation_xy" in archive.files:
            validation = _demonstrations(
                dt,
                archive["validation_xy"],
                archive["validation_A"],
                archive["validation_b"],
            )
    return PlanarData(training, validation)


def _step(times: FloatArray) -> float:
    steps = np.diff(times)
    if len(steps) == 0 or not np.allclose(steps, steps[0], rtol=1e-3):
        raise InvalidInputError("the time steps are not even")
    return float(steps.mean())


def _demonstrations(
    dt: float, paths: FloatArray, bases: FloatArray, origins: FloatArray
) -> tuple[SyntheticDemonstration, ...]:
    if paths.ndim != 3 or paths.shape[2] != 2:
        raise InvalidInputError(f"xy must have the shape (M, T, 2), not {paths.shape}")
    return tuple(
        SyntheticDemonstration(path, dt, tuple(map(Frame, a, b)))
        for path, a, b in zip(paths, bases, origins, strict=True)
    )


def _from_mat(path: Path) -> PlanarData:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    try:
        contents: dict[str, Any] = loadmat(path, struct_as_record=False, squeeze_me=True)
    except MatReadError as error:
        raise InvalidInputError(str(error)) from error
    training = []
    for entry in np.atleast_1d(contents["s"]):
        times, xy = entry.Data0[0], entry.Data0[1:].T
        frames = tuple(Frame(p.A[1:, 1:], p.b[1:]) for p in np.atleast_1d(entry.p))
        training.append(SyntheticDemonstration(xy, _step(times), frames))
    return PlanarData(tuple(training), ())
