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

        The Gauss linking number of the ring and the prolonged axis, from the solid angle of each
        pair of segments (Klenin and Langowski, Biopolymers 54, 2000, method 1a). The axis is open,
        but long, so that the sum is near an integer and is rounded.

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
        after = np.roll(rings, -1, axis=1)
        angle = sum(_solid_angle(a, b, rings, after).sum(axis=1) for a, b in pairwise(chain))
        return np.rint(angle / (4.0 * np.pi)).astype(np.int64)


def _solid_angle(
    p1: NDArray[np.float64],
    p2: NDArray[np.float64],
    q1: NDArray[np.float64],
    q2: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Signed solid angle of the directions from segment p1 p2 to segments q1 q2, shape (...)."""
    r13, r14, r23, r24 = q1 - p1, q2 - p1, q1 - p2, q2 - p2
    normals = [_unit(np.cross(a, b)) for a, b in ((r13, r14), (r14, r24), (r24, r23), (r23, r13))]
    area = np.zeros(q1.shape[:-1])
    for one, next_one in zip(normals, [*normals[1:], normals[0]], strict=True):
        area += np.arcsin(np.clip(np.einsum("...i,...i", one, next_one), -1.0, 1.0))
    return area * np.sign(np.einsum("...i,...i", np.cross(p2 - p1, q2 - q1), r13))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors of length one; a vector of length zero stays as it is."""
    lengths = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)
