import numpy as np
import pytest

from dressing_sim.pictures.subdivision import boundary, subdivided
from dressing_sim.world.garment import find_garment
from dressing_sim.world.sleeve import SleeveConfig, sleeve_mesh

AXES = np.zeros(3), np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])


@pytest.fixture(params=["tshirt-m", "tshirt-m-body"])
def mesh(request):
    return sleeve_mesh(SleeveConfig(find_garment(request.param)), *AXES)


def test_each_triangle_becomes_four_and_the_surface_stays_one(mesh):
    fine = subdivided(mesh.triangles, len(mesh.vertices), 2)
    assert len(fine.triangles) == 16 * len(mesh.triangles)
    assert len(fine.edges) == 4 * len(boundary(mesh.triangles))
    edges = np.sort(fine.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert np.unique(edges, axis=0, return_counts=True)[1].max() == 2


def test_weights_are_a_mean_and_follow_every_affine_motion(mesh):
    fine = subdivided(mesh.triangles, len(mesh.vertices), 1)
    assert fine.smooth.min() >= 0.0
    for weights in (fine.smooth, fine.through):
        np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    matrix, shift = np.array([[0.3, 0.1, 0.0], [0.2, 1.0, 0.5], [0.0, -0.4, 2.0]]), np.ones(3)
    np.testing.assert_allclose(
        fine.through @ (mesh.vertices @ matrix + shift),
        fine.through @ mesh.vertices @ matrix + shift,
        atol=1e-12,
    )


def test_the_limit_passes_through_the_simulated_vertices(mesh):
    """Vertices come first, and each further division brings no nearer than the limit they are."""
    fine = subdivided(mesh.triangles, len(mesh.vertices), 2)
    at_vertices = (fine.through @ mesh.vertices)[: len(mesh.vertices)]
    np.testing.assert_allclose(at_vertices, mesh.vertices, atol=1e-9)


def test_a_ring_becomes_round(mesh):
    fine = subdivided(mesh.triangles, len(mesh.vertices), 2)
    points = fine.through @ mesh.vertices
    rim = points[np.unique(fine.edges)]
    rim = rim[np.abs(rim[:, 0] - mesh.vertices[mesh.along * mesh.around - 1, 0]) < 1e-3]
    radii = np.linalg.norm(rim[:, 1:], axis=1)
    assert np.ptp(radii) < 0.02 * radii.mean()


def test_triangles_keep_their_way_round(mesh):
    fine = subdivided(mesh.triangles, len(mesh.vertices), 1)

    def way(triangles, points):
        p = points[triangles]
        return np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])

    before = way(mesh.triangles, mesh.vertices)
    after = way(fine.triangles, fine.through @ mesh.vertices).reshape(4, -1, 3)
    assert (np.einsum("ftk,tk->ft", after, before) > 0.0).all()
