"""The compiled loop behind `dressing_sim.pictures.implicit`."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dressing_sim.compiled import compiled

Array = NDArray[np.float64]


@compiled
def blended(points: Array, parts: Array, blend: float) -> Array:
    """Signed distances (n,) of points (n, 3) from parts that flow into each other.

    Args:
        points: Shape (n, 3) [m].
        parts: A row a part, shape (m, 12): both ends, both radii, an axis and how flat it is
            along that.
        blend: How far from both surfaces two parts flow together [m].
    """
    result = np.empty(len(points))
    for i in range(len(points)):
        x, y, z = points[i, 0], points[i, 1], points[i, 2]
        nearest = 1.0
        for j in range(len(parts)):
            p = parts[j]
            ax, ay, az = p[3] - p[0], p[4] - p[1], p[5] - p[2]
            ox, oy, oz = x - p[0], y - p[1], z - p[2]
            squared = ax * ax + ay * ay + az * az
            # A ball around the part, which most parts can be left out by.
            mx, my, mz = ox - 0.5 * ax, oy - 0.5 * ay, oz - 0.5 * az
            reach = 0.5 * np.sqrt(squared) + max(p[6], p[7]) * max(1.0, p[11])
            away = (np.sqrt(mx * mx + my * my + mz * mz) - reach) * min(1.0, p[11])
            if away > nearest + blend:
                continue
            along = (ox * ax + oy * ay + oz * az) / max(squared, 1e-12)
            along = min(max(along, 0.0), 1.0)
            ox, oy, oz = ox - along * ax, oy - along * ay, oz - along * az
            more = (ox * p[8] + oy * p[9] + oz * p[10]) * (1.0 / p[11] - 1.0)
            ox, oy, oz = ox + more * p[8], oy + more * p[9], oz + more * p[10]
            radius = p[6] + along * (p[7] - p[6])
            distance = (np.sqrt(ox * ox + oy * oy + oz * oz) - radius) * min(1.0, p[11])
            overlap = max(blend - abs(nearest - distance), 0.0)
            nearest = min(nearest, distance) - overlap * overlap / (4.0 * blend)
        result[i] = nearest
    return result
