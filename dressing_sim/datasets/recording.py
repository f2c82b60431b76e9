"""What a lab recorded: where a gripper was and when, and the arm that it dressed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import SIZE_LIMITS, gravity_frame
from dressing_sim.checks import real_array, shown
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame
from dressing_sim.policies.situations import joints

Array = NDArray[np.float64]

#: Columns of each quantity; ``time`` has one number a row.
QUANTITIES: Mapping[str, int] = {
    "gripper": 3,
    "quaternion": 4,
    "force": 3,
    "shoulder": 3,
    "elbow": 3,
    "wrist": 3,
    "shoulder_quaternion": 4,
    "wrist_quaternion": 4,
}

#: The arm that is dressed may move by so much in a recording [m]. Own choice.
STATIC = 0.05

#: Faster than any gripper near a person, in the median [m/s]; farther than any arm reaches [m].
FASTEST, FARTHEST = 2.0, 2.0

#: The norm of a quaternion differs from 1 by at most this.
UNIT_NORM = 0.02


@dataclass(frozen=True, eq=False)
class LabRecording:
    """One dressing as a lab recorded it, in a frame of the lab's whose z axis points up.

    Attributes:
        name: What it is called.
        times: Of the rows, (T,), rising [s].
        gripper: Positions (T, 3) [m].
        shoulder: Joint (3,) [m], as the others.
        elbow: Joint (3,).
        wrist: Joint (3,).
        quaternion: Orientation of the gripper, (T, 4) as x, y, z, w, or None.
        force: On the gripper, (T, 3), in the lab's frame [N], or None.

    Raises:
        InvalidInputError: Times that do not rise, too few rows, or numbers that cannot be metres,
            seconds or an arm.
    """

    name: str
    times: Array
    gripper: Array
    shoulder: Array
    elbow: Array
    wrist: Array
    quaternion: Array | None = None
    force: Array | None = None

    def __post_init__(self) -> None:
        times = real_array(self.times, ("T",), "time has", "s", fewest=3)
        wrong = np.flatnonzero(np.diff(times) <= 0.0)
        if len(wrong):
            raise InvalidInputError(
                f"time does not rise from row {wrong[0]} to the next ({times[wrong[0]]:.6f} s to "
                f"{times[wrong[0] + 1]:.6f} s), valid are rising times"
            )
        for name in ("gripper", "quaternion", "force"):
            value = getattr(self, name)
            if value is not None:
                real_array(value, (len(times), QUANTITIES[name]), f"{name} has")
        if self.quaternion is not None:
            object.__setattr__(self, "quaternion", unit_quaternions(self.quaternion, "quaternion"))
        self._check_units()

    def _check_units(self) -> None:
        """Metres and seconds have sizes that can be recognised."""
        for name, start, end in (
            ("upper_arm_length", self.shoulder, self.elbow),
            ("forearm_length", self.elbow, self.wrist),
        ):
            length, (low, high) = float(np.linalg.norm(end - start)), SIZE_LIMITS[name]
            if not low <= length <= high:
                raise InvalidInputError(
                    f"{name} is {length:.4g} m, valid is {low:g} to {high:g} m (are the arm's "
                    "places in another unit, or in another frame?)"
                )
        away = float(np.linalg.norm(self.gripper - self.shoulder, axis=1).min())
        if away > FARTHEST:
            raise InvalidInputError(
                f"the gripper stays {away:.4g} m or more from the shoulder, valid is to come within"
                f" {FARTHEST:g} m (is it in another unit, or in another frame?)"
            )
        steps = np.linalg.norm(np.diff(self.gripper, axis=0), axis=1) / np.diff(self.times)
        moving = steps[steps > 0.0]
        speed = float(np.median(moving)) if len(moving) else 0.0
        if not 0.0 < speed <= FASTEST:
            raise InvalidInputError(
                f"the gripper's median speed is {speed:.4g} m/s, valid is above 0 to {FASTEST:g} "
                "m/s (are times or places in another unit?)"
            )


def unit_quaternions(values: Array, name: str) -> Array:
    """Quaternions (T, 4) of norm 1, each nearer to the one before than its negative is.

    Raises:
        InvalidInputError: The norm of one is not about 1.
    """
    norms = np.linalg.norm(values, axis=1)
    if np.any(np.abs(norms - 1.0) > UNIT_NORM):
        odd = float(norms[np.argmax(np.abs(norms - 1.0))])
        raise InvalidInputError(
            f"{name} has norm {odd:.4g}, valid are unit quaternions as x, y, z, w"
        )
    unit = values / norms[:, None]
    turns = np.sum(unit[1:] * unit[:-1], axis=1) < 0.0
    signs = np.where(np.cumsum(np.concatenate([[False], turns])) % 2, -1.0, 1.0)
    return unit * signs[:, None]


def of_columns(name: str, columns: Mapping[str, Array]) -> LabRecording:
    """A recording of quantities by name: ``time`` (T,) and some of `QUANTITIES`, (T, n) or (n,).

    Without an elbow, the frames of shoulder and wrist tell it: their x axes point at it.

    Raises:
        InvalidInputError: A quantity is missing or not valid, see `LabRecording`.
    """
    missing = [one for one in ("time", "gripper", "shoulder", "wrist") if one not in columns]
    if missing:
        raise InvalidInputError(
            f"no {missing[0]}; valid is a recording of time, gripper, shoulder, wrist, and elbow"
        )
    still = {
        one: _static(one, columns[one])
        for one in ("shoulder", "elbow", "wrist", "shoulder_quaternion", "wrist_quaternion")
        if one in columns
    }
    if "elbow" not in still:
        still["elbow"] = _elbow(still)
    return LabRecording(
        name,
        columns["time"],
        columns["gripper"],
        still["shoulder"],
        still["elbow"],
        still["wrist"],
        columns.get("quaternion"),
        columns.get("force"),
    )


def _static(name: str, values: Array) -> Array:
    """Where a part of the arm is, (n,), of all rows."""
    rows = real_array(values, None, f"{name} has")
    rows = real_array(np.atleast_2d(rows), ("T", QUANTITIES[name]), f"{name} has", fewest=1)
    if name.endswith("quaternion"):
        rows = unit_quaternions(rows, name)
    middle = np.median(rows, axis=0)
    moved = float(np.linalg.norm(rows - middle, axis=1).max())
    if moved > STATIC and not name.endswith("quaternion"):
        raise InvalidInputError(
            f"{name} moves by {moved:.3g} m, valid is an arm that stays within {STATIC:g} m"
        )
    return np.asarray(middle)


def _elbow(places: Mapping[str, Array]) -> Array:
    from scipy.spatial.transform import Rotation

    frames = []
    for joint in ("shoulder", "wrist"):
        if f"{joint}_quaternion" not in places:
            raise InvalidInputError(
                "no elbow; valid is elbow, or shoulder_quaternion and wrist_quaternion, whose x "
                "axes point at it"
            )
        x = Rotation.from_quat(places[f"{joint}_quaternion"]).as_matrix()[:, 0]
        axes = gravity_frame(places[joint], places[joint] + x).A
        frames.append(Frame(axes, places[joint]))
    elbow = joints(frames)[1]
    if not np.isfinite(elbow).all():
        raise InvalidInputError(f"the arm's frames meet at {shown(elbow.tolist())}, at no elbow")
    return elbow
