"""The linear quadratic regulator of a point mass that follows a stepwise reference.

    z = [y, v],   z_{n+1} = F z_n + B u_n,
    sum_n (z_n - r_n)^T Q_n (z_n - r_n) + u_n^T R u_n least.

With the value function (z - .)^T V_n (z - .) + ... and its linear part w_n, backwards from the end,

    u_n = -(R + B^T V B)^-1 B^T (V F z_n + w),   V_n = Q_n + F^T V (F - B K),
    w_n = (F - B K)^T w - Q_n r_n,   K = (R + B^T V B)^-1 B^T V F.

Source: Calinon (2016), doi:10.1007/s11370-015-0187-9.
"""

from __future__ import annotations

import numpy as np

from dressing_sim.learning.frame import FloatArray


def track(
    references: FloatArray, precisions: FloatArray, effort: float, start: FloatArray
) -> FloatArray:
    """The states (N, 2p) that follow a reference from rest at a start, in steps of phase 1/(N-1).

    Args:
        references: r_n, positions and velocities over phase, (N, 2p).
        precisions: Q_n, (N, 2p, 2p).
        effort: R = effort I.
        start: (p,).
    """
    count, size = references.shape
    p, step = size // 2, 1.0 / (len(references) - 1)
    forward = np.eye(size)
    forward[:p, p:] = step * np.eye(p)
    push = np.concatenate([0.5 * step**2 * np.eye(p), step * np.eye(p)])
    value, linear = precisions[-1], -precisions[-1] @ references[-1]
    gains, offsets = np.empty((count - 1, p, size)), np.empty((count - 1, p))
    for row in range(count - 2, -1, -1):
        inner = np.linalg.inv(effort * np.eye(p) + push.T @ value @ push) @ push.T
        gains[row], offsets[row] = inner @ value @ forward, inner @ linear
        closed = forward - push @ gains[row]
        linear = closed.T @ linear - precisions[row] @ references[row]
        value = precisions[row] + forward.T @ value @ closed
        value = 0.5 * (value + value.T)
    states = np.empty((count, size))
    states[0] = np.append(start, np.zeros(p))
    for row in range(count - 1):
        force = -gains[row] @ states[row] - offsets[row]
        states[row + 1] = forward @ states[row] + push @ force
    return states
