"""Dynamic time warping, normalised: comparable between paths of any two lengths.

Step pattern symmetric2, with the Euclidean distance d between samples:

    g(0, 0) = d(0, 0),
    g(i, j) = min(g(i-1, j-1) + 2 d(i, j), g(i, j-1) + d(i, j), g(i-1, j) + d(i, j)),
    D(x, y) = g(N-1, M-1) / (N + M).

Source: Giorgino (2009), "Computing and visualizing dynamic time warping alignments in R: the dtw
package", Journal of Statistical Software 31(7), doi:10.18637/jss.v031.i07; that is the default
there, and the distance of Zhu, Gienger and Kober (2022), equations 8 and 9.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.checks import real_array
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray


class Warping(NamedTuple):
    """The best alignment of two paths.

    Attributes:
        distance: D(x, y), in the unit of the positions.
        path: (L, 2) pairs of indices into x and y, from (0, 0) to (N-1, M-1).
    """

    distance: float
    path: NDArray[np.int64]


def dtw_distance(x: ArrayLike, y: ArrayLike) -> float:
    """Normalised warping distance D(x, y) of two paths (N, p) and (M, p), in their unit.

    Two series (N,) and (M,) count as paths with p = 1.

    Raises:
        InvalidInputError: an empty path, different p, or values that are not finite.
    """
    from dressing_sim.learning.kernels.warping import total_cost

    rows, columns = _paths(x, y)
    return float(total_cost(rows, columns)) / (rows.shape[1] + columns.shape[1])


def dtw(x: ArrayLike, y: ArrayLike) -> Warping:
    """Distance as in ``dtw_distance``, with the warping path.

    Among equally good steps the path takes the diagonal one first, then the one along y.
    """
    from dressing_sim.learning.kernels.warping import warp

    rows, columns = _paths(x, y)
    total, path = warp(rows, columns)
    return Warping(float(total) / (rows.shape[1] + columns.shape[1]), path)


def _paths(x: ArrayLike, y: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """The paths as the compiled loops want them: (p, N), and (p, M) backwards."""
    a, b = (real_array(path, None, "dtw needs other paths: one has") for path in (x, y))
    if a.ndim == b.ndim == 1:
        a, b = a[:, None], b[:, None]
    if a.ndim != 2 or b.ndim != 2 or a.shape[1] != b.shape[1] or not (a.size and b.size):
        raise InvalidInputError(
            f"dtw needs two paths of shape (N, p) and (M, p), not {a.shape} and {b.shape}"
        )
    return np.ascontiguousarray(a.T), np.ascontiguousarray(b[::-1].T)
