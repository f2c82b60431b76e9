"""The quadratic program of one control step: how the joints move so that the hand gets somewhere.

Stepping through it is differential inverse kinematics, as pink has it (Caron, "Jacobian of a
kinematic task and derivatives on manifolds", 2023), written out for the two tasks that there are:
the tests compare the bits. On its way pink copies, checks and names what here is the same in every
step, and takes five times as long.
"""

from __future__ import annotations

from ctypes import c_int

import daqp
import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dressing_sim.errors import DressingSimError
from dressing_sim.world.robot import Robot

#: Keeps the program strictly convex whatever the weights are.
_DAMPING = 1e-9

#: What the solver takes for no bound.
_UNBOUNDED = -1e30


class MoveProgram:
    """The robot's arm at a configuration, and the best move from there.

    A move of the joints dq minimises ``|W (J dq - e)|^2 + |w (q + dq - home)|^2``: e is the twist
    from the hand to its target, in the hand's frame, and J its derivative by the joints,
    ``Jlog6(target^-1 hand) J_hand``.

    Args:
        model: Pinocchio's model of the arm.
        robot: Whose arm it is.
        posture_cost: Weight w of the joints' deviation from the resting posture [1/rad].
    """

    def __init__(self, model: pin.Model, robot: Robot, posture_cost: float) -> None:
        self._model, self._data = model, model.createData()
        frame = model.getFrameId(robot.tool)
        self._frame, self._hand = frame, self._data.oMf[frame]
        n = model.nv
        self._home = np.array(robot.home)
        self._posture = np.diag([posture_cost] * n)
        self._damping = _DAMPING * np.eye(n)
        self._posture_hessian = self._posture.T @ self._posture
        # Each joint is bounded on both sides.
        self._sides = np.vstack([np.eye(n), -np.eye(n)])
        self._lower = np.full(2 * n, _UNBOUNDED)
        self._sense = np.zeros(2 * n, dtype=c_int)
        self.place(self._home)

    @property
    def q(self) -> NDArray[np.float64]:
        """Joint positions (n,) [rad], not to be written."""
        return self._q

    def place(self, q: NDArray[np.float64]) -> None:
        """Be at other joint positions (n,) [rad]; kinematics wait until they are needed."""
        self._q, self._known = q, False

    def _kinematics(self) -> None:
        if not self._known:
            pin.computeJointJacobians(self._model, self._data, self._q)
            pin.updateFramePlacements(self._model, self._data)
            self._known = True

    def gripper(self) -> NDArray[np.float64]:
        """Where the gripper is, (3,), in the robot's base frame [m]."""
        self._kinematics()
        return np.array(self._hand.translation)

    def move(
        self, target: pin.SE3, weight: NDArray[np.float64], bounds: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """The best move of the joints, (n,) [rad].

        Args:
            target: Pose of the hand, in the robot's base frame.
            weight: W, (6, 6): of position [1/m], then of rotation [1/rad].
            bounds: The farthest that each joint may go up, then down, (2 n,) [rad].
        """
        self._kinematics()
        error = pin.log6(self._hand.actInv(target)).vector
        jacobian = -pin.Jlog6(target.actInv(self._hand)) @ pin.getFrameJacobian(
            self._model, self._data, self._frame, pin.LOCAL
        )
        weighted = weight @ jacobian
        away = self._posture @ (self._home - self._q)
        hessian = self._damping + weighted.T @ weighted + self._posture_hessian
        gradient = -(weight @ -error) @ weighted - away @ self._posture
        move, _, flag, _ = daqp.solve(
            hessian, gradient, self._sides, bounds, self._lower, self._sense
        )
        if flag <= 0:
            raise DressingSimError(f"no move keeps the joints' limits (DAQP's flag is {flag})")
        found: NDArray[np.float64] = move
        return found
