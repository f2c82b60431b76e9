"""The second-order system of a dynamic movement primitive, in steps of one row.

    dv = h (alpha (beta (g - y) - v) + f),   y += h v,

with h the phase of a step, v the velocity over phase and beta = alpha / 4, critically damped. The
forces of a path are those that lead along it exactly.
"""

from __future__ import annotations

import numpy as np

from dressing_sim.learning.frame import FloatArray

#: The usual gain, see Ijspeert et al. (2013).
ALPHA = 25.0


def forces(path: FloatArray, goal: FloatArray) -> FloatArray:
    """f at the rows of a path (N, p) towards a goal (p,): (N, p); the last row's is not used."""
    step = 1.0 / (len(path) - 1)
    velocity = np.diff(path, axis=0, prepend=path[:1]) / step
    rises = np.append(np.diff(velocity, axis=0), np.zeros((1, path.shape[1])), axis=0) / step
    return rises - ALPHA * (0.25 * ALPHA * (goal - path) - velocity)


def rollout(forces: FloatArray, start: FloatArray, goal: FloatArray) -> FloatArray:
    """The path (N, p) that forces (N, p) make from rest at a start (p,), towards a goal (p,)."""
    step = 1.0 / (len(forces) - 1)
    path = np.empty_like(forces)
    path[0], velocity = start, np.zeros_like(start)
    for row, force in enumerate(forces[:-1]):
        pull = ALPHA * (0.25 * ALPHA * (goal - path[row]) - velocity)
        velocity = velocity + step * (pull + force)
        path[row + 1] = path[row] + step * velocity
    return path
