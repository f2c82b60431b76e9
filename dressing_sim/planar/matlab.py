"""MATLAB's files of version 5, read with care: their size is known before anything is unpacked."""

from __future__ import annotations

import zlib
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from dressing_sim.archives import MOST_BYTES, check_size, unreadable
from dressing_sim.errors import InvalidInputError, one_line

#: Of a file of version 5: length of its header, and the type of what is packed.
_HEADER, _COMPRESSED = 128, 15


def read_structs(path: Path, name: str) -> list[Any]:
    """The structs in an array of structs, their fields as attributes.

    Raises:
        InvalidInputError: The file cannot be read, is too large, damaged, of another version, or
            has no such array.
    """
    check_size(path)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise unreadable(path, error) from error
    _check_version(content)
    unpacked = _unpacked_size(content)
    if unpacked > MOST_BYTES:
        raise InvalidInputError(f"more than {MOST_BYTES} bytes once it is unpacked")
    from scipy.io import loadmat, whosmat

    try:
        # Of bytes in memory, a length in the file that is too large asks for no memory.
        names = [found for found, _, kind in whosmat(BytesIO(content)) if kind == "struct"]
        if name not in names:
            raise InvalidInputError(f"no array {name} of structs")
        found = loadmat(
            BytesIO(content), struct_as_record=False, squeeze_me=True, variable_names=[name]
        )[name]
    except InvalidInputError:
        raise
    except Exception as error:  # scipy has no error of its own for damage
        raise InvalidInputError(f"damaged ({one_line(str(error), 80)})") from error
    structs = list(np.atleast_1d(found).ravel())
    if not structs:
        raise InvalidInputError(f"{name} is empty, valid is an array of one or more structs")
    return structs


def _check_version(content: bytes) -> None:
    if content[:8] == b"\x89HDF\r\n\x1a\n" or content[:10] == b"MATLAB 7.3":
        raise InvalidInputError("a file of MATLAB 7.3 (HDF5); valid is one saved with -v7")
    if content[126:128] not in (b"IM", b"MI") or content[:6] != b"MATLAB":
        raise InvalidInputError("not a file of MATLAB, version 5 to 7")


def _unpacked_size(content: bytes) -> int:
    """How many bytes the file has once it is unpacked; no more than needed is counted."""
    order = "<u4" if content[126:128] == b"IM" else ">u4"
    size, place = len(content), _HEADER
    while place + 8 <= len(content) and size <= MOST_BYTES:
        kind, length = map(int, np.frombuffer(content, order, 2, place))
        if kind == _COMPRESSED:
            stream = zlib.decompressobj()
            part = content[place + 8 : place + 8 + length]
            try:
                while part and size <= MOST_BYTES:
                    size += len(stream.decompress(part, 2**20))
                    part = stream.unconsumed_tail
            except zlib.error as error:
                raise InvalidInputError(f"damaged ({error})") from error
        place += 8 + length
    return size
