"""The U-shaped box at either end of the task, and how far a path goes into its walls."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray, Frame

# Corners in the box's own frame, a closed outline. The channel is 0.3 wide, open towards +y at
# y = 1, and the movement starts (or ends) near the origin, at its bottom.
OUTLINE = 0.1 * np.array(
    [(-4, -3.5), (-4, 10), (-1.5, 10), (-1.5, -1), (1.5, -1), (1.5, 10), (4, 10), (4, -3.5)]
)
MOUTH = np.array([0.0, 1.0])  # middle of the opening, in the box's own frame


def outline(frame: Frame) -> FloatArray:
    """The box's outline (9, 2) in world coordinates, the first corner repeated at the end."""
    return frame.to_world(np.vstack([OUTLINE, OUTLINE[:1]]))


def penetration(path: ArrayLike, frame: Frame) -> float:
    """How deep a path (T, 2) goes into the walls of a box: the largest depth, 0 if it stays out.

    In world units. The path is looked at between its samples as well.
    """
    corners = outline(frame)
    points = _dense(np.asarray(path, dtype=np.float64), 0.1 * np.ptp(corners, axis=0).max() / 4)
    inside = _inside(points, corners)
    if not inside.any():
        return 0.0
    return float(_distance_to_outline(points[inside], corners).max())


def violation(demonstration: DemonstrationLike) -> float:
    """The largest depth to which a path goes into any of its situation's boxes, in world units."""
    return max(penetration(demonstration.positions, frame) for frame in demonstration.frames)


def mean_violation(paths: Sequence[DemonstrationLike]) -> float:
    """Mean of ``violation`` over several paths."""
    return float(np.mean([violation(path) for path in paths]))


def _dense(path: FloatArray, spacing: float) -> FloatArray:
    """The path with points added so that no two neighbours are further apart than ``spacing``."""
    lengths = np.linalg.norm(np.diff(path, axis=0), axis=1)
    counts = np.maximum(np.ceil(lengths / spacing).astype(int), 1)
    pieces = [
        a + (b - a) * (np.arange(count) / count)[:, None]
        for a, b, count in zip(path[:-1], path[1:], counts, strict=True)
    ]
    return np.vstack([*pieces, path[-1:]])


def _inside(points: FloatArray, corners: FloatArray) -> np.ndarray:
    """Whether each point is inside a closed polygon: a ray to the right crosses it an odd number
    of times."""
    x, y = points[:, :1], points[:, 1:]
    (x0, y0), (x1, y1) = corners[:-1].T, corners[1:].T
    straddles = (y0 > y) != (y1 > y)
    with np.errstate(divide="ignore", invalid="ignore"):
        crossing = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
    return (straddles & (x < crossing)).sum(axis=1) % 2 == 1


def _distance_to_outline(points: FloatArray, corners: FloatArray) -> FloatArray:
    starts, edges = corners[:-1], np.diff(corners, axis=0)
    offsets = points[:, None] - starts
    along = np.clip((offsets * edges).sum(axis=2) / (edges**2).sum(axis=1), 0.0, 1.0)
    nearest = np.linalg.norm(offsets - along[..., None] * edges, axis=2)
    return nearest.min(axis=1)
