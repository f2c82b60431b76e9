"""The person as drawn, where the arm moves: each point follows the bones that it is at.

Linear blend skinning (Magnenat-Thalmann et al. 1988): a point goes where its bones take it, to the
mean of these places by its weights. Drawn only; what is simulated moves by joints.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.pictures.person import Surface, beside_arm, left_arm
from dressing_sim.pictures.reshaping import reshape
from dressing_sim.world.dressed import ArmAxis

#: What goes with the shoulder or the arm; legs and feet stay.
_MOVED = ("skin", "skin_hand", "shirt")

#: Over what distance a point goes over from the trunk to the arm [m], and from the upper arm to the
#: forearm [arm coordinate].
_AT_SHOULDER, _AT_ELBOW = 0.05, 0.25


class MovingPerson:
    """The parts of a drawn person that move with an arm.

    Args:
        rest: The posture that they were drawn in.
        parts: Of the person.
    """

    def __init__(self, rest: Posture, parts: Sequence[Surface]) -> None:
        self._rest = rest
        self._parts = [part for part in parts if part.name in _MOVED]
        self._weights = [bone_weights(rest, part.vertices) for part in self._parts]

    def place(self, model: mujoco.MjModel, now: Posture) -> list[int]:
        """Move the model's meshes to where the arm is now.

        Returns:
            The meshes to upload.
        """
        moved = bones(self._rest, now)
        meshes = []
        for part, weights in zip(self._parts, self._weights, strict=True):
            points, normals = np.zeros_like(part.vertices), np.zeros_like(part.normals)
            for (turn, at, to), weight in zip(moved, weights.T, strict=True):
                points += weight[:, None] * ((part.vertices - at) @ turn.T + to)
                normals += weight[:, None] * (part.normals @ turn.T)
            normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
            meshes.append(reshape(model, part.name, points, normals))
        return meshes


def bones(
    rest: Posture, now: Posture
) -> list[tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]:
    """How trunk, upper arm and forearm have moved.

    Returns:
        Of each a rotation (3, 3), and one point before (3,) and after (3,) [m].
    """
    upper = now.upper_arm_rotation @ rest.upper_arm_rotation.T
    fore = _forearm(now) @ _forearm(rest).T
    return [
        (np.eye(3), rest.shoulder, now.shoulder),
        (upper, rest.shoulder, now.shoulder),
        (fore, rest.elbow, now.elbow),
    ]


def _forearm(posture: Posture) -> NDArray[np.float64]:
    """Axes of the forearm: along it, the elbow's, and across."""
    along = (posture.wrist - posture.elbow) / posture.arm_size.forearm_length
    hinge = posture.upper_arm_rotation[:, 1]
    return np.stack([along, hinge, np.cross(along, hinge)], axis=1)


def bone_weights(rest: Posture, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far points follow trunk, upper arm and forearm, (n, 3), each row with a sum of one."""
    # By which surface they are at: both distances are zero where arm and trunk flow together.
    nearer = beside_arm(rest)(points) - left_arm(rest)(points)
    arm = _smooth(0.5 + nearer / _AT_SHOULDER)
    s = ArmAxis.of(rest).coordinate(points)
    forearm = arm * _smooth(0.5 + (1.0 - s) / _AT_ELBOW)
    return np.stack([1.0 - arm, arm - forearm, forearm], axis=1)


def _smooth(share: NDArray[np.float64]) -> NDArray[np.float64]:
    """From 0 to 1, with slopes of zero at both ends."""
    clipped = np.clip(share, 0.0, 1.0)
    return clipped * clipped * (3.0 - 2.0 * clipped)
