"""How far a sleeve is on an arm, from whole rings of the mesh rather than from single points.

The arm coordinate s is 0 at the wrist, 1 at the elbow and 2 at the shoulder; the hand continues
below 0 and the trunk above 2, each in units of the neighbouring segment's length.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.world.axis_kernels import arm_coordinate, ring_coordinates, windings
from dressing_sim.world.mannequin import HAND_LENGTH

#: How far the arm's axis is prolonged beyond the wrist and the shoulder to count windings, in
#: lengths of the forearm and the upper arm. Longer than any sleeve.
_PROLONGATION = 2.0


@dataclass(frozen=True, slots=True)
class ArmAxis:
    """The polyline wrist, elbow, shoulder.

    Attributes:
        joints: Wrist, elbow, shoulder, shape (3, 3), in the robot's base frame [m].
        reach: How far the arm goes on beyond the wrist and the shoulder, (2,) [m]: the hand's
            length and the upper arm's radius.
    """

    joints: NDArray[np.float64]
    reach: tuple[float, float] = (0.0, 0.0)

    @classmethod
    def of(cls, posture: Posture, joints: NDArray[np.float64] | None = None) -> ArmAxis:
        """The axis of a posture's arm, or of the same arm with its joints (3, 3) elsewhere [m]."""
        if joints is None:
            joints = np.stack([posture.wrist, posture.elbow, posture.shoulder])
        return cls(joints, (HAND_LENGTH, posture.arm_size.upper_arm_radius))

    @property
    def lengths(self) -> NDArray[np.float64]:
        """Lengths (2,) of forearm and upper arm [m]."""
        return np.linalg.norm(np.diff(self.joints, axis=0), axis=1)

    def coordinate(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Arm coordinate s of the nearest point on the axis, prolonged at both ends.

        Args:
            points: Shape (n, 3) [m].

        Returns:
            Shape (n,), unbounded below 0 and above 2.
        """
        s = np.empty(len(points))
        arm_coordinate(np.asarray(points, dtype=float), self.joints, s)
        return s

    def ring_coordinate(self, rings: NDArray[np.float64]) -> NDArray[np.float64]:
        """Arm coordinate s (n_rings,) of the centres of rings (n_rings, n_around, 3) [m]."""
        s = np.empty(len(rings))
        ring_coordinates(rings, self.joints, s)
        return s

    def dressed_ratios(self, s: NDArray[np.float64]) -> NDArray[np.float64]:
        """Shares of the upper arm and of the arm that a sleeve's opening has passed.

        The field's measure (Wang et al., RSS 2023, "One policy to dress them all"): the length of
        the arm between elbow (or wrist) and the sleeve's opening at the shoulder's side, relative
        to the length up to the shoulder. Where the hem is does not matter.

        Args:
            s: Arm coordinate of the opening, shape (n,); NaN where it is not round the arm.

        Returns:
            Shape (n, 2), each from 0 to 1: of the upper arm, and from the wrist to the shoulder.
        """
        on = np.nan_to_num(s, nan=0.0)
        forearm, upper = np.clip(on, 0.0, 1.0), np.clip(on - 1.0, 0.0, 1.0)
        whole = (self.lengths[0] * forearm + self.lengths[1] * upper) / self.lengths.sum()
        return np.stack([upper, whole], axis=1)

    def winding(self, rings: NDArray[np.float64]) -> NDArray[np.int64]:
        """How often each closed ring winds round the arm.

        The Gauss linking number of the ring and the prolonged axis, from the solid angle of each
        pair of segments (Klenin and Langowski, Biopolymers 54, 2000, method 1a). The axis is open,
        but long, so that the sum is near an integer and is rounded.

        Args:
            rings: Closed polygons, shape (..., n_around, 3) [m].

        Returns:
            Shape (...): +1 for a ring of a sleeve that is on, in its mesh's direction; 0 for
            one that is off the arm.
        """
        wrist, elbow, shoulder = self.joints
        chain = np.stack(
            [
                wrist + _PROLONGATION * (wrist - elbow),
                elbow,
                shoulder + _PROLONGATION * (shoulder - elbow),
            ]
        )
        counted = np.empty(rings.shape[:-2], dtype=np.int64)
        windings(rings.reshape(-1, *rings.shape[-2:]), chain, counted.reshape(-1))
        return counted

    def through_triangles(self, rings: NDArray[np.float64]) -> NDArray[np.float64]:
        """The line-triangle test of "dressed", for comparison with whole rings.

        As Assistive Gym (Erickson et al. 2020) and work after it do it: four vertices, a quarter
        of the ring apart, span two triangles, and the sleeve counts as on the arm if the arm's
        axis, from the fingertips to the top of the shoulder, passes through one of them. It sees
        four points of the ring: where the opening folds or tilts so that those move across the
        axis, the answer jumps, though the ring as a whole has hardly moved.

        Args:
            rings: Closed polygons, shape (n_rings, n_around, 3) [m].

        Returns:
            Shape (n_rings,): arm coordinate of the place, the one next to the shoulder of several;
            NaN where the axis passes through neither triangle.
        """
        quarters = np.round(np.arange(4) * rings.shape[1] / 4.0).astype(int)
        corners = rings[:, quarters]
        triangles = np.stack([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]], axis=1)
        forearm, upper = self.lengths
        below, beyond = self.reach[0] / forearm, self.reach[1] / upper
        places = []
        for segment, low, high in ((0, -below, 1.0), (1, 0.0, 1.0 + beyond)):
            start, end = self.joints[segment], self.joints[segment + 1]
            t = _line_through(start, end - start, triangles)
            places.append(np.where((low <= t) & (t <= high), segment + t, -np.inf))
        last = np.max(places, axis=(0, 2))
        return np.where(np.isfinite(last), last, np.nan)


def _line_through(
    origin: NDArray[np.float64], direction: NDArray[np.float64], triangles: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Where a line passes through triangles (..., 3, 3), in units of its direction, or NaN.

    Solves ``origin + t direction = a + u (b - a) + v (c - a)`` by Cramer's rule, with
    ``u, v >= 0`` and ``u + v <= 1`` inside.
    """
    a = triangles[..., 0, :]
    ab, ac = triangles[..., 1, :] - a, triangles[..., 2, :] - a
    normal, offset = _cross(ab, ac), origin - a
    slope = _dot(normal, direction)
    moment = _cross(direction, offset)
    with np.errstate(divide="ignore", invalid="ignore"):  # parallel: infinite, so not inside
        u, v = _dot(ac, moment) / slope, -_dot(ab, moment) / slope
        t = -_dot(normal, offset) / slope
    inside = (u >= 0.0) & (v >= 0.0) & (u + v <= 1.0)
    return np.where(inside, t, np.nan)


def _cross(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cross products along the last axis; for arrays this small faster than numpy's own."""
    ax, ay, az = a[..., 0], a[..., 1], a[..., 2]
    bx, by, bz = b[..., 0], b[..., 1], b[..., 2]
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dot products along the last axis, to the bit the same however many there are."""
    return a[..., 0] * b[..., 0] + a[..., 1] * b[..., 1] + a[..., 2] * b[..., 2]
