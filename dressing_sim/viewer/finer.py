"""A finer mesh to draw than is simulated: Loop's subdivision, as a matrix.

C. T. Loop, *Smooth Subdivision Surfaces Based on Triangles*, thesis, University of Utah (1987); the
weights of even vertices are those of J. Warren. Drawn only: nothing is measured on it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix


@dataclass(frozen=True, eq=False)
class Finer:
    """A subdivided mesh.

    Attributes:
        weights: Of the given vertices in the new ones, (n_new, n).
        faces: Triangles of new vertices, (4 m, 3), those of one given triangle together.
    """

    weights: csr_matrix
    faces: NDArray[np.int64]

    def vertices(self, given: NDArray[np.float32]) -> NDArray[np.float32]:
        """The new vertices (n_new, 3), or anything else that given vertices have, (n_new,)."""
        return np.asarray(self.weights @ given, dtype=np.float32)


def finer(triangles: NDArray[np.int32], n: int) -> Finer:
    """Subdivide a mesh once.

    Args:
        triangles: Indices of vertices, (m, 3); an edge belongs to one or two of them.
        n: Number of vertices.
    """
    corners = triangles.astype(np.int64)
    sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    opposite = corners[:, [2, 0, 1]].ravel()
    edges, of_side = np.unique(sides, axis=0, return_inverse=True)
    of_side = of_side.ravel()
    inner = np.bincount(of_side) == 2

    rows, columns, values = [], [], []

    def add(row: NDArray[np.int64], column: NDArray[np.int64], value: NDArray[np.float64]) -> None:
        rows.append(row)
        columns.append(column)
        values.append(value)

    new = n + np.arange(len(edges))
    for end in edges.T:
        add(new, end, np.where(inner, 3.0 / 8.0, 1.0 / 2.0))
    across = inner[of_side]
    add(new[of_side[across]], opposite[across], np.full(across.sum(), 1.0 / 8.0))

    # A vertex of the border follows the border alone.
    border = np.zeros(n, dtype=bool)
    border[edges[~inner].ravel()] = True
    counts = np.bincount(edges.ravel(), minlength=n)
    share = np.where(counts == 3, 3.0 / 16.0, 3.0 / (8.0 * np.maximum(counts, 1)))
    every = np.arange(n)
    add(every, every, np.where(border, 3.0 / 4.0, 1.0 - counts * share))
    for one, other in (edges.T, edges.T[::-1]):
        follows = np.where(border[one], ~inner, True)
        value = np.where(border[one], 1.0 / 8.0, share[one])
        add(one[follows], other[follows], value[follows])

    weights = csr_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))),
        shape=(n + len(edges), n),
    )
    middle = new[of_side].reshape(-1, 3)
    a, b, c = corners.T
    ab, bc, ca = middle.T
    faces = np.stack([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]])
    return Finer(weights, faces.transpose(2, 0, 1).reshape(-1, 3))
