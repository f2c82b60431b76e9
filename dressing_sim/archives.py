"""Files from elsewhere, read with care: how large they are is known before anything is read."""

from __future__ import annotations

import json
import struct
import tomllib
import zipfile
import zlib
from collections.abc import Callable, Collection, Iterator
from contextlib import contextmanager
from functools import partial
from math import isfinite, prod
from pathlib import Path
from typing import IO, Any, Final

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError, one_line

#: Largest contents of an archive, and of one file, once they are unpacked [bytes].
MOST_BYTES: Final = 256 * 2**20

#: Largest JSON file [bytes].
MOST_JSON_BYTES: Final = 64 * 2**20

#: Largest TOML file [bytes]; people type these.
MOST_TOML_BYTES: Final = 2**20

#: More arrays are in no archive.
_MOST_ARRAYS = 1000

#: Kinds of numpy's that are read: truth values, numbers and texts; no objects, no records.
_KINDS = "biufcU"

Arrays = dict[str, NDArray[Any]]


def check_size(path: str | Path, most: int = MOST_BYTES) -> None:
    """Raise InvalidInputError unless a file can be looked at and is not too large [bytes]."""
    try:
        size = Path(path).stat().st_size
    except (OSError, ValueError) as error:
        raise unreadable(path, error) from error
    if size > most:
        raise InvalidInputError(f"{path}: {size} bytes, valid is at most {most}")


def check_folder_size(path: str | Path, most: int = MOST_BYTES) -> None:
    """Raise InvalidInputError if the files in a folder are together too large [bytes]."""
    size = sum(file.stat().st_size for file in Path(path).rglob("*") if file.is_file())
    if size > most:
        raise InvalidInputError(f"{path}: {size} bytes, valid is at most {most}")


@contextmanager
def read_by_others(path: str | Path, kind: str) -> Iterator[None]:
    """Whatever a library raises of a file or folder that it reads becomes one line.

    Args:
        path: What is read.
        kind: What it should be.

    Raises:
        InvalidInputError: Anything was raised in the block.
    """
    try:
        yield
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from error
    # Other people's libraries, and those beneath them, raise all kinds of errors.
    except Exception as error:
        reason = one_line(str(error)) or type(error).__name__
        raise InvalidInputError(f"{path}: no {kind}, or damaged ({reason})") from error


def unreadable(path: str | Path, error: Exception) -> InvalidInputError:
    """The error that says that a file cannot be read, and why."""
    reason = getattr(error, "strerror", None) or one_line(str(error)) or type(error).__name__
    return InvalidInputError(f"{path}: cannot be read ({reason})")


def read_npz(path: str | Path, needed: Collection[str] = (), most: int = MOST_BYTES) -> Arrays:
    """The arrays of an npz file by name.

    Sizes in the archive and in the arrays' own headers are looked at before an array is read, so a
    small file cannot ask for much memory.

    Args:
        path: The file.
        needed: Names of arrays that must be there.
        most: Largest contents [bytes].

    Raises:
        InvalidInputError: It cannot be read, is too large, damaged, or lacks an array.
    """
    check_size(path, most)
    try:
        with Path(path).open("rb") as file, zipfile.ZipFile(file) as archive:
            members = {info.filename: info for info in archive.infolist()}
            total = sum(info.file_size for info in archive.infolist())
            if total > most or len(archive.infolist()) > _MOST_ARRAYS:
                raise InvalidInputError(
                    f"{path}: {len(members)} arrays of {total} bytes, valid is at most "
                    f"{_MOST_ARRAYS} arrays of {most} bytes"
                )
            names = {name.removesuffix(".npy"): name for name in members if name.endswith(".npy")}
            missing = sorted(set(needed) - set(names))
            if missing:
                raise InvalidInputError(
                    f"{path}: no array {', '.join(missing)}; valid is a file with "
                    f"{', '.join(needed)}"
                )
            return {
                name: _array(archive, member, f"{path}: array {name!r:.60}")
                for name, member in names.items()
            }
    except zipfile.BadZipFile as error:
        raise InvalidInputError(f"{path}: not an npz archive, or damaged ({error})") from error
    except InvalidInputError:
        raise
    # Encrypted, packed in an odd way, or with names, places or extra fields that are none.
    except (EOFError, RuntimeError, ValueError, OverflowError, struct.error, zlib.error) as error:
        raise InvalidInputError(f"{path}: damaged ({one_line(str(error))})") from error
    except OSError as error:
        raise unreadable(path, error) from error


def _array(archive: zipfile.ZipFile, member: str, named: str) -> NDArray[Any]:
    """One array, once its header says what its size in the archive says."""
    with archive.open(member) as stream:
        shape, kind, begin = _header(stream, named)
    size = archive.getinfo(member).file_size
    wanted = prod(shape) * kind.itemsize
    if kind.kind not in _KINDS:
        raise InvalidInputError(f"{named} has the type {kind}, valid are numbers and texts")
    if begin + wanted != size:
        raise InvalidInputError(
            f"{named} has shape {shape}, {wanted} bytes, where the file has {max(size - begin, 0)}"
        )
    with archive.open(member) as stream:
        try:
            return npy.read_array(stream, allow_pickle=False)
        except ValueError as error:
            raise InvalidInputError(f"{named} is damaged ({one_line(str(error))})") from error


def _header(stream: IO[bytes], named: str) -> tuple[tuple[int, ...], np.dtype[Any], int]:
    """Shape and type of an array, and where in its file its numbers begin."""
    readers = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
    try:
        version = npy.read_magic(stream)
        if version not in readers:
            raise InvalidInputError(
                f"{named} has version {version} of its format, valid are (1, 0) and (2, 0)"
            )
        shape, _, kind = readers[version](stream)
    except InvalidInputError:
        raise
    # numpy parses it with Python's own tools, which raise much else than a ValueError.
    except Exception as error:
        reason = one_line(str(error), 80)
        raise InvalidInputError(f"{named} has a header that is damaged ({reason})") from error
    return shape, kind, stream.tell()


def read_json(path: str | Path, most: int = MOST_JSON_BYTES) -> Any:
    """The value in a JSON file.

    Raises:
        InvalidInputError: It cannot be read, is too large, or is not JSON.
    """
    return _parsed(path, most, "JSON", json.loads)


def read_strict_json(path: str | Path, most: int = MOST_JSON_BYTES) -> Any:
    """The value in a JSON file of somebody else's, in which every name and number means one thing.

    Raises:
        InvalidInputError: As of `read_json`; or an object has a name twice, or a number is NaN,
            infinite, or larger than a float can be.
    """
    parse = partial(
        json.loads, object_pairs_hook=_named_once, parse_constant=_finite, parse_float=_finite
    )
    return _parsed(path, most, "JSON", parse)


def _named_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    values = dict(pairs)
    if len(values) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the name {twice!r:.60} occurs twice in an object")
    return values


def _finite(text: str) -> float:
    number = float(text)
    if not isfinite(number):
        raise ValueError(f"the number {text:.60} is not finite")
    return number


def read_toml(path: str | Path, most: int = MOST_TOML_BYTES) -> dict[str, Any]:
    """The values in a TOML file by name.

    Raises:
        InvalidInputError: It cannot be read, is too large, or is not TOML.
    """
    values: dict[str, Any] = _parsed(path, most, "TOML", tomllib.loads)
    return values


def _parsed(path: str | Path, most: int, kind: str, parse: Callable[[str], Any]) -> Any:
    check_size(path, most)
    try:
        return parse(Path(path).read_text(encoding="utf-8"))
    except OSError as error:
        raise unreadable(path, error) from error
    except RecursionError as error:
        raise InvalidInputError(f"{path}: not {kind} that is meant (nested too deeply)") from error
    except ValueError as error:
        raise InvalidInputError(f"{path}: not {kind} ({one_line(str(error))})") from error


def to_json(values: Any, name: str, **options: Any) -> str:
    """Values as JSON, which has no infinite numbers and no NaN.

    Raises:
        InvalidInputError: There is one among them.
    """
    try:
        return json.dumps(values, allow_nan=False, **options)
    except ValueError as error:
        raise InvalidInputError(
            f"{name}: a number is NaN or infinite, valid are finite numbers"
        ) from error
