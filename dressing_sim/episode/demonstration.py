"""Recorded demonstrations, and the HDF5 file they are kept in."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import NoneType
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import listed, of_kind, real_array, real_number, shown, whole_number
from dressing_sim.episode.hdf5 import array_of, attribute, described, inside, opened, plain_text
from dressing_sim.episode.outcome import Outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import is_file, plain_path, write_file
from dressing_sim.learning.frame import Situation
from dressing_sim.path import check_metres
from dressing_sim.provenance import provenance, versions

FORMAT = "dressing_sim demonstrations"

#: Version 2 has files whose demonstrations lack commands, or have orientations or forces.
FORMAT_VERSION = 2

_VALID = "valid is a file written by 'dressing-sim demonstrate' or 'dressing-sim import'"

#: What a demonstration may have besides positions: its columns and their unit.
_OPTIONAL: Mapping[str, tuple[int | str, str]] = {
    "commands": ("n", "rad"),
    "orientations": (4, "1"),
    "forces": (3, "N"),
}


@dataclass(frozen=True, eq=False)
class Demonstration:
    """A path of the gripper with the situation it was recorded in.

    Attributes:
        positions: What the gripper did, shape (T, 3), in the robot's base frame [m].
        dt: Time between two rows [s].
        posture: The arm; its shoulder, elbow and wrist give the frames.
        seed: Seed of the operator's variability.
        commands: Joint commands that were played, shape (T, n), one each `dt` [rad]; playing them
            in the same world gives the same positions, bit for bit. None for a recording of
            another robot, or of a hand.
        settings: Settings of the world, the robot and the operator, plain values.
        versions: Packages it was recorded with.
        outcome: What became of the episode, if it was recorded just now; files do not hold it.
        orientations: Of the gripper, quaternions (T, 4) as x, y, z, w in the robot's base frame, if
            they were recorded.
        forces: On the gripper, (T, 3), in the robot's base frame [N], if they were recorded.
    """

    positions: NDArray[np.float64]
    dt: float
    posture: Posture
    seed: int
    commands: NDArray[np.float64] | None
    settings: Mapping[str, Any] = field(default_factory=dict)
    versions: Mapping[str, str] = field(default_factory=versions)
    outcome: Outcome | None = None
    orientations: NDArray[np.float64] | None = None
    forces: NDArray[np.float64] | None = None

    def __post_init__(self) -> None:
        of_kind(self.posture, Posture, "a demonstration: posture", "a Posture")
        on = f"demonstration on {self.posture.name!r}:"
        for name, (width, unit) in {"positions": (3, "m"), **_OPTIONAL}.items():
            given = getattr(self, name)
            if given is None and name in _OPTIONAL:
                continue
            value = real_array(given, ("T", width), f"{on} {name} has", unit, fewest=2)
            object.__setattr__(self, name, value)
            if len(value) != len(self.positions):
                others = "" if name == "commands" else " and one of all else"
                raise InvalidInputError(
                    f"{on} {len(self.positions)} positions with {len(value)} {name}, valid is one "
                    f"position after each command{others}"
                )
        check_metres(self.positions, f"{on} has")
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

    @property
    def optional(self) -> dict[str, NDArray[np.float64]]:
        """What it has of commands, orientations and forces, by name."""
        found = {name: getattr(self, name) for name in _OPTIONAL}
        return {name: array for name, array in found.items() if array is not None}


def save_demonstrations(path: str | Path, demonstrations: Sequence[Demonstration]) -> None:
    """Write demonstrations to an HDF5 file; an existing file is replaced, all or nothing.

    One group a demonstration, ``0``, ``1``, ...: datasets ``positions`` (T, 3) [m], ``commands``
    (T, n) [rad], ``orientations`` (T, 4) and ``forces`` (T, 3) [N] if it has them, ``shoulder``,
    ``elbow``, ``wrist`` (3,) [m]; attributes ``dt`` [s], ``seed``, ``posture``, ``settings``,
    ``versions`` as JSON, and a checksum of all this. An attribute ``provenance`` of the file says,
    as JSON too, what wrote it (see `dressing_sim.provenance`). ``format_version`` is 1 if each has
    commands and nothing that version 1 does not know.
    """
    target = plain_path(of_kind(path, (str, Path), "path", "a file to write"))
    demonstrations = listed(demonstrations, "demonstrations", "a sequence of Demonstrations")
    for one in demonstrations:
        of_kind(one, Demonstration, "one of the demonstrations", "a Demonstration")
    # Made in memory: HDF5 does not come back from a disk that is full.
    with h5py.File(str(target), "w", driver="core", backing_store=False) as file:
        # Texts have a fixed length: HDF5 keeps others in a heap without a checksum, and does not
        # come back from reading a damaged one.
        file.attrs["format"] = np.bytes_(FORMAT)
        plain = all([*one.optional] == ["commands"] for one in demonstrations)
        file.attrs["format_version"] = 1 if plain else FORMAT_VERSION
        file.attrs["provenance"] = plain_text(provenance())
        for number, demonstration in enumerate(demonstrations):
            group = file.create_group(str(number))
            group["positions"] = demonstration.positions
            for name, array in demonstration.optional.items():
                group[name] = array
            for joint in ("shoulder", "elbow", "wrist"):
                group[joint] = getattr(demonstration.posture, joint)
            group.attrs["dt"] = demonstration.dt
            group.attrs["seed"] = demonstration.seed
            group.attrs["posture"] = plain_text(demonstration.posture.to_dict())
            group.attrs["settings"] = plain_text(demonstration.settings)
            group.attrs["versions"] = plain_text(demonstration.versions)
            group.attrs["sha256"] = np.bytes_(_digest(demonstration))
        file.flush()
        content = file.id.get_file_image()
    write_file(path, content)


def _digest(demonstration: Demonstration) -> str:
    """Checksum of everything in a demonstration; HDF5 alone does not notice a flipped bit."""
    digest = hashlib.sha256()
    for name, array in {"positions": demonstration.positions, **demonstration.optional}.items():
        digest.update(b"" if name in ("positions", "commands") else name.encode())
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
    with opened(path, f"; {_VALID}") as file:
        return _read_all(file)


def _read_all(file: h5py.File) -> list[Demonstration]:
    if np.bytes_(file.attrs.get("format", "")) != FORMAT.encode():
        raise InvalidInputError("not a file of demonstrations")
    found = attribute(file, "format_version")
    if found not in (1, FORMAT_VERSION):
        newer = " (it is of a newer dressing_sim)" if found > FORMAT_VERSION else ""
        raise InvalidInputError(f"format version {found}, valid is 1 to {FORMAT_VERSION}{newer}")
    others = [name for name in file if re.fullmatch(r"0|[1-9]\d{0,6}", name, re.ASCII) is None]
    if others:
        raise InvalidInputError(f"{shown(others[0])} is not the number of a demonstration")
    return [_read(inside(file, name, h5py.Group)) for name in sorted(file, key=int)]


def _read(group: h5py.Group) -> Demonstration:
    posture = Posture.from_dict(described(group, "posture"))
    # The joints are stored for readers that do not know our angles; they must agree with them.
    for joint in ("shoulder", "elbow", "wrist"):
        stored = array_of(group, joint, (3,))
        if not np.allclose(stored, getattr(posture, joint), rtol=0.0, atol=1e-9):
            raise InvalidInputError(
                f"the joints of posture {posture.name!r} do not match its angles; the file was "
                "made with another version or edited"
            )
    optional = {
        name: array_of(group, name, ("T", width))
        for name, (width, _) in _OPTIONAL.items()
        if name in group or (name == "commands" and group.file.attrs["format_version"] == 1)
    }
    demonstration = Demonstration(
        positions=array_of(group, "positions", ("T", 3)),
        dt=attribute(group, "dt"),
        posture=posture,
        seed=attribute(group, "seed"),
        commands=optional.get("commands"),
        settings=described(group, "settings"),
        versions=described(group, "versions"),
        orientations=optional.get("orientations"),
        forces=optional.get("forces"),
    )
    if np.bytes_(attribute(group, "sha256")) != _digest(demonstration).encode():
        raise InvalidInputError(
            f"the demonstration on {posture.name!r} does not match its checksum"
        )
    return demonstration
