"""Kinematics of the Panda's arm with Pinocchio, from the same URDF that the world simulates."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dressing_sim.world.panda import FINGER_JOINTS, TCP_BODY, urdf_path


class PandaKinematics:
    """The seven arm joints, with the fingers closed; positions are in the robot's base frame.

    Attributes:
        model: Pinocchio's model of the arm (7 joints).
    """

    def __init__(self) -> None:
        full = pin.buildModelFromUrdf(str(urdf_path()))
        fingers = [full.getJointId(name) for name in FINGER_JOINTS]
        self.model: pin.Model = pin.buildReducedModel(full, fingers, pin.neutral(full))
        self._data = self.model.createData()
        self._tcp = self.model.getFrameId(TCP_BODY)

    def tcp_pose(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Forward kinematics of the tool centre point.

        Args:
            q: Joint positions (7,) [rad].

        Returns:
            Position (3,) [m] and rotation matrix (3, 3), its z axis along the fingers.
        """
        pin.framesForwardKinematics(self.model, self._data, np.asarray(q, dtype=float))
        pose = self._data.oMf[self._tcp]
        return pose.translation.copy(), pose.rotation.copy()
