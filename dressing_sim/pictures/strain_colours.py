"""The cloth in colours of its strain, for pictures."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dressing_sim.world.sleeve import SleeveMesh
from dressing_sim.world.strain import StrainGauge

#: Red, green and blue from no strain to the top, evenly spaced; their lightness rises evenly, so
#: that colour-blind readers tell them apart.
COLOURS = (
    (0.27, 0.00, 0.33),
    (0.23, 0.32, 0.55),
    (0.13, 0.57, 0.55),
    (0.37, 0.79, 0.38),
    (0.99, 0.91, 0.14),
)

_STEPS = 256


class StrainScale:
    """Colours of a sleeve's strain.

    Args:
        mesh: The sleeve at rest.
        top: Principal strain that is drawn in the last colour; no strain has the first.
    """

    def __init__(self, mesh: SleeveMesh, top: float) -> None:
        self._gauge = StrainGauge(mesh)
        self._mesh, self.top = mesh, top

    def picture(self) -> NDArray[np.uint8]:
        """All colours from left to right, shape (2, 256, 3)."""
        steps = np.linspace(0.0, len(COLOURS) - 1.0, _STEPS)
        rgb = np.stack([np.interp(steps, range(len(COLOURS)), c) for c in np.transpose(COLOURS)], 1)
        return np.repeat(np.round(255 * rgb).astype(np.uint8)[None], 2, axis=0)

    def at_vertices(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean strain of the triangles round each vertex, by area, shape (n_vertices,).

        Args:
            positions: Of the cloth's vertices, shape (n_vertices, 3) [m].
        """
        corners = self._mesh.triangles.ravel()
        areas = np.repeat(self._gauge.areas, 3)
        strains = np.repeat(self._gauge.principal(positions), 3)
        return np.bincount(corners, areas * strains) / np.bincount(corners, areas)

    def column(self, strain: NDArray[np.float64]) -> NDArray[np.float64]:
        """Where in `picture` the colours of strains are, from 0 to 1."""
        # Half a texel in from either end, where a texture would wrap round.
        return (0.5 + np.clip(strain / self.top, 0.0, 1.0) * (_STEPS - 1)) / _STEPS
