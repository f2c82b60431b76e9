"""HDF5 files from anywhere, read with care: what is in them is known before it is read."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from math import prod
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dressing_sim.archives import MOST_BYTES, check_size
from dressing_sim.checks import real_array, shown
from dressing_sim.errors import InvalidInputError, one_line


def plain_text(value: object) -> np.bytes_:
    """Plain values as JSON of fixed length; JSON's own escapes keep it ASCII."""
    return np.bytes_(json.dumps(value).encode("ascii"))


def why_closed(path: str | Path, error: OSError) -> str:
    """Why a file does not open: it is another's, closed to us, or none of HDF5's."""
    reason = one_line(str(error))
    if isinstance(error, BlockingIOError) or "unable to lock file" in reason:
        return "locked by another process, which may be writing it"
    if isinstance(error, PermissionError):
        return "cannot be read (permission denied)"
    if not h5py.is_hdf5(path):
        return "not HDF5"
    return f"damaged ({reason})"


@contextmanager
def opened(path: str | Path, valid: str = "") -> Iterator[h5py.File]:
    """A file to be read; whatever is wrong with it or raised in the block becomes one line.

    Args:
        path: The file.
        valid: What is, for the end of that line.

    Raises:
        InvalidInputError: It is too large, does not open, or something was raised.
    """
    check_size(path)
    try:
        with h5py.File(path, "r") as file:
            yield file
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}{valid}") from error
    except OSError as error:
        raise InvalidInputError(f"{path}: {why_closed(path, error)}{valid}") from error
    # What h5py, numpy and json raise for a file that is damaged or made by something else.
    except Exception as error:
        raise InvalidInputError(f"{path}: damaged ({one_line(str(error))}){valid}") from error


def inside(group: h5py.Group, name: str, kind: type) -> Any:
    """A part of a file that is in this very file."""
    where = f"{group.name.rstrip('/')}/{name}"
    if name not in group:
        raise InvalidInputError(f"no {where}")
    if not isinstance(group.get(name, getlink=True), h5py.HardLink):
        raise InvalidInputError(f"{where} is a link to another place")
    part = group[name]
    if not isinstance(part, kind):
        raise InvalidInputError(f"{where} is no {kind.__name__.lower()}")
    return part


def array_of(group: h5py.Group, name: str, shape: tuple[int | str, ...]) -> NDArray[np.float64]:
    """An array, once it is known to be of numbers, and not larger than a file may be."""
    data = inside(group, name, h5py.Dataset)
    size = prod(data.shape or (0,)) * data.dtype.itemsize
    if size > MOST_BYTES or data.dtype.kind not in "iuf" or data.external or data.is_virtual:
        raise InvalidInputError(
            f"{data.name} has shape {data.shape} of {data.dtype}, {size} bytes; valid are at most "
            f"{MOST_BYTES} bytes of real numbers in this file"
        )
    return real_array(data[()], shape, f"{data.name} has")


def attribute(group: h5py.Group, name: str) -> Any:
    """An attribute that is there."""
    if name not in group.attrs:
        where = "" if group.name == "/" else f" of {group.name}"
        raise InvalidInputError(f"no attribute {name}{where}")
    return group.attrs[name]


def described(group: h5py.Group, name: str) -> dict[str, Any]:
    """An attribute that is a JSON object."""
    text = attribute(group, name)
    try:
        value = json.loads(text)
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidInputError(f"{name} of {group.name} is not JSON") from error
    if not isinstance(value, dict):
        raise InvalidInputError(f"{name} is {shown(value)}, valid is a JSON object")
    return value
