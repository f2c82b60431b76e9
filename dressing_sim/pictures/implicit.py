"""Smooth bodies for drawing, from signed distances: cones and ellipsoids that flow into each other.

A distance is below zero inside. It need not be exact, only smooth and right near the surface.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.pictures.distances import blended

Field = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""From points (n, 3) [m] to signed distances (n,) [m]."""

#: Blocks of so many cells a side are looked into together.
_BLOCK = 4


@dataclass(frozen=True, slots=True, eq=False)
class Cone:
    """A cone with rounded ends, which may be flattened.

    Attributes:
        start: One end (3,) [m].
        end: The other (3,) [m].
        radii: At both ends [m].
        flat: A unit vector (3,), or None, along which it is `squash` times as thick.
        squash: See there; below one is flatter.
    """

    start: NDArray[np.float64]
    end: NDArray[np.float64]
    radii: tuple[float, float]
    flat: NDArray[np.float64] | None = None
    squash: float = 1.0

    def row(self) -> NDArray[np.float64]:
        """All of it in numbers (12,), for `dressing_sim.pictures.distances`."""
        flat = np.zeros(3) if self.flat is None else self.flat
        return np.array([*self.start, *self.end, *self.radii, *flat, self.squash])

    def ball(self) -> tuple[NDArray[np.float64], float]:
        """Centre and radius of a ball around it."""
        half = 0.5 * float(np.linalg.norm(self.end - self.start))
        return 0.5 * (self.start + self.end), half + max(self.radii) * max(1.0, self.squash)


@dataclass(frozen=True, slots=True, eq=False)
class Solid:
    """Parts that flow into each other, by the polynomial smooth minimum (Quilez 2008).

    Attributes:
        parts: What it is made of.
        blend: How far from both surfaces two parts flow together [m].
    """

    parts: tuple[Cone, ...]
    blend: float = 0.02

    def __call__(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Signed distances (n,) of points (n, 3) [m]."""
        return blended(points, np.array([part.row() for part in self.parts]), self.blend)

    def box(self) -> NDArray[np.float64]:
        """Lower and upper corner (2, 3) of a box around it [m]."""
        balls = [part.ball() for part in self.parts]
        centres, radii = np.array([b[0] for b in balls]), np.array([[b[1]] for b in balls])
        return np.array([(centres - radii).min(axis=0), (centres + radii).max(axis=0)])


def gradient(field: Field, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (n, 3) along which a field rises, by differences over a millimetre."""
    step = 1e-3
    shifted = np.concatenate(
        [points + sign * step * axis for axis in np.eye(3) for sign in (1, -1)]
    )
    values = field(shifted).reshape(3, 2, len(points))
    slope = (values[:, 0] - values[:, 1]).T
    lengths = np.linalg.norm(slope, axis=1, keepdims=True)
    return slope / np.where(lengths > 1e-12, lengths, 1.0)


def surface(
    field: Field, box: NDArray[np.float64], cell: float
) -> tuple[NDArray[np.float64], NDArray[np.int32], NDArray[np.float64]]:
    """The surface of a body as a mesh: surface nets (Gibson 1998), moved onto the surface.

    Args:
        field: Signed distances.
        box: Lower and upper corner (2, 3) of where to look [m].
        cell: Length of a cell [m].

    Returns:
        Vertices (n, 3) [m], triangles (m, 3) counter-clockwise from outside, and normals (n, 3).
    """
    values, origin = _sampled(field, box, cell)
    inside = values < 0.0
    corners = [
        (slice(i, i + n) for i, n in zip(offset, np.subtract(values.shape, 1), strict=True))
        for offset in np.ndindex(2, 2, 2)
    ]
    count = np.zeros(np.subtract(values.shape, 1), dtype=np.int8)
    for corner in corners:
        count += inside[tuple(corner)]
    active = (count > 0) & (count < 8)
    number = np.full(active.shape, -1, dtype=np.int32)
    number[active] = np.arange(active.sum(), dtype=np.int32)
    vertices = origin + cell * (np.argwhere(active) + 0.5)
    for _ in range(2):
        normals = gradient(field, vertices)
        move = np.clip(field(vertices), -cell, cell)
        vertices = vertices - move[:, None] * normals
    return vertices, _faces(inside, number), gradient(field, vertices)


def _sampled(
    field: Field, box: NDArray[np.float64], cell: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values of a field on a grid, exact only near its surface, and the grid's origin."""
    block = _BLOCK * cell
    origin = box[0] - block
    blocks = np.ceil((box[1] - box[0]) / block).astype(int) + 2
    indices = np.indices(blocks).reshape(3, -1).T
    coarse = field(origin + block * (indices + 0.5))
    values = np.broadcast_to(
        coarse.reshape(*blocks, 1, 1, 1), (*blocks, _BLOCK, _BLOCK, _BLOCK)
    ).copy()
    # Half the diagonal of a block, and as much again because distances are not exact.
    near = np.abs(coarse) < 1.8 * block
    within = np.indices((_BLOCK,) * 3).reshape(3, -1).T
    points = origin + block * indices[near][:, None] + cell * within[None]
    flat = values.reshape(len(indices), -1)
    flat[near] = field(points.reshape(-1, 3)).reshape(len(points), -1)
    grid = flat.reshape(*blocks, _BLOCK, _BLOCK, _BLOCK).transpose(0, 3, 1, 4, 2, 5)
    return grid.reshape(blocks * _BLOCK), origin


def _faces(inside: NDArray[np.bool_], number: NDArray[np.int32]) -> NDArray[np.int32]:
    """Two triangles round each edge of the grid that passes through the surface."""
    found = []
    for axis in range(3):
        first = np.moveaxis(inside, axis, 0)
        cells = np.moveaxis(number, axis, 0)
        crossing = first[:-1, 1:-1, 1:-1] != first[1:, 1:-1, 1:-1]
        i, j, k = np.nonzero(crossing)
        a, b = cells[i, j, k], cells[i, j + 1, k]
        c, d = cells[i, j + 1, k + 1], cells[i, j, k + 1]
        # The other two axes in cyclic order make a right-handed corner, except for the middle one.
        outwards = first[:-1, 1:-1, 1:-1][i, j, k] != (axis == 1)
        b, d = np.where(outwards, b, d), np.where(outwards, d, b)
        found += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    return np.concatenate(found).astype(np.int32)


def shade(
    field: Field, vertices: NDArray[np.float64], normals: NDArray[np.float64], reach: float = 0.12
) -> NDArray[np.float64]:
    """How open each vertex is to the light of a cloudy sky, from 0 (hidden) to 1, shape (n,).

    The field is looked at along the normal: where it rises slower than in the open, something is
    near (Evans, "Fast approximations for global illumination on dynamic scenes", 2006).
    """
    hidden, weight = np.zeros(len(vertices)), 1.0
    steps: Sequence[float] = (0.2, 0.45, 1.0)
    for share in steps:
        away = share * reach
        found = np.clip(field(vertices + away * normals), 0.0, away)
        hidden += weight * (away - found) / away
        weight *= 0.75
    return np.clip(1.0 - 0.55 * hidden, 0.0, 1.0)
