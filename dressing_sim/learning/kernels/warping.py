"""Dynamic time warping with the symmetric2 step pattern."""

import numpy as np
from numba import njit

from dressing_sim.learning.kernels.linalg import FAST


@njit(cache=True, error_model="numpy", fastmath=FAST)
def accumulate_row(
    point: np.ndarray,
    other: np.ndarray,
    previous: np.ndarray,
    first: bool,
    local: np.ndarray,
    current: np.ndarray,
) -> None:
    """One row of the accumulated cost from the ``previous`` one; ``other`` is (p, M).

    All that does not depend on the cell to the left goes first, in loops that vectorise.
    """
    n_columns = other.shape[1]
    for j in range(n_columns):
        local[j] = 0.0
    for i in range(other.shape[0]):
        value = point[i]
        for j in range(n_columns):
            difference = other[i, j] - value
            local[j] += difference * difference
    for j in range(n_columns):
        local[j] = np.sqrt(local[j])
    if first:
        current[0] = local[0]
        for j in range(1, n_columns):
            current[j] = current[j - 1] + local[j]
        return
    current[0] = previous[0] + local[0]
    for j in range(1, n_columns):
        straight = previous[j] + local[j]
        diagonal = previous[j - 1] + 2.0 * local[j]
        current[j] = diagonal if diagonal < straight else straight
    left = current[0]
    for j in range(1, n_columns):
        left += local[j]
        left = current[j] if current[j] < left else left
        current[j] = left


@njit(cache=True, error_model="numpy")
def total_cost(x: np.ndarray, other: np.ndarray) -> float:
    """Accumulated cost of the best warping of ``x`` (N, p) on ``other`` (p, M), in two rows."""
    n_columns = other.shape[1]
    rows = np.empty((2, n_columns))
    local = np.empty(n_columns)
    for i in range(len(x)):
        accumulate_row(x[i], other, rows[(i + 1) % 2], i == 0, local, rows[i % 2])
    return rows[(len(x) - 1) % 2, n_columns - 1]


@njit(cache=True, error_model="numpy")
def warp(x: np.ndarray, other: np.ndarray) -> tuple[float, np.ndarray]:
    """Accumulated cost and the path (L, 2) of index pairs from (0, 0) to (N - 1, M - 1)."""
    n_rows, n_columns = len(x), other.shape[1]
    cost = np.empty((n_rows, n_columns))
    local = np.empty((n_rows, n_columns))
    for i in range(n_rows):
        accumulate_row(x[i], other, cost[max(i - 1, 0)], i == 0, local[i], cost[i])
    path = np.empty((n_rows + n_columns - 1, 2), dtype=np.int64)
    i, j, at = n_rows - 1, n_columns - 1, n_rows + n_columns - 2
    path[at, 0], path[at, 1] = i, j
    while i > 0 or j > 0:
        if i == 0:
            j -= 1
        elif j == 0:
            i -= 1
        else:
            diagonal = cost[i - 1, j - 1] + local[i, j]
            if diagonal <= cost[i, j - 1] and diagonal <= cost[i - 1, j]:
                i -= 1
                j -= 1
            elif cost[i, j - 1] <= cost[i - 1, j]:
                j -= 1
            else:
                i -= 1
        at -= 1
        path[at, 0], path[at, 1] = i, j
    return cost[n_rows - 1, n_columns - 1], path[at:]
