"""Loop's subdivision of triangle meshes, as matrices from coarse to fine vertices."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import sparse


@dataclass(frozen=True, slots=True, eq=False)
class Subdivision:
    """A finer mesh of the same shape.

    Attributes:
        smooth: Weights (n_fine, n_coarse) of Loop's scheme, each row in sum 1, none below zero:
            for what is known at the coarse vertices.
        through: The same for positions, such that the limit surface passes through the coarse
            vertices instead of within them: ``smooth`` times the inverse of the limit's weights.
        triangles: Shape (m, 3), of fine vertices, the same way round as the coarse.
        edges: Boundary edges (k, 2) of the fine mesh, each in the direction of its triangle.
    """

    smooth: NDArray[np.float64]
    through: NDArray[np.float64]
    triangles: NDArray[np.int32]
    edges: NDArray[np.int32]


def subdivided(triangles: NDArray[np.int32], n_vertices: int, levels: int) -> Subdivision:
    """Divide each triangle into four, `levels` times.

    C. Loop, "Smooth subdivision surfaces based on triangles", 1987, with the boundary of Hoppe et
    al. 1994, and the limit positions of both.

    Args:
        triangles: Shape (m, 3), counter-clockwise.
        n_vertices: How many vertices they have.
        levels: How often.
    """
    finer: sparse.csr_array = sparse.eye_array(n_vertices, format="csr")
    faces = triangles
    for _ in range(levels):
        step, faces = _divided(faces, finer.shape[0])
        finer = (step @ finer).tocsr()
    smooth = finer.toarray()
    limit = _limit(triangles, n_vertices).toarray()
    at_fine = _limit(faces, len(smooth)) @ smooth
    through = np.linalg.solve(limit.T, at_fine.T).T
    return Subdivision(smooth, through, faces, boundary(faces))


def boundary(triangles: NDArray[np.int32]) -> NDArray[np.int32]:
    """Edges (k, 2) that only one triangle has, in its direction."""
    directed = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, first, counts = np.unique(
        np.sort(directed, axis=1), axis=0, return_index=True, return_counts=True
    )
    edges: NDArray[np.int32] = directed[first[counts == 1]]
    return edges


def _neighbours(triangles: NDArray[np.int32], n: int) -> sparse.csr_array:
    rows, columns = (
        triangles[:, [0, 1, 2, 1, 2, 0]].T.ravel(),
        triangles[:, [1, 2, 0, 0, 1, 2]].T.ravel(),
    )
    matrix = sparse.csr_array((np.ones(len(rows)), (rows, columns)), shape=(n, n))
    matrix.data[:] = 1.0
    return matrix


def _weighted(
    triangles: NDArray[np.int32], n: int, inner: NDArray[np.float64], outer: float
) -> sparse.csr_array:
    """Each vertex becomes a mean of itself and its neighbours.

    Args:
        triangles: Shape (m, 3).
        n: Number of vertices.
        inner: Weight of each neighbour, by the vertex's number of neighbours, (n,).
        outer: Weight of each of the two neighbours along a boundary.
    """
    weights = sparse.diags_array(inner) @ _neighbours(triangles, n)
    edges = boundary(triangles)
    on = np.zeros(n, dtype=bool)
    on[edges] = True
    along = sparse.csr_array(
        (np.full(2 * len(edges), outer), (edges.ravel(), edges[:, ::-1].ravel())), shape=(n, n)
    )
    weights = sparse.diags_array((~on).astype(float)) @ weights + along
    itself = 1.0 - np.asarray(weights.sum(axis=1)).ravel()
    return (weights + sparse.diags_array(itself)).tocsr()


def _valence(triangles: NDArray[np.int32], n: int) -> NDArray[np.float64]:
    return np.maximum(np.asarray(_neighbours(triangles, n).sum(axis=1)).ravel(), 1.0)


def _beta(valence: NDArray[np.float64]) -> NDArray[np.float64]:
    """Loop's weight of each neighbour of an inner vertex."""
    return (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / valence)) ** 2) / valence


def _limit(triangles: NDArray[np.int32], n: int) -> sparse.csr_array:
    """Where each vertex comes to after infinitely many divisions."""
    valence = _valence(triangles, n)
    chi = 1.0 / (0.375 / _beta(valence) + valence)
    return _weighted(triangles, n, chi, 1.0 / 6.0)


def _divided(triangles: NDArray[np.int32], n: int) -> tuple[sparse.csr_array, NDArray[np.int32]]:
    """One division: weights (n + n_edges, n), and the triangles."""
    even = _weighted(triangles, n, _beta(_valence(triangles, n)), 0.125)
    corners = triangles[:, [1, 2, 2, 0, 0, 1]].reshape(-1, 2)
    edges, number = np.unique(np.sort(corners, axis=1), axis=0, return_inverse=True)
    number = number.reshape(-1, 3)
    opposite = triangles.ravel()
    shared = np.bincount(number.ravel(), minlength=len(edges)) == 2
    own = np.where(shared, 0.375, 0.5)
    rows = np.repeat(np.arange(len(edges)), 2)
    odd = sparse.csr_array((np.repeat(own, 2), (rows, edges.ravel())), shape=(len(edges), n))
    across = 0.125 * shared[number.ravel()]
    odd = odd + sparse.csr_array((across, (number.ravel(), opposite)), shape=(len(edges), n))
    a, b, c = triangles.T
    ea, eb, ec = (n + number).T  # the edges opposite a, b and c
    faces = np.concatenate(
        [
            np.stack(corner, axis=1)
            for corner in ((a, ec, eb), (b, ea, ec), (c, eb, ea), (ea, eb, ec))
        ]
    )
    return sparse.vstack([even, odd]).tocsr(), faces.astype(np.int32)
