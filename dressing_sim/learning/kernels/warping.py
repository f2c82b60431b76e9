"""Dynamic time warping with the symmetric2 step pattern.

The cells (i, j) with the same i + j do not depend on each other, so the accumulated cost is worked
out by antidiagonals, in loops that vectorise. Three of them are kept; for the path, two bits a cell
say where its best step comes from.
"""

import numpy as np

from dressing_sim.compiled import compiled


@compiled
def accumulate_diagonal(
    s: int,
    rows: np.ndarray,
    columns: np.ndarray,
    before: np.ndarray,
    last: np.ndarray,
    local: np.ndarray,
    current: np.ndarray,
) -> None:
    """Antidiagonal i + j = s from the two before it, s - 2 in ``before`` and s - 1 in ``last``.

    ``rows`` (p, N) is the one path, ``columns`` (p, M) the other one backwards. The three costs
    have N + 1 entries, that of row i at i + 1, and infinity where there is no cell.
    """
    n_rows, n_columns = rows.shape[1], columns.shape[1]
    begin = max(0, s - n_columns + 1)
    end = min(n_rows, s + 1)
    size = end - begin
    offset = n_columns - 1 - s + begin  # column s - i is entry offset + i - begin, backwards
    distance = local[begin:end]
    for k in range(size):
        distance[k] = 0.0
    for i in range(rows.shape[0]):
        x, y = rows[i, begin:end], columns[i, offset : offset + size]
        for k in range(size):
            difference = x[k] - y[k]
            distance[k] += difference * difference
    for k in range(size):
        distance[k] = np.sqrt(distance[k])
    if s == 0:
        current[1] = distance[0]
        return
    left, up, diagonal = last[begin + 1 :], last[begin:], before[begin:]
    result = current[begin + 1 :]
    for k in range(size):
        straight = left[k] if left[k] < up[k] else up[k]
        straight += distance[k]
        bent = diagonal[k] + 2.0 * distance[k]
        result[k] = bent if bent < straight else straight
    # Beyond the ends of the diagonal there is no cell; the buffers are used again and again.
    current[begin] = np.inf
    if end < n_rows:
        current[end + 1] = np.inf


@compiled
def total_cost(rows: np.ndarray, columns: np.ndarray) -> float:
    """g(N - 1, M - 1) of paths (p, N) and, backwards, (p, M); three diagonals are kept."""
    n_rows, n_columns = rows.shape[1], columns.shape[1]
    costs = np.full((3, n_rows + 1), np.inf)
    local = np.empty(n_rows)
    n_diagonals = n_rows + n_columns - 1
    for s in range(n_diagonals):
        accumulate_diagonal(
            s, rows, columns, costs[(s + 1) % 3], costs[(s + 2) % 3], local, costs[s % 3]
        )
    return costs[(n_diagonals - 1) % 3, n_rows]


@compiled
def keep_steps(
    s: int,
    n_columns: int,
    before: np.ndarray,
    last: np.ndarray,
    local: np.ndarray,
    codes: np.ndarray,
    packed: np.ndarray,
) -> None:
    """Where each cell of antidiagonal i + j = s comes from, four cells a byte into ``packed``.

    0 for the diagonal, 1 along y, 2 along x. ``before``, ``last`` and ``local`` are as in
    ``accumulate_diagonal``, after it; ``codes`` (N + 3,) is working memory.
    """
    n_rows = len(local)
    begin = max(0, s - n_columns + 1)
    size = min(n_rows, s + 1) - begin
    left, up, diagonal = last[begin + 1 :], last[begin:], before[begin:]
    distance = local[begin:]
    for k in range(size):
        bent = diagonal[k] + distance[k]
        straight = np.uint8(1) if left[k] <= up[k] else np.uint8(2)
        least = left[k] if left[k] <= up[k] else up[k]
        codes[k] = np.uint8(0) if bent <= least else straight
    for k in range(len(packed)):
        low = codes[4 * k] | (codes[4 * k + 1] << np.uint8(2))
        packed[k] = low | (codes[4 * k + 2] << np.uint8(4)) | (codes[4 * k + 3] << np.uint8(6))


@compiled
def warp(rows: np.ndarray, columns: np.ndarray) -> tuple[float, np.ndarray]:
    """g(N - 1, M - 1), and the path (L, 2) of index pairs from (0, 0) to (N - 1, M - 1)."""
    n_rows, n_columns = rows.shape[1], columns.shape[1]
    n_diagonals = n_rows + n_columns - 1
    costs = np.full((3, n_rows + 1), np.inf)
    local = np.empty(n_rows)
    codes = np.zeros(n_rows + 3, dtype=np.uint8)
    starts = np.empty(n_diagonals + 1, dtype=np.int64)  # of each diagonal's bytes
    starts[0] = 0
    for s in range(n_diagonals):
        size = min(n_rows, s + 1) - max(0, s - n_columns + 1)
        starts[s + 1] = starts[s] + (size + 3) // 4
    packed = np.empty(starts[n_diagonals], dtype=np.uint8)
    for s in range(n_diagonals):
        before, last = costs[(s + 1) % 3], costs[(s + 2) % 3]
        accumulate_diagonal(s, rows, columns, before, last, local, costs[s % 3])
        kept = packed[starts[s] : starts[s + 1]]
        keep_steps(s, n_columns, before, last, local, codes, kept)
    path = np.empty((n_diagonals, 2), dtype=np.int64)
    i, j, at = n_rows - 1, n_columns - 1, n_diagonals - 1
    path[at, 0], path[at, 1] = i, j
    while i > 0 or j > 0:
        k = i - max(0, i + j - n_columns + 1)
        step = (packed[starts[i + j] + k // 4] >> np.uint8(2 * (k % 4))) & np.uint8(3)
        i -= step != 1
        j -= step != 2
        at -= 1
        path[at, 0], path[at, 1] = i, j
    return costs[(n_diagonals - 1) % 3, n_rows], path[at:]
