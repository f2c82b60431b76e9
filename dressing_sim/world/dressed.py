"""How far a sleeve is on an arm, from whole rings of the mesh rather than from single points.

The arm coordinate s is 0 at the wrist, 1 at the elbow and 2 at the shoulder; the hand continues
below 0 and the trunk above 2, each in units of the neighbouring segment's length.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture

#: How far the arm's axis is prolonged beyond the wrist and the shoulder to count windings, in
#: lengths of the forearm and the upper arm. Longer than any sleeve.
_PROLONGATION = 2.0


@dataclass(frozen=True, slots=True)
class ArmAxis:
    """The polyline wrist, elbow, shoulder.

    Attributes:
        joints: Wrist, elbow, shoulder, shape (3, 3), in the robot's base frame [m].
    """

    joints: NDArray[np.float64]

    @classmethod
    def of(cls, posture: Posture) -> ArmAxis:
        """The axis of a posture's arm."""
        return cls(np.stack([posture.wrist, posture.elbow, posture.shoulder]))

    def coordinate(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Arm coordinate s of the nearest point on the axis, prolonged at both ends.

        Args:
            points: Shape (n, 3) [m].

        Returns:
            Shape (n,), unbounded below 0 and above 2.
        """
        wrist, elbow, shoulder = self.joints
        forearm, upper = elbow - wrist, shoulder - elbow
        s1 = np.minimum((points - wrist) @ forearm / (forearm @ forearm), 1.0)
        s2 = np.maximum((points - elbow) @ upper / (upper @ upper), 0.0)
        d1 = np.linalg.norm(points - (wrist + s1[:, None] * forearm), axis=1)
        d2 = np.linalg.norm(points - (elbow + s2[:, None] * upper), axis=1)
        return np.where(d1 <= d2, s1, 1.0 + s2)

    def winding(self, rings: NDArray[np.float64]) -> NDArray[np.int64]:
        """How often each closed ring winds round the arm.

        The linking number of the ring and the arm's axis: the signed number of times that the
        prolonged axis crosses the fan of triangles between the ring and its centre.

        Args:
            rings: Closed polygons, shape (n_rings, n_around, 3) [m].

        Returns:
            Shape (n_rings,): +1 for a ring of a sleeve that is on, in its mesh's direction; 0 for
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
        centre = rings.mean(axis=1, keepdims=True)
        a = rings - centre
        b = np.roll(rings, -1, axis=1) - centre
        total = np.zeros(len(rings), dtype=np.int64)
        for start, end in pairwise(chain):
            total -= _crossings(start - centre, end - centre, a, b).sum(axis=1)
        return total


def _crossings(
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    a: NDArray[np.float64],
    b: NDArray[np.float64],
) -> NDArray[np.int64]:
    """Signed crossings of segments with triangles (0, a, b); +1 along their normal a x b."""
    direction = end - start
    normal = np.cross(a, b)
    along = np.einsum("...i,...i", normal, direction)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = -np.einsum("...i,...i", normal, start) / along
        point = start + t[..., None] * direction
        square = np.einsum("...i,...i", normal, normal)
        alpha = np.einsum("...i,...i", np.cross(point, b), normal) / square
        beta = np.einsum("...i,...i", np.cross(a, point), normal) / square
    inside = (alpha >= 0.0) & (beta >= 0.0) & (alpha + beta <= 1.0) & (t >= 0.0) & (t < 1.0)
    return np.where(inside, np.sign(along), 0.0).astype(np.int64)
