"""A moment of a dressing as bytes: plain arrays and a header, with a version and a checksum.

Layout, all integers little-endian: the eight bytes ``DRESSIM`` and the version; the length of the
header (4 bytes); the header, JSON; the arrays one after the other; CRC-32 of all before (4 bytes).
"""

from __future__ import annotations

import json
import struct
import zlib
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError

#: Of the layout and of what is in it.
VERSION = 1

_MAGIC = b"DRESSIM" + bytes([VERSION])
_VALID = "valid is what Dressing.snapshot returned, with these versions"


def pack(identity: str, values: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Bytes of a moment.

    Args:
        identity: What it is a moment of; `unpack` wants the same.
        values: Plain values.
        arrays: Of floats, integers or booleans.
    """
    plain = {name: _plain(array) for name, array in arrays.items()}
    described = [[name, array.dtype.str, array.shape] for name, array in plain.items()]
    header = json.dumps({"identity": identity, "values": values, "arrays": described}).encode()
    body = b"".join(
        [_MAGIC, struct.pack("<I", len(header)), header, *(a.tobytes() for a in plain.values())]
    )
    return body + struct.pack("<I", zlib.crc32(body))


def unpack(data: bytes, identity: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Values and arrays, read-only, of a moment; the inverse of `pack`.

    Raises:
        InvalidInputError: It is damaged, of another version, or a moment of something else.
    """
    if not isinstance(data, bytes | bytearray | memoryview):
        raise InvalidInputError(f"snapshot: got {data!r:.40}, {_VALID}")
    data = bytes(data)
    if data[:7] == _MAGIC[:7] and data[7:8] != _MAGIC[7:]:
        raise InvalidInputError(f"snapshot: version {data[7] if len(data) > 7 else '?'}, {_VALID}")
    if data[:8] != _MAGIC or len(data) < 16:
        raise InvalidInputError(f"snapshot: not one, {_VALID}")
    if struct.unpack("<I", data[-4:])[0] != zlib.crc32(memoryview(data)[:-4]):
        raise InvalidInputError(f"snapshot: damaged, {_VALID}")
    (length,) = struct.unpack("<I", data[8:12])
    header = json.loads(data[12 : 12 + length])
    if header["identity"] != identity:
        raise InvalidInputError(
            "snapshot: of another posture, configuration or version of the simulator; valid is one "
            "of a dressing that was made alike"
        )
    arrays, place = {}, 12 + length
    for name, kind, shape in header["arrays"]:
        count = int(np.prod(shape))
        arrays[name] = np.frombuffer(data, kind, count, place).reshape(shape)
        place += arrays[name].nbytes
    return header["values"], arrays


def _plain(array: NDArray[Any]) -> NDArray[Any]:
    kind = {"f": "<f8", "i": "<i8", "b": "|b1"}[array.dtype.kind]
    return np.asarray(array, dtype=kind, order="C")
