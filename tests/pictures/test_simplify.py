import numpy as np

from dressing_sim.pictures.implicit import Cone, Solid, surface
from dressing_sim.pictures.simplify import simplified


def test_a_ball_of_fewer_triangles_is_still_that_ball():
    ball = Solid((Cone(np.zeros(3), np.array([0.0, 0.0, 1e-9]), (0.1, 0.1)),), 0.01)
    vertices, faces, _ = surface(ball, ball.box(), 0.006)
    fewer, left = simplified(vertices, faces.astype(np.int64), 0.001)
    assert len(left) < 0.4 * len(faces)
    np.testing.assert_allclose(np.linalg.norm(fewer, axis=1), 0.1, atol=0.002)
    p = fewer[left]
    across = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (np.einsum("ij,ij->i", across, p.mean(axis=1)) > 0.0).all()


def test_the_edge_of_a_plane_and_its_corners_stay():
    x, y = np.meshgrid(np.linspace(0.0, 1.0, 12), np.linspace(0.0, 1.0, 12))
    points = np.stack([x.ravel(), y.ravel(), 0.0 * x.ravel()], axis=1)
    a = (np.arange(11)[:, None] * 12 + np.arange(11)).ravel()
    faces = np.concatenate([np.stack([a, a + 1, a + 13], 1), np.stack([a, a + 13, a + 12], 1)])
    fewer, left = simplified(points, faces, 1e-3)
    assert len(left) < 0.5 * len(faces)
    p = fewer[left]
    area = 0.5 * np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])[:, 2]
    assert (area > 0.0).all()
    np.testing.assert_allclose(area.sum(), 1.0, atol=1e-2)
