"""What a joint command may be: limits of position, speed and acceleration."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from numpy.typing import NDArray

from dressing_sim.control.kernels import farthest_moves, moved

#: Share of the joints' speed limits that commands use: next to a person half is plenty, and the
#: servos overshoot by a few per cent.
SPEED_SHARE = 0.5


#: Commands stay this far within the joints' position limits, for the same reason [rad].
POSITION_MARGIN = 0.01


class JointLimits:
    """Limits of the joints' next move, each of which is of one joint alone.

    Its speed stays below its limit, changes by no more than the largest acceleration a, and is so
    low that the joint can still come to rest within the distance d to its end of travel:
    ``v dt + v^2 / 2 a <= d`` (a step at v, then braking). Whoever keeps this keeps it one step
    later by braking, so there always is a solution. Beyond a limit the least speed is negative: a
    joint comes back, no faster than any joint may go.

    Args:
        model: The robot.
        acceleration: Largest acceleration of each joint, shape (n,) [rad/s^2]; may be infinite.
    """

    def __init__(self, model: pin.Model, acceleration: NDArray[np.float64]) -> None:
        self.lower = model.lowerPositionLimit + POSITION_MARGIN
        self.upper = model.upperPositionLimit - POSITION_MARGIN
        self._speed = SPEED_SHARE * model.velocityLimit
        self._acceleration = acceleration
        self.velocity = np.zeros(model.nv)
        """What the joints last moved with [rad/s]."""

    def bounds(self, q: NDArray[np.float64], dt: float) -> NDArray[np.float64]:
        """How far each joint may go up from q (n,) [rad] in a step, then down, (2 n,) [rad]."""
        bounds = np.empty(2 * len(q))
        farthest_moves(
            *(q, self.velocity, self.lower, self.upper, self._speed, self._acceleration, dt, bounds)
        )
        return bounds

    def moved(
        self, q: NDArray[np.float64], move: NDArray[np.float64], dt: float
    ) -> NDArray[np.float64]:
        """Where a move (n,) [rad] leads from q (n,) [rad]; `velocity` is then that of it.

        The solver keeps the limits up to its tolerance; this is within them or, coming back, no
        further out than before.
        """
        to, velocity = np.empty_like(q), np.empty_like(q)
        moved(q, move, self.lower, self.upper, dt, to, velocity)
        self.velocity = velocity
        return to
