import numpy as np
import pytest

from dressing_sim.pictures.implicit import Cone, Solid, gradient, shade, surface

BALL = Solid((Cone(np.zeros(3), np.array([0.0, 0.0, 1e-9]), (0.1, 0.1)),), 0.01)


def test_a_balls_distance_and_gradient_are_known(rng):
    points = rng.normal(size=(50, 3))
    lengths = np.linalg.norm(points, axis=1)
    near = points / lengths[:, None] * rng.uniform(0.05, 0.3, size=(50, 1))
    np.testing.assert_allclose(BALL(near), np.linalg.norm(near, axis=1) - 0.1, atol=1e-9)
    np.testing.assert_allclose(gradient(BALL, near), points / lengths[:, None], atol=1e-3)


def test_its_surface_is_a_closed_sphere_seen_from_outside():
    vertices, faces, normals = surface(BALL, BALL.box(), 0.015)
    np.testing.assert_allclose(np.linalg.norm(vertices, axis=1), 0.1, atol=1e-6)
    np.testing.assert_allclose(normals, 10.0 * vertices, atol=1e-2)
    p = vertices[faces]
    across = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    assert (np.einsum("ij,ij->i", across, p.mean(axis=1)) > 0.0).all()
    volume = np.einsum("ij,ij->i", p[:, 0], across).sum() / 6.0
    assert volume == pytest.approx(4.0 / 3.0 * np.pi * 0.1**3, rel=0.02)
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert set(np.unique(edges, axis=0, return_counts=True)[1]) == {2}


def test_parts_flow_together_between_them_alone():
    ends = np.array([[0.0, 0.0, 0.0], [0.15, 0.0, 0.0]])
    parts = tuple(Cone(end, end + 1e-9, (0.08, 0.08)) for end in ends)
    sharp, soft = Solid(parts, 1e-6), Solid(parts, 0.05)
    between, away = np.array([[0.075, 0.04, 0.0]]), np.array([[-0.08, 0.0, 0.0]])
    assert soft(between)[0] < sharp(between)[0] - 0.01
    np.testing.assert_allclose(soft(away), sharp(away), atol=1e-9)


def test_what_is_in_a_corner_is_darker():
    floor = Solid((Cone(np.array([0.0, 0.0, -5.0]), np.array([0.0, 0.0, -5.1]), (5.0, 5.0)),), 1e-6)

    def both(points):
        return np.minimum(BALL(points), floor(points))

    down, up = np.array([[0.0, 0.0, -0.1]]), np.array([[0.0, 0.0, 0.1]])
    assert shade(both, down, 10.0 * down)[0] < shade(both, up, 10.0 * up)[0] - 0.2
