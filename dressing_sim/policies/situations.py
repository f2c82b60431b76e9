"""Situations as a policy may read them: the arm between two frames, and random possible arms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.arm import ANGLE_LIMITS_DEG, Vector, situation
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    DemonstrationLike,
    Frame,
    Policy,
    Situation,
    SyntheticDemonstration,
    TimedPath,
)
from dressing_sim.learning.sampling import SituationSampler, arcs

#: The plane of an arm straighter than this is not trusted [deg].
STRAIGHT_DEG = 1.0


def joints(frames: Sequence[Frame]) -> tuple[Vector, Vector, Vector]:
    """Shoulder, elbow and wrist (3,) in [m] of the arm that two frames describe.

    The x axes point at the elbow, so it is where their lines meet (of lines that pass each other:
    half-way between their nearest points). In a straight arm that could be anywhere between the
    frames, and is half-way.

    Raises:
        InvalidInputError: Not two frames in space.
    """
    if len(frames) != 2 or any(frame.dimension != 3 for frame in frames):
        raise InvalidInputError(
            f"the situation of an arm has 2 frames in space, the shoulder's and the wrist's, not "
            f"{len(frames)} of dimension {[frame.dimension for frame in frames]}"
        )
    shoulder, wrist = frames[0].b, frames[1].b
    along = np.column_stack([frame.A[:, 0] / np.linalg.norm(frame.A[:, 0]) for frame in frames])
    if np.linalg.norm(np.cross(*along.T)) < np.sin(np.deg2rad(STRAIGHT_DEG)):
        return shoulder, (shoulder + wrist) / 2.0, wrist
    steps = np.linalg.lstsq(along * [1.0, -1.0], wrist - shoulder, rcond=None)[0]
    elbow = (shoulder + steps[0] * along[:, 0] + wrist + steps[1] * along[:, 1]) / 2.0
    return shoulder, elbow, wrist


def in_arm_plane(frames: Sequence[Frame]) -> Situation:
    """The same two frames, turned about their x axes until z is the normal of the arm's plane.

    An elbow bends one way only, so the normal ``x_shoulder x x_wrist`` does not flip. A straight
    arm has no plane: its frames stay as they are.
    """
    normal = np.cross(frames[0].A[:, 0], frames[1].A[:, 0])
    length = np.linalg.norm(normal)
    given = Situation.of(frames)
    if length < np.sin(np.deg2rad(STRAIGHT_DEG)):
        return given
    z = normal / length
    turned = [
        Frame(np.column_stack([frame.A[:, 0], np.cross(z, frame.A[:, 0]), z]), frame.b)
        for frame in given
    ]
    return Situation.of(turned, given.names)


def in_arm_planes(demonstrations: Sequence[DemonstrationLike]) -> list[DemonstrationLike]:
    """The demonstrations with their frames turned by `in_arm_plane`."""
    return [
        SyntheticDemonstration(d.positions, d.dt, in_arm_plane(d.frames)) for d in demonstrations
    ]


@dataclass(frozen=True, eq=False)
class ArmSampler:
    """Draws possible arms around the demonstrated ones: both frames belong to one arm.

    Everything is uniform within bounds: the shoulder in a box, the lengths of the two limbs, their
    azimuths and their slopes. Arms whose elbow would bend too far are drawn again.

    Attributes:
        low: Least shoulder (3), lengths of upper arm and forearm (2) [m], and azimuth and slope of
            upper arm and forearm (4) [rad], shape (9,).
        high: The greatest.
    """

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @classmethod
    def around(
        cls,
        demonstrations: Sequence[DemonstrationLike],
        angle_margin: float = np.deg2rad(10.0),
        translation_margin: float = 0.25,
    ) -> Self:
        """Bounds that just hold the demonstrated arms, and a margin.

        Args:
            demonstrations: At least one, with an arm's two frames.
            angle_margin: Added on both sides of each angle [rad].
            translation_margin: Added on both sides of the shoulder and the lengths, as a fraction
                of each coordinate's range.
        """
        values = np.array([_coordinates(demonstration.frames) for demonstration in demonstrations])
        for azimuth in (5, 7):  # clear of the wrap at 180 degrees
            values[:, [azimuth]] = arcs(values[:, [azimuth]])
        low, high = values.min(axis=0), values.max(axis=0)
        slack = np.append(translation_margin * (high - low)[:5], np.full(4, angle_margin))
        low, high = low - slack, high + slack
        low[[6, 8]] = np.maximum(low[[6, 8]], -np.pi / 2.0)
        high[[6, 8]] = np.minimum(high[[6, 8]], np.pi / 2.0)
        return cls(low, high)

    def sample(self, rng: np.random.Generator) -> Situation:
        """Gravity-aligned frames of a random arm."""
        farthest = np.cos(np.deg2rad(ANGLE_LIMITS_DEG["elbow_deg"][1]))
        while True:
            values = rng.uniform(self.low, self.high)
            upper, fore = _direction(*values[5:7]), _direction(*values[7:9])
            if upper @ fore >= farthest:
                elbow = values[:3] + values[3] * upper
                return situation(values[:3], elbow, elbow + values[4] * fore)


def _coordinates(frames: Sequence[Frame]) -> NDArray[np.float64]:
    shoulder, elbow, wrist = joints(frames)
    limbs = elbow - shoulder, wrist - elbow
    lengths = [float(np.linalg.norm(limb)) for limb in limbs]
    angles = [
        angle
        for limb, length in zip(limbs, lengths, strict=True)
        for angle in (np.arctan2(limb[1], limb[0]), np.arcsin(limb[2] / length))
    ]
    return np.array([*shoulder, *lengths, *angles])


def _direction(azimuth: float, slope: float) -> Vector:
    return np.array(
        [np.cos(slope) * np.cos(azimuth), np.cos(slope) * np.sin(azimuth), np.sin(slope)]
    )


@dataclass(frozen=True, eq=False)
class InArmPlane:
    """A sampler's situations, turned by `in_arm_plane`."""

    sampler: SituationSampler

    def sample(self, rng: np.random.Generator) -> Situation:
        """A random situation."""
        return in_arm_plane(self.sampler.sample(rng))


class ArmPlanePolicy:
    """A policy that sees every situation in the arm's plane instead of aligned with gravity.

    Args:
        policy: The policy; it sees what `in_arm_plane` makes of the frames.
    """

    def __init__(self, policy: Policy) -> None:
        self.policy = policy

    @property
    def dt(self) -> float | None:
        """Time between the samples of a path in [s], if the policy has one."""
        return getattr(self.policy, "dt", None)

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from the demonstrations in turned frames."""
        self.policy.fit(in_arm_planes(demonstrations))
        return self

    def generate(
        self, frames: Sequence[Frame], start: ArrayLike
    ) -> NDArray[np.float64] | TimedPath:
        """The policy's path (T, 3) for the situation in turned frames."""
        return self.policy.generate(in_arm_plane(frames), start)
