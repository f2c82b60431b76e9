from collections import Counter
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressing_sim.errors import InvalidInputError
from dressing_sim.world.sleeve import FLEX, SleeveConfig, add_sleeve, sleeve_mesh, vertex_body

CENTRE = np.array([0.3, -0.1, 0.4])
AXIS, UPWARDS = np.array([0.6, 0.0, -0.8]), np.array([0.8, 0.0, 0.6])

configs = st.builds(
    SleeveConfig,
    length=st.floats(0.1, 0.5),
    armscye_circumference=st.floats(0.3, 0.6),
    hem_circumference=st.floats(0.2, 0.5),
    areal_density=st.floats(0.1, 0.3),
    vertices_around=st.integers(6, 24),
    vertices_along=st.integers(2, 12),
)


def mesh_of(config):
    return sleeve_mesh(config, CENTRE, AXIS, UPWARDS)


def areas(mesh):
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


@given(configs)
def test_the_ends_are_circles_of_the_circumferences_at_the_length(config):
    rings = mesh_of(config).vertices.reshape(config.vertices_along, config.vertices_around, 3)
    for ring, circumference, distance in (
        (rings[0], config.armscye_circumference, 0.0),
        (rings[-1], config.hem_circumference, config.length),
    ):
        arms = ring - (CENTRE + distance * AXIS)
        np.testing.assert_allclose(np.linalg.norm(arms, axis=1), circumference / (2 * np.pi))
        np.testing.assert_allclose(arms @ AXIS, 0.0, atol=1e-12)
        gaps = np.linalg.norm(np.diff(ring, axis=0, append=ring[:1]), axis=1)
        np.testing.assert_allclose(gaps, gaps[0])
    top = CENTRE + config.armscye_circumference / (2 * np.pi) * UPWARDS
    np.testing.assert_allclose(rings[0, 0], top)


@given(configs)
def test_the_mesh_is_a_tube_that_is_closed_but_for_its_two_ends(config):
    mesh = mesh_of(config)
    sides = Counter()
    for a, b, c in mesh.triangles.tolist():
        sides.update([(a, b), (b, c), (c, a)])
    assert max(sides.values()) == 1  # all triangles turn the same way
    edges = Counter(tuple(sorted(side)) for side in sides)
    assert set(edges.values()) == {1, 2}
    assert sum(n == 1 for n in edges.values()) == 2 * config.vertices_around
    assert {*map(tuple, mesh.edges.tolist())} == {*edges}
    # Euler's characteristic of a cylinder.
    assert len(mesh.vertices) - len(edges) + len(mesh.triangles) == 0
    assert np.unique(mesh.triangles).tolist() == list(range(len(mesh.vertices)))


@given(configs)
def test_triangles_face_outwards(config):
    mesh = mesh_of(config)
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    middle = (a + b + c) / 3 - CENTRE
    outwards = middle - np.outer(middle @ AXIS, AXIS)
    assert np.all(np.einsum("ij,ij->i", np.cross(b - a, c - a), outwards) > 0)


@given(configs)
def test_the_mass_is_that_of_the_cloth(config):
    mesh = mesh_of(config)
    assert np.all(mesh.masses > 0)
    assert mesh.masses.sum() == pytest.approx(config.areal_density * areas(mesh).sum())


def test_a_fine_mesh_weighs_what_the_cone_does():
    config = replace(SleeveConfig(), vertices_around=120, vertices_along=30)
    r1, r2 = np.array([config.armscye_circumference, config.hem_circumference]) / (2 * np.pi)
    cone = np.pi * (r1 + r2) * np.hypot(config.length, r1 - r2)
    assert mesh_of(config).masses.sum() == pytest.approx(config.areal_density * cone, rel=1e-3)
    assert mesh_of(SleeveConfig()).masses.sum() == pytest.approx(
        config.areal_density * cone, rel=0.02
    )


def test_the_fingers_hold_the_top_of_the_armscye():
    config = SleeveConfig()
    mesh = mesh_of(config)
    distance = np.linalg.norm(mesh.vertices - mesh.vertices[0], axis=1)
    assert mesh.gripped[0] == 0
    assert len(mesh.gripped) > 1
    assert set(mesh.gripped) == set(np.flatnonzero(distance <= config.grip_radius))


@given(membrane=st.floats(10, 500), bending=st.floats(1e-6, 1e-3), poisson=st.floats(0, 0.45))
def test_one_sheet_has_both_stiffnesses(membrane, bending, poisson):
    config = SleeveConfig(membrane_stiffness=membrane, bending_stiffness=bending, poisson=poisson)
    young, thickness = config.young, config.elastic_thickness
    assert young * thickness == pytest.approx(membrane)
    assert young * thickness**3 / (12 * (1 - poisson**2)) == pytest.approx(bending)


def test_the_simulated_cloth_has_the_mesh_and_the_mass():
    config, spec = SleeveConfig(), mujoco.MjSpec()
    mesh = mesh_of(config)
    add_sleeve(spec, config, mesh, contype=4, conaffinity=1)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.solver = mujoco.mjtSolver.mjSOL_CG
    model = spec.compile()
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(data.flexvert_xpos, mesh.vertices)
    masses = [model.body(vertex_body(i)).mass[0] for i in range(len(mesh.vertices))]
    np.testing.assert_allclose(masses, mesh.masses)
    assert model.body_mass.sum() == pytest.approx(mesh.masses.sum())
    assert model.nflex == 1
    assert mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_FLEX, 0) == FLEX
    assert model.flex_elemnum[0] == len(mesh.triangles)
    np.testing.assert_allclose(model.flex_friction[0, 0], config.friction)


@pytest.mark.parametrize(
    "name",
    [
        "length",
        "armscye_circumference",
        "hem_circumference",
        "areal_density",
        "membrane_stiffness",
        "bending_stiffness",
        "collision_radius",
        "grip_radius",
    ],
)
@pytest.mark.parametrize("value", [0.0, -0.1, float("nan")])
def test_a_size_that_is_not_positive_is_an_error_that_names_it(name, value):
    with pytest.raises(InvalidInputError, match=rf"{name} is {value}, valid is > 0"):
        SleeveConfig(**{name: value})


@pytest.mark.parametrize("change", [{"vertices_around": 5}, {"vertices_along": 1}])
def test_too_coarse_a_mesh_is_an_error(change):
    with pytest.raises(InvalidInputError, match="too coarse, valid is 6 or more around and 2"):
        SleeveConfig(**change)


@pytest.mark.parametrize("change", [{"friction": -0.1}, {"poisson": 1.0}, {"damping": -1.0}])
def test_impossible_cloth_is_an_error_that_names_what_is(change):
    with pytest.raises(InvalidInputError, match=next(iter(change))):
        SleeveConfig(**change)
