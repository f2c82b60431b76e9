"""What a joint command may be: limits of position, speed and acceleration."""

from __future__ import annotations

import numpy as np
import pink
import pinocchio as pin
from numpy.typing import NDArray
from pink.limits.limit import Limit

#: Largest joint accelerations of a command [rad/s^2]: half of what the Panda's control interface
#: accepts. A servo that is asked for more than its torque saturates, falls behind and overshoots.
MAX_ACCELERATION = (7.5, 3.75, 5.0, 6.25, 7.5, 10.0, 10.0)


#: Share of the joints' speed limits that commands use: next to a person half is plenty, and the
#: servos overshoot by a few per cent.
SPEED_SHARE = 0.5


#: Commands stay this far within the joints' position limits, for the same reason [rad].
POSITION_MARGIN = 0.01


class JointLimitConstraint(Limit):
    """Bounds on the joints' next move, which all are bounds on each joint alone.

    Its speed stays below its limit, changes by no more than the largest acceleration a, and is so
    low that the joint can still come to rest within the distance d to its end of travel:
    ``v dt + v^2 / 2 a <= d`` (a step at v, then braking). Whoever keeps this keeps it one step
    later by braking, so there always is a solution.

    Args:
        model: The robot.
        acceleration: Largest acceleration of each joint, shape (n,) [rad/s^2]; may be infinite.
    """

    def __init__(self, model: pin.Model, acceleration: NDArray[np.float64]) -> None:
        self.lower = model.lowerPositionLimit + POSITION_MARGIN
        self.upper = model.upperPositionLimit - POSITION_MARGIN
        self._speed = SPEED_SHARE * model.velocityLimit
        self._acceleration = acceleration
        self._sides = np.vstack([np.eye(model.nv), -np.eye(model.nv)])
        self.velocity = np.zeros(model.nv)
        """What the joints last moved with [rad/s]."""

    def clipped(self, q: NDArray[np.float64], previous: NDArray[np.float64]) -> NDArray[np.float64]:
        """Positions (7,) [rad] within the limits or, coming back, no further out than before."""
        return np.clip(q, np.minimum(self.lower, previous), np.maximum(self.upper, previous))

    def _fastest(
        self, room: NDArray[np.float64], now: NDArray[np.float64], dt: float
    ) -> NDArray[np.float64]:
        """Largest speed towards one side, from the room and the speed now in its direction.

        It is negative beyond the limit: a joint comes back, no faster than any joint may go.
        """
        a = self._acceleration
        if np.isinf(a).any():
            return np.maximum(np.minimum(self._speed, room / dt), -self._speed)
        stopping = np.sqrt((a * dt) ** 2 + 2.0 * a * np.maximum(room, 0.0)) - a * dt
        back = np.maximum(room / dt, -self._speed)
        stopping = np.where(room < 0.0, back, stopping)
        return np.maximum(np.minimum(np.minimum(self._speed, stopping), now + a * dt), now - a * dt)

    def compute_qp_inequalities(
        self, configuration: pink.Configuration, dt: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Matrix G and vector h of ``G move <= h``."""
        up = self._fastest(self.upper - configuration.q, self.velocity, dt)
        down = self._fastest(configuration.q - self.lower, -self.velocity, dt)
        return self._sides, dt * np.concatenate([up, down])
