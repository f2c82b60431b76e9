"""Strain of the cloth from the deformation gradient of each triangle, and of its edges."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dressing_sim.world.kernels import edge_strain, percentile, principal_strain
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
        self._triangles, self._edges_of = mesh.triangles, mesh.edges
        along = mesh.vertices[mesh.edges[:, 1]] - mesh.vertices[mesh.edges[:, 0]]
        self._rest_lengths = np.linalg.norm(along, axis=1)
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
        strain = np.empty(len(self._triangles))
        principal_strain(vertices, self._triangles, self._inverse, strain)
        return strain

    def percentile(self, strain: NDArray[np.float64], percent: float) -> float:
        """Strain that `percent` per cent of the cloth's area stays at or below.

        Args:
            strain: Strain of each triangle, shape (n_triangles,).
            percent: From 0 to 100.
        """
        return float(percentile(strain, self.areas, percent))

    def edge_percentile(self, vertices: NDArray[np.float64], percent: float) -> float:
        """Strain that `percent` per cent of the edges, by their length at rest, stay at or below.

        Studies without deformation gradients report this; an edge sees the strain along itself
        only, so it is below the principal strain of the triangles beside it.

        Args:
            vertices: Shape (n_vertices, 3) [m].
            percent: From 0 to 100.
        """
        strain = np.empty(len(self._edges_of))
        edge_strain(vertices, self._edges_of, self._rest_lengths, strain)
        return float(percentile(strain, self._rest_lengths, percent))
