"""Recorded demonstrations, and the HDF5 file they are kept in."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import h5py
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.episode.outcome import Outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import is_file, write_bytes
from dressing_sim.learning.frame import Situation
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
        for name, width in (("positions", 3), ("commands", 7)):
            value = np.asarray(getattr(self, name), dtype=np.float64)
            object.__setattr__(self, name, value)
            if value.ndim != 2 or value.shape[1] != width or len(value) < 2:
                raise InvalidInputError(
                    f"demonstration on {self.posture.name!r}: {name} has shape {value.shape}, "
                    f"valid is (T, {width}) with T of 2 or more"
                )
            if not np.isfinite(value).all():
                raise InvalidInputError(
                    f"demonstration on {self.posture.name!r}: {name} has values that are not "
                    "finite, valid are numbers"
                )
        if len(self.positions) != len(self.commands):
            raise InvalidInputError(
                f"demonstration on {self.posture.name!r}: {len(self.positions)} positions with "
                f"{len(self.commands)} commands, valid is one position after each command"
            )
        # As a file holds them: 1 and 1.0 would have different checksums.
        object.__setattr__(self, "dt", float(self.dt))
        object.__setattr__(self, "seed", int(self.seed))
        if not 0.0 < self.dt < np.inf:
            raise InvalidInputError(
                f"demonstration on {self.posture.name!r}: dt is {self.dt}, valid is > 0"
            )

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
    write_bytes(path, content)


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
        InvalidInputError: The file is missing, damaged, of another kind, or contradicts itself.
    """
    if not is_file(path):
        raise InvalidInputError(f"{path}: no such file; valid is an HDF5 file of demonstrations")
    try:
        with h5py.File(path, "r") as file:
            if np.bytes_(file.attrs.get("format", "")) != FORMAT.encode():
                raise InvalidInputError("not a file of demonstrations")
            if file.attrs["format_version"] != FORMAT_VERSION:
                found = file.attrs["format_version"]
                raise InvalidInputError(f"format version {found}, valid is {FORMAT_VERSION}")
            return [_read(file[name]) for name in sorted(file, key=int)]
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}; {_VALID}") from error
    # What h5py, numpy and json raise for a file that is damaged or made by something else.
    except (OSError, KeyError, TypeError, ValueError, AttributeError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise InvalidInputError(f"{path}: damaged or not HDF5 ({reason}); {_VALID}") from error


def _read(group: h5py.Group) -> Demonstration:
    described = {
        name: json.loads(group.attrs[name]) for name in ("posture", "settings", "versions")
    }
    for name, value in described.items():
        if not isinstance(value, dict):
            raise InvalidInputError(f"{name} is {value!r:.40}, valid is a JSON object")
    posture = Posture.from_dict(described["posture"])
    # The joints are stored for readers that do not know our angles; they must agree with them.
    for joint in ("shoulder", "elbow", "wrist"):
        if not np.allclose(group[joint][:], getattr(posture, joint), rtol=0.0, atol=1e-9):
            raise InvalidInputError(
                f"the joints of posture {posture.name!r} do not match its angles; the file was "
                "made with another version or edited"
            )
    demonstration = Demonstration(
        positions=group["positions"][:],
        dt=float(group.attrs["dt"]),
        posture=posture,
        seed=int(group.attrs["seed"]),
        commands=group["commands"][:],
        settings=described["settings"],
        versions=described["versions"],
    )
    if np.bytes_(group.attrs["sha256"]) != _digest(demonstration).encode():
        raise InvalidInputError(
            f"the demonstration on {posture.name!r} does not match its checksum"
        )
    return demonstration
