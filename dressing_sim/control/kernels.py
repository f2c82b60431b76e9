"""Loops that run in every control step, compiled."""

import numpy as np

from dressing_sim.compiled import compiled


@compiled
def farthest_moves(
    q: np.ndarray,
    velocity: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    speed: np.ndarray,
    acceleration: np.ndarray,
    dt: float,
    bounds: np.ndarray,
) -> None:
    """How far each joint may go up, then down, in one step: see `JointLimits`.

    All are of the joints, (n,), in [rad], [rad/s] and [rad/s^2], but ``bounds`` (2 n,), which is
    written.
    """
    n = len(q)
    for i in range(n):
        a = acceleration[i]
        for side in range(2):
            room = upper[i] - q[i] if side == 0 else q[i] - lower[i]
            now = velocity[i] if side == 0 else -velocity[i]
            back = max(room / dt, -speed[i])
            if np.isinf(a):
                fastest = max(min(speed[i], room / dt), -speed[i])
            else:
                stopping = np.sqrt((a * dt) ** 2 + 2.0 * a * max(room, 0.0)) - a * dt
                stopping = back if room < 0.0 else stopping
                fastest = max(min(min(speed[i], stopping), now + a * dt), now - a * dt)
            bounds[side * n + i] = dt * fastest


@compiled
def moved(
    previous: np.ndarray,
    move: np.ndarray,
    lower: np.ndarray,
    upper: np.ndarray,
    dt: float,
    q: np.ndarray,
    velocity: np.ndarray,
) -> None:
    """Where a move of the joints leads within their limits, and how fast they were: see `Tracker`.

    All are of the joints, (n,), in [rad] and [rad/s]; ``q`` and ``velocity`` are written.
    """
    for i in range(len(q)):
        # The division and the product do not cancel to the bit.
        to = previous[i] + move[i] / dt * dt
        q[i] = min(max(to, min(lower[i], previous[i])), max(upper[i], previous[i]))
        velocity[i] = (q[i] - previous[i]) / dt
