"""Models and policies in files: npz archives of plain arrays and one JSON text, never pickle.

The file is written under a temporary name in the same folder and then moved, so that a reader sees
either the old file or the whole new one.
"""

import io
import json
import zipfile
from pathlib import Path
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_bytes
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
    header = json.dumps(named, default=_plain)
    content = io.BytesIO()
    np.savez(content, allow_pickle=False, header=np.array(header), **arrays)
    write_bytes(path, content.getvalue())
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
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: np.asarray(archive[name]) for name in archive.files}
        header = json.loads(str(arrays.pop("header")))
        if header["format"] != FORMAT or header["version"] != VERSION:
            raise InvalidInputError(
                f"{path} has format {header['format']} {header['version']}, not {FORMAT} {VERSION}"
            )
        return str(header["kind"]), dict(header["settings"]), arrays
    except OSError as error:
        raise InvalidInputError(f"cannot read {path}: {error.strerror or error}") from error
    except (KeyError, TypeError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise InvalidInputError(f"{path} is not a saved model") from error
    except InvalidInputError:
        raise
    except (ValueError, RuntimeError) as error:  # what numpy, json and zipfile raise otherwise
        raise InvalidInputError(f"{path} is not a saved model") from error


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


def save_model(model: Storable, path: str | Path) -> Path:
    """Save a fitted model of one of this library's classes; returns the path.

    A random generator given for k-means is not part of the file.

    Raises:
        InvalidInputError: another kind of model, or one that is not fitted.
    """
    for kind, type_ in _kinds().items():
        if type(model) is type_:
            return write_archive(path, kind, *model.state())
    raise InvalidInputError(f"cannot save a {type(model).__name__}: only {', '.join(_kinds())}")


def load_model(path: str | Path) -> Any:
    """The model that ``save_model`` wrote to ``path``: it generates the same paths, bit for bit.

    Raises:
        InvalidInputError: no such file, not a saved model, or one whose parts do not fit together.
    """
    kind, settings, arrays = read_archive(path)
    type_ = _kinds().get(kind)
    if type_ is None:
        raise InvalidInputError(f"{path} holds a {kind!r}; valid are {', '.join(_kinds())}")
    try:
        return type_.from_state(settings, arrays)
    except (KeyError, TypeError, ValueError) as error:
        raise InvalidInputError(f"{path} is not a sound model: {error}") from error
