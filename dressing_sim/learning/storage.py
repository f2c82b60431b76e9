"""Models and policies in files: npz archives of plain arrays and one JSON text, never pickle.

The file is written under a temporary name in the same folder and then moved, so that a reader sees
either the old file or the whole new one.
"""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from types import NoneType
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from dressing_sim.archives import read_npz, to_json
from dressing_sim.checks import of_kind, real_array, shown
from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.files import write_file
from dressing_sim.learning.frame import FloatArray
from dressing_sim.provenance import provenance

FORMAT = "dressing_sim.learning"
VERSION = 1

Settings = dict[str, Any]
Arrays = dict[str, FloatArray]


@runtime_checkable
class Storable(Protocol):
    """A model that is a set of JSON-able settings and a set of arrays."""

    def state(self) -> tuple[Settings, Arrays]:
        """Everything that makes the fitted model what it is."""

    @classmethod
    def from_state(cls, settings: Settings, arrays: Arrays) -> Self:
        """The model that ``state`` came from."""


def write_archive(path: str | Path, kind: str, settings: Settings, arrays: Arrays) -> Path:
    """Write settings and arrays to ``path`` (npz), all or nothing; returns the path."""
    named = {
        "format": FORMAT,
        "version": VERSION,
        "kind": kind,
        "settings": settings,
        "provenance": provenance(),
    }
    header = to_json(named, str(path), default=_plain)
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, header=np.array(header), **arrays)
    write_file(path, content.getvalue())
    return Path(path)


def _plain(value: object) -> object:
    """What JSON does not know: a number of numpy's."""
    if isinstance(value, np.generic):
        return value.item()
    raise InvalidInputError(f"a setting is {value!r:.40}, valid are numbers, texts and None")


def read_archive(path: str | Path) -> tuple[str, Settings, Arrays]:
    """Kind, settings and arrays of a file that ``write_archive`` wrote.

    Raises:
        InvalidInputError: no such file, or not one of ours.
    """
    try:
        arrays = read_npz(path)
    except InvalidInputError as error:
        if "cannot be read" in str(error):
            raise
        raise InvalidInputError(f"{path} is not a saved model: {error}") from error
    header = _header(path, arrays)
    return header["kind"], header["settings"], arrays


def _header(path: str | Path, arrays: dict[str, Any]) -> dict[str, Any]:
    """What an archive says of itself, taken out of its arrays."""
    if "header" not in arrays:
        raise InvalidInputError(f"{path} is not a saved model: no array header")
    try:
        header = json.loads(str(arrays.pop("header")))
    except (ValueError, RecursionError) as error:
        raise InvalidInputError(f"{path} is not a saved model: its header is not JSON") from error
    for key, kind in (("format", str), ("version", int), ("kind", str), ("settings", dict)):
        if not isinstance(header, dict) or not isinstance(header.get(key), kind):
            raise InvalidInputError(
                f"{path} is not a saved model: its header has no {key}, valid is a file that "
                "'save_model' wrote"
            )
    if header["format"] != FORMAT or header["version"] != VERSION:
        newer = " (of a newer dressing_sim)" if header["version"] > VERSION else ""
        raise InvalidInputError(
            f"{path} has format {one_line(header['format'], 60)} {header['version']}{newer}, not "
            f"{FORMAT} {VERSION}"
        )
    return header


def _kinds() -> dict[str, type[Storable]]:
    from dressing_sim.learning.augmented import AugmentedTPGMM
    from dressing_sim.learning.timed import TimeTPGMM
    from dressing_sim.learning.tpgmm import TPGMM
    from dressing_sim.learning.trajectory import TrajectoryTPGMM

    return {
        "tpgmm": TPGMM,
        "time-tpgmm": TimeTPGMM,
        "trajectory-tpgmm": TrajectoryTPGMM,
        "augmented-tpgmm": AugmentedTPGMM,
    }


def save_model(
    model: Storable, path: str | Path, kinds: Mapping[str, type[Storable]] | None = None
) -> Path:
    """Save a fitted model of one of this library's classes; returns the path.

    A random generator given for k-means is not part of the file.

    Args:
        model: The model.
        path: File to write (npz).
        kinds: Further classes by name.

    Raises:
        InvalidInputError: another kind of model, or one that is not fitted.
    """
    of_kind(path, (str, Path), "path", "a file to write")
    of_kind(kinds, (Mapping, NoneType), "kinds", "classes by name")
    known = {**_kinds(), **(kinds or {})}
    for kind, type_ in known.items():
        if type(model) is type_:
            return write_archive(path, kind, *model.state())
    raise InvalidInputError(f"cannot save a {type(model).__name__}: only {', '.join(known)}")


def load_model(path: str | Path, kinds: Mapping[str, type[Storable]] | None = None) -> Any:
    """The model that ``save_model`` wrote to ``path``: it generates the same paths, bit for bit.

    Args:
        path: The file.
        kinds: Further classes by name, as they were given to ``save_model``.

    Raises:
        InvalidInputError: no such file, not a saved model, or one whose parts do not fit together.
    """
    of_kind(path, (str, Path), "path", "a file that save_model wrote")
    of_kind(kinds, (Mapping, NoneType), "kinds", "classes by name")
    kind, settings, arrays = read_archive(path)
    known = {**_kinds(), **(kinds or {})}
    type_ = known.get(kind)
    if type_ is None:
        raise InvalidInputError(f"{path} holds a {shown(kind)}; valid are {', '.join(known)}")
    try:
        return type_.from_state(settings, _Parts(arrays))
    except KeyError as error:
        raise InvalidInputError(f"{path} is not a sound model: it has no {error}") from error
    except (AttributeError, TypeError, ValueError, OverflowError) as error:
        told = one_line(str(error))
        raise InvalidInputError(f"{path} is not a sound model: {told}") from error


class _Parts(Arrays):
    """Arrays of a file, each checked as it is asked for."""

    def __getitem__(self, name: str) -> FloatArray:
        return real_array(super().__getitem__(name), None, f"array {name} of the mixture has")
