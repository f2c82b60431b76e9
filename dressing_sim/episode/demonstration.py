"""Recorded demonstrations, and the HDF5 file they are kept in."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import prod
from pathlib import Path
from types import NoneType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dressing_sim.archives import MOST_BYTES, check_size
from dressing_sim.arm import Posture
from dressing_sim.checks import listed, of_kind, real_array, real_number, shown, whole_number
from dressing_sim.episode.outcome import Outcome
from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.files import is_file, write_file
from dressing_sim.learning.frame import Situation
from dressing_sim.path import check_metres
from dressing_sim.provenance import provenance, versions

FORMAT = "dressing_sim demonstrations"
FORMAT_VERSION = 1

_VALID = "valid is a file written by 'dressing-sim demonstrate'"


@dataclass(frozen=True, eq=False)
class Demonstration:
    """A path of the gripper with the situation it was recorded in.

    Attributes:
        positions: What the gripper did, shape (T, 3), in the robot's base frame [m].
        dt: Time between two rows [s].
        posture: The arm; its shoulder, elbow and wrist give the frames.
        seed: Seed of the operator's variability.
        commands: Joint commands that were played, shape (T, 7), one each `dt` [rad]; playing them
            in the same world gives the same positions, bit for bit.
        settings: Settings of the world, the robot and the operator, plain values.
        versions: Packages it was recorded with.
        outcome: What became of the episode, if it was recorded just now; files do not hold it.
    """

    positions: NDArray[np.float64]
    dt: float
    posture: Posture
    seed: int
    commands: NDArray[np.float64]
    settings: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=versions)
    outcome: Outcome | None = None

    def __post_init__(self) -> None:
        of_kind(self.posture, Posture, "a demonstration: posture", "a Posture")
        on = f"demonstration on {self.posture.name!r}:"
        for name, width, unit in (("positions", 3, "m"), ("commands", 7, "rad")):
            value = real_array(
                getattr(self, name), ("T", width), f"{on} {name} has", unit, fewest=2
            )
            object.__setattr__(self, name, value)
        check_metres(self.positions, f"{on} has")
        if len(self.positions) != len(self.commands):
            raise InvalidInputError(
                f"{on} {len(self.positions)} positions with {len(self.commands)} commands, valid "
                "is one position after each command"
            )
        # As a file holds them: 1 and 1.0 would have different checksums.
        object.__setattr__(self, "dt", real_number(self.dt, f"{on} dt", 0.0, above=True))
        object.__setattr__(self, "seed", whole_number(self.seed, f"{on} seed"))
        for name in ("settings", "versions"):
            of_kind(getattr(self, name), Mapping, f"{on} {name}", "plain values by name")
        of_kind(self.outcome, (Outcome, NoneType), f"{on} outcome", "an Outcome or None")

    @property
    def frames(self) -> Situation:
        """Frames at the shoulder and at the wrist (see `dressing_sim.Posture.frames`)."""
        return self.posture.frames()


def save_demonstrations(path: str | Path, demonstrations: Sequence[Demonstration]) -> None:
    """Write demonstrations to an HDF5 file; an existing file is replaced, all or nothing.

    One group a demonstration, ``0``, ``1``, ...: datasets ``positions`` (T, 3) [m], ``commands``
    (T, 7) [rad], ``shoulder``, ``elbow``, ``wrist`` (3,) [m]; attributes ``dt`` [s], ``seed``,
    ``posture``, ``settings``, ``versions`` as JSON, and a checksum of all this. An attribute
    ``provenance`` of the file says, as JSON too, what wrote it (see `dressing_sim.provenance`).
    """
    of_kind(path, (str, Path), "path", "a file to write")
    demonstrations = listed(demonstrations, "demonstrations", "a sequence of Demonstrations")
    for one in demonstrations:
        of_kind(one, Demonstration, "one of the demonstrations", "a Demonstration")
    # Made in memory: HDF5 does not come back from a disk that is full.
    with h5py.File(str(path), "w", driver="core", backing_store=False) as file:
        # Texts have a fixed length: HDF5 keeps others in a heap without a checksum, and does not
        # come back from reading a damaged one.
        file.attrs["format"] = np.bytes_(FORMAT)
        file.attrs["format_version"] = FORMAT_VERSION
        file.attrs["provenance"] = _text(provenance())
        for number, demonstration in enumerate(demonstrations):
            group = file.create_group(str(number))
            group["positions"] = demonstration.positions
            group["commands"] = demonstration.commands
            for joint in ("shoulder", "elbow", "wrist"):
                group[joint] = getattr(demonstration.posture, joint)
            group.attrs["dt"] = demonstration.dt
            group.attrs["seed"] = demonstration.seed
            group.attrs["posture"] = _text(demonstration.posture.to_dict())
            group.attrs["settings"] = _text(demonstration.settings)
            group.attrs["versions"] = _text(demonstration.versions)
            group.attrs["sha256"] = np.bytes_(_digest(demonstration))
        file.flush()
        content = file.id.get_file_image()
    write_file(path, content)


def _text(value: object) -> np.bytes_:
    """Plain values as JSON of fixed length; JSON's own escapes keep it ASCII."""
    return np.bytes_(json.dumps(value).encode("ascii"))


def _digest(demonstration: Demonstration) -> str:
    """Checksum of everything in a demonstration; HDF5 alone does not notice a flipped bit."""
    digest = hashlib.sha256()
    for array in (demonstration.positions, demonstration.commands):
        digest.update(np.ascontiguousarray(array, dtype="<f8").tobytes())
    described = [
        demonstration.dt,
        demonstration.seed,
        demonstration.posture.to_dict(),
        demonstration.settings,
        demonstration.versions,
    ]
    digest.update(json.dumps(described, sort_keys=True).encode())
    return digest.hexdigest()


def load_demonstrations(path: str | Path) -> list[Demonstration]:
    """Read demonstrations from a file that `save_demonstrations` wrote.

    Raises:
        InvalidInputError: The file is missing, locked, damaged, of another kind or version, too
            large, or contradicts itself.
    """
    of_kind(path, (str, Path), "a file of demonstrations", "a path")
    if not is_file(path):
        raise InvalidInputError(
            f"{shown(str(path), 200)[1:-1]}: no such file; valid is an HDF5 file of demonstrations"
        )
    check_size(path)
    try:
        with h5py.File(path, "r") as file:
            return _read_all(file)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}; {_VALID}") from error
    except OSError as error:
        raise InvalidInputError(f"{path}: {_why_closed(path, error)}; {_VALID}") from error
    # What h5py, numpy and json raise for a file that is damaged or made by something else.
    except Exception as error:
        raise InvalidInputError(f"{path}: damaged ({one_line(str(error))}); {_VALID}") from error


def _why_closed(path: str | Path, error: OSError) -> str:
    """Why a file does not open: it is another's, closed to us, or none of HDF5's."""
    reason = one_line(str(error))
    if isinstance(error, BlockingIOError) or "unable to lock file" in reason:
        return "locked by another process, which may be writing it"
    if isinstance(error, PermissionError):
        return "cannot be read (permission denied)"
    if not h5py.is_hdf5(path):
        return "not HDF5"
    return f"damaged ({reason})"


def _read_all(file: h5py.File) -> list[Demonstration]:
    if np.bytes_(file.attrs.get("format", "")) != FORMAT.encode():
        raise InvalidInputError("not a file of demonstrations")
    found = _attribute(file, "format_version")
    if found != FORMAT_VERSION:
        newer = " (it is of a newer dressing_sim)" if found > FORMAT_VERSION else ""
        raise InvalidInputError(f"format version {found}, valid is {FORMAT_VERSION}{newer}")
    others = [name for name in file if re.fullmatch(r"0|[1-9]\d{0,6}", name, re.ASCII) is None]
    if others:
        raise InvalidInputError(f"{shown(others[0])} is not the number of a demonstration")
    return [_read(_inside(file, name, h5py.Group)) for name in sorted(file, key=int)]


def _inside(group: h5py.Group, name: str, kind: type) -> Any:
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


def _array(group: h5py.Group, name: str, shape: tuple[int | str, ...]) -> NDArray[np.float64]:
    """An array, once it is known to be of numbers, and not larger than a file may be."""
    data = _inside(group, name, h5py.Dataset)
    size = prod(data.shape or (0,)) * data.dtype.itemsize
    if size > MOST_BYTES or data.dtype.kind not in "iuf" or data.external or data.is_virtual:
        raise InvalidInputError(
            f"{data.name} has shape {data.shape} of {data.dtype}, {size} bytes; valid are at most "
            f"{MOST_BYTES} bytes of real numbers in this file"
        )
    return real_array(data[()], shape, f"{data.name} has")


def _attribute(group: h5py.Group, name: str) -> Any:
    if name not in group.attrs:
        where = "" if group.name == "/" else f" of {group.name}"
        raise InvalidInputError(f"no attribute {name}{where}")
    return group.attrs[name]


def _described(group: h5py.Group, name: str) -> dict[str, Any]:
    """An attribute that is a JSON object."""
    text = _attribute(group, name)
    try:
        value = json.loads(text)
    except (TypeError, ValueError, RecursionError) as error:
        raise InvalidInputError(f"{name} of {group.name} is not JSON") from error
    if not isinstance(value, dict):
        raise InvalidInputError(f"{name} is {shown(value)}, valid is a JSON object")
    return value


def _read(group: h5py.Group) -> Demonstration:
    posture = Posture.from_dict(_described(group, "posture"))
    # The joints are stored for readers that do not know our angles; they must agree with them.
    for joint in ("shoulder", "elbow", "wrist"):
        stored = _array(group, joint, (3,))
        if not np.allclose(stored, getattr(posture, joint), rtol=0.0, atol=1e-9):
            raise InvalidInputError(
                f"the joints of posture {posture.name!r} do not match its angles; the file was "
                "made with another version or edited"
            )
    demonstration = Demonstration(
        positions=_array(group, "positions", ("T", 3)),
        dt=_attribute(group, "dt"),
        posture=posture,
        seed=_attribute(group, "seed"),
        commands=_array(group, "commands", ("T", 7)),
        settings=_described(group, "settings"),
        versions=_described(group, "versions"),
    )
    if np.bytes_(_attribute(group, "sha256")) != _digest(demonstration).encode():
        raise InvalidInputError(
            f"the demonstration on {posture.name!r} does not match its checksum"
        )
    return demonstration
