"""Fewer triangles for the same shape: the robot's meshes have more than a picture shows."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]
Faces = NDArray[np.int64]

#: Boundary edges are kept in place by a plane across them of so much weight.
_BOUNDARY = 10.0

#: Of the error that is allowed in the end, what is in each round.
_SHARES = (*[0.01] * 8, *[0.1] * 8, *[1.0] * 10)


def simplified(vertices: Points, faces: Faces, error: float) -> tuple[Points, Faces]:
    """Collapse edges while the surface stays near its planes.

    Quadric error metrics (Garland and Heckbert 1997), in rounds: in each, edges that cost little
    and have no corner in common collapse together, to the best of their ends and middle.

    Args:
        vertices: Shape (n, 3) [m]; equal ones are merged.
        faces: Shape (m, 3).
        error: Root of the sum of squared distances that a vertex may get from the planes of the
            triangles that it stands for [m].

    Returns:
        Vertices and faces that are left.
    """
    _, first, number = np.unique(
        np.round(vertices / 1e-5).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    points, faces = vertices[first], _proper(number.ravel()[faces])
    quadrics = _quadrics(points, faces)
    rng = np.random.default_rng(0)  # of the order alone; the same mesh for everybody
    for share in _SHARES:
        points, faces, quadrics = _round(points, faces, quadrics, share * error**2, rng)
    used, faces = np.unique(faces, return_inverse=True)
    return points[used], faces.reshape(-1, 3)


def _proper(faces: Faces) -> Faces:
    """Without triangles that have become lines."""
    a, b, c = faces.T
    return faces[(a != b) & (b != c) & (c != a)]


def _normals(points: Points, faces: Faces) -> Points:
    p = points[faces]
    across = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    return across / np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-15)


def _edges(faces: Faces) -> tuple[Faces, Faces]:
    """Each edge once, and how many triangles have it."""
    pairs = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, count = np.unique(pairs, axis=0, return_counts=True)
    return edges, count


def _quadrics(points: Points, faces: Faces) -> Points:
    """Sum of squared distances from its triangles' planes of each vertex, as (n, 4, 4) forms."""
    normals = _normals(points, faces)
    planes = np.concatenate([normals, -np.sum(normals * points[faces[:, 0]], axis=1)[:, None]], 1)
    forms = planes[:, :, None] * planes[:, None, :]
    quadrics = np.zeros((len(points), 4, 4))
    for corner in faces.T:
        np.add.at(quadrics, corner, forms)
    pairs = faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    _, index, count = np.unique(
        np.sort(pairs, axis=1), axis=0, return_index=True, return_counts=True
    )
    alone = index[count == 1]
    a, b = pairs[alone].T
    across = np.cross(points[b] - points[a], normals[alone // 3])
    across /= np.maximum(np.linalg.norm(across, axis=1, keepdims=True), 1e-15)
    planes = np.concatenate([across, -np.sum(across * points[a], axis=1)[:, None]], axis=1)
    forms = _BOUNDARY * planes[:, :, None] * planes[:, None, :]
    for end in (a, b):
        np.add.at(quadrics, end, forms)
    return quadrics


def _round(
    points: Points, faces: Faces, quadrics: Points, most: float, rng: np.random.Generator
) -> tuple[Points, Faces, Points]:
    edges, _ = _edges(faces)
    a, b = edges.T
    both = quadrics[a] + quadrics[b]
    choices = np.stack([points[a], points[b], 0.5 * (points[a] + points[b])])
    homogeneous = np.concatenate([choices, np.ones((*choices.shape[:2], 1))], axis=2)
    costs = np.einsum("cei,eij,cej->ce", homogeneous, both, homogeneous)
    best = costs.argmin(axis=0)
    rows = np.arange(len(edges))
    cost, place = np.maximum(costs[best, rows], 0.0), choices[best, rows]
    # Each eligible edge draws a number; whose is the least around collapses.
    eligible = cost < most
    order = np.where(eligible, rng.random(len(edges)), np.inf)
    least = np.full(len(points), np.inf)
    np.minimum.at(least, a, order)
    np.minimum.at(least, b, order)
    around = least.copy()
    np.minimum.at(around, a, least[b])
    np.minimum.at(around, b, least[a])
    chosen = eligible & (order <= np.minimum(around[a], around[b]))
    target = np.arange(len(points))
    moved = points.copy()
    moved[a[chosen]], target[b[chosen]] = place[chosen], a[chosen]
    flipped = _flipped(points, moved, faces, target)
    kept = chosen & ~(flipped[a] | flipped[b])
    target, moved = np.arange(len(points)), points.copy()
    moved[a[kept]], target[b[kept]] = place[kept], a[kept]
    quadrics = quadrics.copy()
    quadrics[a[kept]] = both[kept]
    return moved, np.unique(_proper(target[faces]), axis=0), quadrics


def _flipped(points: Points, moved: Points, faces: Faces, target: Faces) -> NDArray[np.bool_]:
    """Vertices of triangles that would turn by more than 60 degrees."""
    after = target[faces]
    a, b, c = after.T
    alive = (a != b) & (b != c) & (c != a)
    turn = np.sum(_normals(points, faces[alive]) * _normals(moved, after[alive]), axis=1)
    found = np.zeros(len(points), dtype=bool)
    found[faces[alive][turn < 0.5]] = True
    return found
