"""Kinematics of the robot's arm with Pinocchio, from the same URDF that the world simulates."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.world.description import urdf_text
from dressing_sim.world.robot import PANDA, Robot


class RobotKinematics:
    """The arm's joints, with the fingers closed; positions are in the robot's base frame.

    Args:
        robot: Which.

    Attributes:
        robot: As given.
        model: Pinocchio's model of the arm, of its n joints alone.

    Raises:
        InvalidInputError: Pinocchio cannot read its description.
    """

    def __init__(self, robot: Robot = PANDA) -> None:
        self.robot = robot
        try:
            full = pin.buildModelFromXML(urdf_text(robot))
        except (ValueError, RuntimeError) as error:
            told = one_line(str(error))
            raise InvalidInputError(
                f"robot {robot.name}: Pinocchio refuses its URDF ({told})"
            ) from error
        fingers = [full.getJointId(name) for name in robot.fingers]
        self.model: pin.Model = pin.buildReducedModel(full, fingers, pin.neutral(full))
        self._data = self.model.createData()
        self._tcp = self.model.getFrameId(robot.tool)

    def tcp_pose(self, q: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Forward kinematics of the tool centre point.

        Args:
            q: Joint positions (n,) [rad].

        Returns:
            Position (3,) [m] and rotation matrix (3, 3), its z axis along the fingers.
        """
        pin.framesForwardKinematics(self.model, self._data, np.asarray(q, dtype=float))
        pose = self._data.oMf[self._tcp]
        return pose.translation.copy(), pose.rotation.copy()
