"""The skeleton of an arm that two frames describe: its elbow and its landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import least_squares

from dressing_sim.arm import Vector, up_across
from dressing_sim.learning import Frame
from dressing_sim.policies.situations import joints

#: How exactly a frame's x axis is known to point at the elbow where nothing tells more [rad].
_AXIS_ERROR = 1e-3

#: Standard deviation of a bone's length among adults, divided by its mean: both sexes together in
#: ANSUR II, whose two have 5 to 6 % each and means 6 to 9 % apart (see `dressing_sim.arm`).
BONE_VARIATION = 0.07


@dataclass(frozen=True, eq=False)
class Skeleton:
    """Two bones.

    Attributes:
        shoulder: (3,) in the robot's base frame [m], as the others.
        elbow: (3,).
        wrist: (3,).
    """

    shoulder: Vector
    elbow: Vector
    wrist: Vector

    @classmethod
    def of(cls, frames: Sequence[Frame], bones: Vector | None = None) -> Self:
        """The arm of a shoulder's and a wrist's frame, whose x axes point at the elbow.

        Without bones the elbow is where the axes meet. With them it is the most likely place: each
        axis errs by an angle, the bones vary by `BONE_VARIATION`,

            sum_i |E - o_i - (x_i . (E - o_i)) x_i|^2 / (l_i a)^2 + (|E - o_i| - l_i)^2 / (l_i v)^2

        is least. Lines that pass each other at a distance g tell the error, a^2 = g^2 / sum l_i^2
        beyond 1 mrad; so the elbow of exact frames is where they meet unless the arm is straight.

        Args:
            frames: Of the shoulder and of the wrist.
            bones: Lengths of upper arm and forearm (2,) [m].

        Raises:
            InvalidInputError: Not two frames in space.
        """
        shoulder, met, wrist = joints(frames)
        if bones is None:
            return cls(shoulder, met, wrist)
        origins = np.stack([shoulder, wrist])
        axes = np.stack([frame.A[:, 0] / np.linalg.norm(frame.A[:, 0]) for frame in frames])
        normal = np.cross(*axes)
        sine = float(np.linalg.norm(normal))
        gap = float((wrist - shoulder) @ normal) / sine if sine > _AXIS_ERROR else 0.0
        error = np.sqrt(_AXIS_ERROR**2 + gap**2 / float(bones @ bones))

        def misfit(elbow: Vector) -> Vector:
            offsets = elbow - origins
            along = np.sum(offsets * axes, axis=1)
            across = (offsets - along[:, None] * axes) / (bones * error)[:, None]
            lengths = np.linalg.norm(offsets, axis=1) / bones - 1.0
            return np.concatenate([across.ravel(), lengths / BONE_VARIATION])

        begin = (origins + bones[:, None] * axes).mean(axis=0)
        return cls(shoulder, least_squares(misfit, begin, method="lm").x, wrist)

    @property
    def forearm(self) -> Vector:
        """Unit vector (3,) from the wrist to the elbow."""
        return (self.elbow - self.wrist) / np.linalg.norm(self.elbow - self.wrist)

    @property
    def upper_arm(self) -> Vector:
        """Unit vector (3,) from the elbow to the shoulder."""
        return (self.shoulder - self.elbow) / np.linalg.norm(self.shoulder - self.elbow)

    @property
    def bones(self) -> Vector:
        """Lengths of upper arm and forearm (2,) [m]."""
        ends = np.stack([self.shoulder, self.wrist])
        return np.asarray(np.linalg.norm(ends - self.elbow, axis=1))

    @property
    def sideways(self) -> float:
        """How far the elbow turns sideways: the part of `forearm` level beside the upper arm."""
        beside = np.cross(up_across(self.upper_arm), self.upper_arm)
        return abs(float(self.forearm @ beside))

    @property
    def bend(self) -> float:
        """How far the elbow is bent: the sine of the angle between the bones' directions."""
        return float(np.linalg.norm(np.cross(self.forearm, self.upper_arm)))

    def onward(self, dip: float) -> Vector:
        """Where a gripper goes on that comes along the forearm to the elbow, (3,).

        Args:
            dip: How much of the forearm's slope from the upper arm it keeps: with 0 it goes on at
                the upper arm's level, with 1 along the forearm.
        """
        up = up_across(self.upper_arm)
        return self.forearm - (1.0 - dip) * (self.forearm @ up) * up

    def landmarks(
        self, height: float, ahead: ArrayLike, dip: float, stations: int
    ) -> NDArray[np.float64]:
        """Places (K, 3) that every arm has, in the robot's base frame [m].

        Args:
            height: Of those over the bones, upwards across them [m]. Those beyond the elbow are as
                high over it if the arm is straight, and at its level if it is bent at a right
                angle or more: a sleeve is led over the one and round the other.
            ahead: Distances beyond the elbow, along `onward` [m].
            dip: Of `onward`.
            stations: On each bone and over it, its ends included.
        """
        share = np.linspace(0.0, 1.0, stations)[:, None]
        on_forearm = self.wrist + share * (self.elbow - self.wrist)
        on_upper = self.elbow + share[1:] * (self.shoulder - self.elbow)
        over_forearm = on_forearm + height * up_across(self.forearm)
        over_upper = on_upper + height * up_across(self.upper_arm)
        over_elbow = max(float(self.forearm @ self.upper_arm), 0.0) * height
        beyond = (
            self.elbow
            + np.asarray(ahead)[:, None] * self.onward(dip)
            + over_elbow * up_across(self.upper_arm)
        )
        return np.concatenate([on_forearm, on_upper, over_forearm, over_upper, beyond])

    def passed(self, points: NDArray[np.float64]) -> int | None:
        """The first row of a path (T, 3) beyond the elbow, as the forearm points.

        None if that is its first row, its last, or none: such a path has no two parts.
        """
        row = int(np.argmax((points - self.elbow) @ self.forearm > 0.0))
        return row if 1 <= row <= len(points) - 2 else None

    def outward(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """From the nearest point of the skeleton to each point, (N, 3) [m]."""
        ends = (self.wrist, self.elbow), (self.elbow, self.shoulder)
        offsets = []
        for begin, end in ends:
            bone = end - begin
            share = np.clip((points - begin) @ bone / (bone @ bone), 0.0, 1.0)
            offsets.append(points - begin - share[:, None] * bone)
        forearm, upper = offsets
        nearer = np.linalg.norm(forearm, axis=1) < np.linalg.norm(upper, axis=1)
        return np.where(nearer[:, None], forearm, upper)
