"""Strain of the cloth from the deformation gradient of each triangle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dressing_sim.world.sleeve import SleeveMesh


class StrainGauge:
    """Largest principal strain of every triangle of a mesh.

    A triangle with edge vectors D at rest (in its own plane) and d when deformed has deformation
    gradient ``F = d D^-1`` (3 x 2); its principal stretches are the singular values of F, and the
    strain reported is the larger of them minus one.

    Args:
        mesh: The sleeve at rest.

    Attributes:
        areas: Area of each triangle at rest, shape (n_triangles,) [m^2].
    """

    def __init__(self, mesh: SleeveMesh) -> None:
        self._triangles = mesh.triangles
        first, second = self._edges(mesh.vertices)
        length = np.linalg.norm(first, axis=1)
        along = np.einsum("ij,ij->i", first, second) / length
        across = np.sqrt(np.einsum("ij,ij->i", second, second) - along**2)
        self.areas: NDArray[np.float64] = 0.5 * length * across
        rest = np.zeros((len(first), 2, 2))
        rest[:, 0, 0], rest[:, 0, 1], rest[:, 1, 1] = length, along, across
        self._inverse = np.linalg.inv(rest)

    def _edges(
        self, vertices: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        corners = vertices[self._triangles]
        return corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]

    def principal(self, vertices: NDArray[np.float64]) -> NDArray[np.float64]:
        """Largest principal strain of each triangle.

        Args:
            vertices: Shape (n_vertices, 3) [m].

        Returns:
            Shape (n_triangles,); 0.1 is ten per cent longer than at rest, negative is shorter.
        """
        gradient = np.stack(self._edges(vertices), axis=2) @ self._inverse
        c11 = np.einsum("ij,ij->i", gradient[:, :, 0], gradient[:, :, 0])
        c22 = np.einsum("ij,ij->i", gradient[:, :, 1], gradient[:, :, 1])
        c12 = np.einsum("ij,ij->i", gradient[:, :, 0], gradient[:, :, 1])
        larger = 0.5 * (c11 + c22) + np.sqrt((0.5 * (c11 - c22)) ** 2 + c12**2)
        return np.sqrt(larger) - 1.0

    def percentile(self, strain: NDArray[np.float64], percent: float) -> float:
        """Strain that `percent` per cent of the cloth's area stays at or below.

        Args:
            strain: Strain of each triangle, shape (n_triangles,).
            percent: From 0 to 100.
        """
        order = np.argsort(strain)
        covered = np.cumsum(self.areas[order])
        index = np.searchsorted(covered, percent / 100.0 * covered[-1])
        return float(strain[order[min(index, len(order) - 1)]])
