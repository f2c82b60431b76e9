import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.suites.suites import load_suite
from dressing_sim.viewer.shapes import (
    N_COLOURS,
    Cloth,
    capsule,
    coarser,
    likeness,
    person,
    read_obj,
)
from dressing_sim.world.scene import WorldConfig, resting_sleeve


@pytest.mark.parametrize("length", [0.0, 0.3])
def test_a_capsules_vertices_are_at_its_radius_from_its_axis(length, rng):
    start, way = rng.normal(size=3), rng.normal(size=3)
    end = start + length * way / np.linalg.norm(way)
    vertices, _ = capsule(start, end, 0.04)
    along = np.clip((vertices - start) @ (end - start) / max(length, 1e-9) ** 2, 0.0, 1.0)
    distance = np.linalg.norm(vertices - (start + along[:, None] * (end - start)), axis=1)
    assert np.allclose(distance, 0.04, atol=1e-6)


def test_all_postures_have_as_many_vertices_and_faces():
    shapes = {
        tuple((mesh.vertices.shape, mesh.faces.shape) for mesh in person(posture).values())
        for posture in load_suite("paper5")
    }
    assert len(shapes) == 1


def test_a_likeness_is_whole_and_goes_with_its_arm():
    for posture in load_suite("paper5")[:2]:
        parts = likeness(posture)
        assert {"skin", "shirt", "trousers"} <= set(parts)
        for mesh in parts.values():
            assert mesh.faces.max() == len(mesh.vertices) - 1
            assert np.isfinite(mesh.vertices).all()
        points = np.concatenate([mesh.vertices for mesh in parts.values()])
        for joint in (posture.wrist, posture.elbow, posture.shoulder):
            assert np.linalg.norm(points - joint, axis=1).min() < 0.07


def test_every_triangle_of_the_cloth_is_drawn_in_one_colour_that_rises_with_strain():
    sleeve = resting_sleeve(Posture("one", 80.0, 40.0, 50.0, 40.0), WorldConfig().sleeve)
    cloth = Cloth(sleeve, 0.3)
    for stretch, colour in ((1.0, 0), (1.16, N_COLOURS // 2), (2.0, N_COLOURS - 1)):
        given = (stretch * sleeve.vertices).astype(np.float32)
        vertices, parts = cloth.drawn(given)
        assert sum(map(len, parts)) == 4 * len(sleeve.triangles)
        assert len(parts[colour]) == 4 * len(sleeve.triangles)
        assert max(part.max(initial=0) for part in parts) < len(vertices)


def test_a_coarser_mesh_is_near_the_given_one():
    vertices, faces = read_obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1.001 0 0\nf 1//1 2//1 3//1\nf 2 4 3")
    merged, kept = coarser(vertices, faces)
    assert kept.shape == (1, 3)  # the sliver is gone
    assert np.allclose(sorted(merged[:, 0]), [0.0, 0.0, 1.0005])
