"""From a lab's recording to a demonstration: turned, placed, mirrored, resampled, trimmed."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from dressing_sim.arm import (
    ANGLE_LIMITS_DEG,
    ARM_SIZES,
    DEFAULT_SHOULDER,
    FORWARD,
    LEFT,
    UP,
    ArmSize,
    Posture,
)
from dressing_sim.checks import of_kind, real_number, truth_value
from dressing_sim.config import to_plain
from dressing_sim.datasets.recording import LabRecording
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.registration import at_times

Array = NDArray[np.float64]

#: More rows are in no demonstration.
MOST_ROWS = 100_000

#: A pause is a gripper slower than this [m/s] for at least so long [s]; its speed is measured over
#: a window [s]. Own choices: the operator moves at 0.1 m/s, and its tremor at 1 mm/s.
STILL_SPEED, SHORTEST_PAUSE, SPEED_WINDOW = 0.01, 0.5, 0.2

#: Straighter arms tell nothing about the rotation of the upper arm [rad].
_STRAIGHT = 1e-3


@dataclass(frozen=True, slots=True)
class ImportConfig:
    """How a recording becomes a demonstration."""

    dt: float = 0.02
    """Time between two rows of the demonstration [s]."""
    turn_deg: float = 0.0
    """The recording is turned by this about the vertical, so that the person looks along +y."""
    mirror: bool = False
    """A right arm becomes a left one: left and right of the person are exchanged."""
    keep_place: bool = False
    """The recording's frame is that of the simulator's robot; else it is moved until the shoulder
    is in its usual place."""
    trim_pauses: bool = False
    """Rows in which the gripper rests are left out, at the ends and in between."""
    max_gap: float = 0.5
    """Longest time without a row [s]."""
    size: ArmSize = ARM_SIZES["male"]
    """Of whom the radii of the arm are; its lengths are those of the recording."""

    def __post_init__(self) -> None:
        real_number(self.dt, "import: dt", 1e-3, 1.0)
        real_number(self.turn_deg, "import: turn_deg", -360.0, 360.0)
        real_number(self.max_gap, "import: max_gap", 0.0, above=True)
        for name in ("mirror", "keep_place", "trim_pauses"):
            truth_value(getattr(self, name), f"import: {name}")
        of_kind(self.size, ArmSize, "import: size", "an ArmSize")


def demonstration_of(
    recording: LabRecording, config: ImportConfig, source: dict[str, str] | None = None
) -> Demonstration:
    """The demonstration that a recording is.

    Args:
        recording: What a lab recorded.
        config: How it is read.
        source: What is known of its file, for the demonstration's settings.

    Raises:
        InvalidInputError: A gap, nothing but rest, or an arm that no left arm can be.
    """
    placed = _placed(recording, config)
    posture = posture_of(recording.name, placed.shoulder, placed.elbow, placed.wrist, config.size)
    rows = _resampled(placed, config)
    if config.trim_pauses:
        kept = moving_rows(rows.gripper, config.dt)
        rows = replace(
            rows,
            times=rows.times[: kept.sum()],
            gripper=rows.gripper[kept],
            quaternion=None if rows.quaternion is None else rows.quaternion[kept],
            force=None if rows.force is None else rows.force[kept],
        )
    return Demonstration(
        positions=rows.gripper,
        dt=config.dt,
        posture=posture,
        seed=0,
        commands=None,
        settings={"import": {**to_plain(config), **(source or {})}},
        orientations=rows.quaternion,
        forces=rows.force,
    )


def _placed(recording: LabRecording, config: ImportConfig) -> LabRecording:
    """The recording in the frame of the simulator's robot, with a left arm in it."""
    turn = Rotation.from_rotvec([0.0, 0.0, np.deg2rad(config.turn_deg)])
    shoulder = turn.apply(recording.shoulder)
    goal = shoulder if config.keep_place else np.array(DEFAULT_SHOULDER)
    # Left and right of a person who looks along +y are exchanged by the sign of x.
    flip = np.array([-1.0 if config.mirror else 1.0, 1.0, 1.0])

    def moved(places: Array) -> Array:
        return np.asarray(goal + flip * (turn.apply(places) - shoulder))

    quaternion, force = recording.quaternion, recording.force
    if quaternion is not None:
        turned = (turn * Rotation.from_quat(quaternion)).as_quat()
        # S R S turns by the same angle about the axis (x, -y, -z).
        quaternion = turned * np.array([1.0, flip[0], flip[0], 1.0])
    return replace(
        recording,
        gripper=moved(recording.gripper),
        shoulder=moved(recording.shoulder),
        elbow=moved(recording.elbow),
        wrist=moved(recording.wrist),
        quaternion=quaternion,
        force=None if force is None else flip * turn.apply(force),
    )


def posture_of(name: str, shoulder: Array, elbow: Array, wrist: Array, size: ArmSize) -> Posture:
    """The posture whose joints are at these places (3,) [m]; the inverse of `Posture.wrist`.

    With the body's axes as a basis the upper arm's orientation is R = Ry(-flexion) Rx(abduction)
    Rz(-rotation); the third column is against the upper arm, the first in the plane of the bend.

    Args:
        name: Of the posture.
        shoulder: Where the shoulder joint is.
        elbow: The elbow joint.
        wrist: The wrist joint.
        size: Radii of the arm; its lengths are those between the joints.

    Raises:
        InvalidInputError: No left arm of somebody who looks along +y can be like that.
    """
    upper, fore = elbow - shoulder, wrist - elbow
    lengths = float(np.linalg.norm(upper)), float(np.linalg.norm(fore))
    up, ahead = -upper / lengths[0], fore / lengths[1]
    bend = float(np.arctan2(np.linalg.norm(np.cross(up, ahead)), -up @ ahead))
    body = np.column_stack([FORWARD, LEFT, UP])
    if bend > _STRAIGHT:
        forward = ahead - (ahead @ up) * up
        forward /= np.linalg.norm(forward)
        basis = body.T @ np.column_stack([forward, np.cross(up, forward), up])
        turns = [np.arctan2(basis[0, 2], basis[2, 2]), np.arcsin(np.clip(-basis[1, 2], -1.0, 1.0))]
        turns.append(np.arctan2(basis[1, 0], basis[1, 1]))
    else:
        x, y, z = body.T @ up
        turns = [np.arctan2(x, z), np.arcsin(np.clip(-y, -1.0, 1.0)), 0.0]
    flexion, abduction, rotation = np.rad2deg([-turns[0], turns[1], -turns[2]])
    half_turn = 180.0 if bend > _STRAIGHT else 0.0
    own = replace(size, upper_arm_length=lengths[0], forearm_length=lengths[1])
    error: InvalidInputError | None = None
    # Two triples of angles turn alike; limits tell which is meant.
    for angles in (
        (flexion, abduction, rotation),
        (flexion + 180.0, 180.0 - abduction, rotation + half_turn),
    ):
        wrapped = [180.0 - (180.0 - angle) % 360.0 for angle in angles]
        inside = [
            float(np.clip(angle, *limits)) if abs(np.clip(angle, *limits) - angle) < 1e-6 else angle
            for angle, limits in zip(
                [*wrapped, np.rad2deg(bend)], ANGLE_LIMITS_DEG.values(), strict=True
            )
        ]
        try:
            x, y, z = shoulder.tolist()
            one, two, three, four = map(float, inside)
            return Posture(name, one, two, three, four, own, (x, y, z))
        except InvalidInputError as wrong:
            error = error or wrong
    raise InvalidInputError(
        f"{error} (does the person look along +y after --turn-deg, and is it a left arm, or a right"
        " one with --mirror?)"
    )


def _resampled(recording: LabRecording, config: ImportConfig) -> LabRecording:
    """The same recording at even times."""
    times, gaps = recording.times, np.diff(recording.times)
    longest = int(np.argmax(gaps))
    if gaps[longest] > config.max_gap:
        raise InvalidInputError(
            f"nothing for {gaps[longest]:.3g} s after row {longest}, valid is at most "
            f"{config.max_gap:g} s (--max-gap)"
        )
    count = int(np.floor((times[-1] - times[0]) / config.dt + 1e-9)) + 1
    if not 3 <= count <= MOST_ROWS:
        raise InvalidInputError(
            f"{times[-1] - times[0]:.4g} s are {count} rows of {config.dt:g} s, valid are 3 to "
            f"{MOST_ROWS} rows"
        )
    wanted = np.minimum(times[0] + config.dt * np.arange(count), times[-1])

    quaternion, force = recording.quaternion, recording.force
    if quaternion is not None:
        quaternion = Slerp(times, Rotation.from_quat(quaternion))(wanted).as_quat()
    return replace(
        recording,
        times=np.arange(count) * np.float64(config.dt),
        gripper=at_times(recording.gripper, times, wanted),
        quaternion=quaternion,
        force=None if force is None else at_times(force, times, wanted),
    )


def moving_rows(positions: Array, dt: float) -> NDArray[np.bool_]:
    """Which rows of a path (T, 3) are no part of a pause; of each pause one row is left."""
    half = max(1, round(0.5 * SPEED_WINDOW / dt))
    rows = np.arange(len(positions))
    before, after = np.maximum(rows - half, 0), np.minimum(rows + half, len(rows) - 1)
    way = np.linalg.norm(positions[after] - positions[before], axis=1)
    still = way < STILL_SPEED * dt * (after - before)
    kept = np.ones(len(positions), dtype=np.bool_)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], still.astype(int), [0]])))
    for begin, end in edges.reshape(-1, 2):
        if (end - begin) * dt >= SHORTEST_PAUSE:
            kept[begin + (begin > 0) : end - (begin == 0)] = False
    if kept.sum() < 3:
        raise InvalidInputError("the gripper rests all the time, valid is one that moves")
    return kept
