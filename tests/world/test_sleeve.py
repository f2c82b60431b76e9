from collections import Counter
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from dressing_sim.errors import InvalidInputError
from dressing_sim.world.garment import GARMENTS, Garment
from dressing_sim.world.scene import SolverConfig, WorldConfig
from dressing_sim.world.sleeve import FLEX, SleeveConfig, add_sleeve, sleeve_mesh, vertex_body

CENTRE = np.array([0.3, -0.1, 0.4])
AXIS, UPWARDS = np.array([0.6, 0.0, -0.8]), np.array([0.8, 0.0, 0.6])
SIDE = np.cross(AXIS, UPWARDS)

sleeves = st.builds(
    Garment,
    length=st.floats(0.1, 0.5),
    armscye_circumference=st.floats(0.3, 0.6),
    hem_circumference=st.floats(0.2, 0.5),
)
shirts = st.builds(replace, sleeves, body=st.floats(0.02, 0.4))
edges = st.floats(0.015, 0.045)
configs = st.builds(SleeveConfig, garment=sleeves | shirts, edge=edges)


def mesh_of(config):
    return sleeve_mesh(config, CENTRE, AXIS, UPWARDS)


def cylindrical(points):
    """Of points (..., 3): angle from the top, radius, and way along the axis to the hem."""
    arms = points - CENTRE
    up, side = arms @ UPWARDS, arms @ SIDE
    return np.arctan2(side, up), np.hypot(side, up), arms @ AXIS


def areas(mesh):
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def edge_ratios(mesh):
    """Longest over shortest side of each triangle; 1.41 of half a square."""
    corners = mesh.vertices[mesh.triangles]
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    return sides.max(axis=1) / sides.min(axis=1)


# Shape


@given(configs)
def test_each_ring_is_a_closed_polygon_as_long_as_the_garment_is_round(config):
    garment, mesh = config.garment, mesh_of(config)
    rings = mesh.rings(mesh.vertices)
    assert rings.shape == (mesh.along, mesh.around, 3)
    perimeters = np.linalg.norm(np.roll(rings, -1, axis=1) - rings, axis=2).sum(axis=1)
    angle, radius, way = cylindrical(rings)
    np.testing.assert_allclose(way - way[:, :1], 0.0, atol=1e-12)
    share = way[:, 0] / garment.length
    ends = garment.armscye_circumference, garment.hem_circumference
    np.testing.assert_allclose(perimeters, ends[0] + share * (ends[1] - ends[0]))
    np.testing.assert_allclose(way[[0, -1], 0], [0.0, garment.length], atol=1e-12)
    assert np.all(np.diff(way[:, 0]) > 0)
    np.testing.assert_allclose(radius, np.broadcast_to(radius[:, :1], radius.shape))
    # Once round, always the same way.
    turns = np.diff(angle, axis=1, append=angle[:, :1]) % (2.0 * np.pi)
    np.testing.assert_allclose(turns.sum(axis=1), 2.0 * np.pi)


@given(configs)
def test_vertex_0_is_the_topmost_of_the_armscye(config):
    armscye = mesh_of(config).vertices[: config.vertices_around]
    assert cylindrical(armscye[0])[0] == pytest.approx(0.0, abs=1e-12)
    assert np.argmax(armscye @ UPWARDS) == 0


@given(sleeves, edges)
def test_a_sleeve_is_a_tube_that_is_closed_but_for_its_two_ends(garment, edge):
    mesh = mesh_of(SleeveConfig(garment=garment, edge=edge))
    sides = sides_of(mesh)
    assert len(mesh.vertices) - len(mesh.edges) + len(mesh.triangles) == 0  # Euler: a cylinder
    open_edges = {frozenset(side) for side in sides if side[::-1] not in sides}
    ring = np.arange(mesh.around)
    hem = ring + (mesh.along - 1) * mesh.around
    ends = [zip(end, np.roll(end, -1), strict=True) for end in (ring.tolist(), hem.tolist())]
    assert open_edges == {frozenset(pair) for end in ends for pair in end}


@given(configs)
def test_the_mesh_is_one_piece_of_triangles_that_turn_the_same_way(config):
    mesh = mesh_of(config)
    sides = sides_of(mesh)
    assert max(sides.values()) == 1
    assert {frozenset(side) for side in sides} == {frozenset(e) for e in mesh.edges.tolist()}
    # Flood the mesh from vertex 0.
    reached, front = {0}, {0}
    neighbours = {}
    for a, b in sides:
        neighbours.setdefault(a, set()).add(b)
        neighbours.setdefault(b, set()).add(a)
    while front:
        front = set().union(*(neighbours[vertex] for vertex in front)) - reached
        reached |= front
    assert reached == set(range(len(mesh.vertices)))
    # A sheet sewn to a tube along a part of its end leaves Euler's characteristic as it is.
    assert len(mesh.vertices) - len(mesh.edges) + len(mesh.triangles) == 0


def sides_of(mesh):
    """How often each side of a triangle is passed, by direction."""
    sides = Counter()
    for a, b, c in mesh.triangles.tolist():
        sides.update([(a, b), (b, c), (c, a)])
    return sides


@given(configs)
def test_triangles_face_outwards(config):
    mesh = mesh_of(config)
    a, b, c = mesh.vertices[mesh.triangles].transpose(1, 0, 2)
    middle = (a + b + c) / 3 - CENTRE
    outwards = middle - np.outer(middle @ AXIS, AXIS)
    assert np.all(np.einsum("ij,ij->i", np.cross(b - a, c - a), outwards) > 0)


@given(shirts, edges)
def test_the_shirts_body_hangs_from_the_lower_half_of_the_armscye_only(garment, edge):
    config = SleeveConfig(garment=garment, edge=edge)
    mesh = mesh_of(config)
    sleeve = mesh_of(replace(config, garment=replace(garment, body=0.0)))
    on_sleeve = len(sleeve.vertices)
    np.testing.assert_array_equal(mesh.vertices[:on_sleeve], sleeve.vertices)
    np.testing.assert_array_equal(mesh.gripped, sleeve.gripped)
    angle, _, way = cylindrical(mesh.vertices[on_sleeve:])
    assert np.all(np.cos(angle) < 1e-9)
    assert np.all(way < -1e-9)
    assert way.min() == pytest.approx(-garment.body)
    sewn = set(mesh.triangles[(mesh.triangles >= on_sleeve).any(axis=1)].ravel().tolist())
    sewn = np.array(sorted(vertex for vertex in sewn if vertex < on_sleeve))
    angle, _, way = cylindrical(mesh.vertices[sewn])
    np.testing.assert_allclose(way, 0.0, atol=1e-12)
    # All of the lower half, but for less than a cell on either side.
    assert np.all(np.cos(angle) < 1e-9)
    cell = 2.0 * np.pi / (mesh.around - len(mesh.gripped))
    assert np.ptp(angle % (2.0 * np.pi)) > np.pi - 2.0 * cell


@pytest.mark.parametrize("edge", [0.040, 0.034, 0.024, 0.017, 0.012])
@pytest.mark.parametrize("name", GARMENTS)
def test_triangles_are_nearly_equilateral(name, edge):
    """But for the columns and rows of the gripped patch, whose size the mesh does not choose.

    Half a square has 1.41. A T-shirt's sleeve narrows to 0.77 of its width, which makes of an
    equilateral triangle one of 1.23, the long sleeve to 0.67, 1.39; 10 % more since the patch, and
    what is left beside it, have whole numbers of rows and columns.
    """
    config = SleeveConfig(garment=GARMENTS[name], edge=edge)
    mesh = mesh_of(config)
    angle, _, way = cylindrical(mesh.vertices[mesh.triangles])
    patch = np.pi * config.grip_width / config.garment.armscye_circumference
    beside = np.abs(angle).min(axis=1) > patch - 1e-9
    beyond = (way.min(axis=1) > config.grip_depth - 1e-9) | (way.max(axis=1) < 1e-9)
    away = beside & beyond
    assert away.mean() > (0.7 if edge < 0.04 else 0.6)
    ratios = edge_ratios(mesh)
    narrow = config.garment.hem_circumference / config.garment.armscye_circumference
    narrowed = np.sqrt(0.75 + 0.25 * narrow**2) / narrow
    assert ratios[away].max() < 1.1 * narrowed
    assert np.median(ratios) < 1.25


@pytest.mark.parametrize("edge", [0.040, 0.034, 0.020, 0.017])
def test_edges_are_as_long_as_asked_for(edge):
    mesh = mesh_of(SleeveConfig(edge=edge))
    lengths = np.linalg.norm(np.diff(mesh.vertices[mesh.edges], axis=1)[:, 0], axis=1)
    assert np.median(lengths) == pytest.approx(edge, rel=0.1)


# Mass


@given(configs)
def test_the_mass_is_that_of_the_cloth_in_every_mesh(config):
    """And is spread evenly: a third of a triangle's mass is at each of its corners."""
    mesh, garment = mesh_of(config), config.garment
    whole = garment.sleeve_area + garment.body_area
    assert mesh.masses.sum() == pytest.approx(garment.fabric.areal_density * whole)
    on_sleeve = (mesh.triangles < mesh.around * mesh.along).all(axis=1)
    centre = np.zeros(3)
    for part, area in ((on_sleeve, garment.sleeve_area), (~on_sleeve, garment.body_area)):
        if part.any():
            corners = mesh.vertices[mesh.triangles[part]].mean(axis=1)
            centre += area / whole * np.average(corners, axis=0, weights=areas(mesh)[part])
    np.testing.assert_allclose(mesh.masses @ mesh.vertices / mesh.masses.sum(), centre, atol=1e-12)


def test_a_fine_mesh_has_the_areas_of_the_cone_and_of_half_the_body():
    for body in (0.0, 0.25):
        garment = Garment(body=body)
        fine = areas(mesh_of(SleeveConfig(garment=garment, edge=0.005))).sum()
        whole = garment.sleeve_area + garment.body_area
        assert fine == pytest.approx(whole, rel=0.02 if body else 1e-3)


# Grip


@given(edge=st.floats(0.008, 0.045), width=st.floats(0.02, 0.1), depth=st.floats(0.01, 0.06))
def test_the_fingers_hold_the_same_piece_of_cloth_in_every_mesh(edge, width, depth):
    config = SleeveConfig(edge=edge, grip_width=width, grip_depth=depth)
    mesh = mesh_of(config)
    angle, _, way = cylindrical(mesh.vertices)
    assert mesh.gripped[0] == 0
    half = np.pi * width / config.garment.armscye_circumference
    held = (np.abs(angle) < half + 1e-9) & (way < depth + 1e-9)
    assert set(mesh.gripped) == set(np.flatnonzero(held))
    assert way[mesh.gripped].max() == pytest.approx(depth)
    ring_of = mesh.gripped // mesh.around
    for ring in range(ring_of.max() + 1):
        ends = np.sort(angle[mesh.gripped[ring_of == ring]])[[0, -1]]
        # Rows of even number end at the patch's ends, the others half a cell before.
        cell = 2.0 * half / (np.sum(ring_of == 0) - 1)
        np.testing.assert_allclose(ends, np.array([-1, 1]) * (half - ring % 2 * 0.5 * cell))


@given(st.floats(0.008, 0.045))
def test_the_held_part_of_the_armscye_is_as_wide_as_the_grip(edge):
    """A chord is shorter than its arc by (angle)^2 / 24, and a ring as long as the circle."""
    config = SleeveConfig(edge=edge)
    mesh = mesh_of(config)
    armscye = mesh.vertices[np.sort(mesh.gripped[mesh.gripped < mesh.around])]
    middle = np.argmax(np.diff(mesh.gripped[mesh.gripped < mesh.around]))
    chain = np.roll(armscye, -middle - 1, axis=0)
    width = np.linalg.norm(np.diff(chain, axis=0), axis=1).sum()
    widest = 2.0 * np.pi / (mesh.around - len(armscye))
    assert width == pytest.approx(config.grip_width, rel=1.1 * widest**2 / 24.0)


@pytest.mark.parametrize("name", ["grip_width", "grip_depth"])
def test_a_grip_larger_than_the_garment_is_an_error_that_names_it(name):
    with pytest.raises(InvalidInputError, match=rf"{name} is 0.3, valid for this garment is <"):
        SleeveConfig(**{name: 0.3})


@given(sleeves, edges, st.floats(0.05, 0.95), st.floats(0.05, 0.95))
@example(Garment(length=0.1), 0.045, 0.95, 0.95)
def test_however_large_the_grip_the_sleeve_keeps_its_length_and_its_rings(garment, edge, w, d):
    width, depth = 0.5 * w * garment.armscye_circumference, d * garment.length
    config = SleeveConfig(garment=garment, edge=edge, grip_width=width, grip_depth=depth)
    mesh = mesh_of(config)
    assert (mesh.along, mesh.around) == (config.vertices_along, config.vertices_around)
    assert len(mesh.vertices) == mesh.along * mesh.around
    assert cylindrical(mesh.vertices)[2].max() == pytest.approx(garment.length)
    assert areas(mesh).min() > 0.0


# Simulation


@pytest.mark.parametrize("body", [0.0, 0.25])
def test_the_simulated_cloth_has_the_mesh_and_the_mass(body):
    config, spec = SleeveConfig(garment=Garment(body=body)), mujoco.MjSpec()
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
    fabric = config.garment.fabric
    np.testing.assert_allclose(model.flex_friction[0, 0], fabric.friction)
    np.testing.assert_allclose(model.flex_radius[0], 0.5 * fabric.thickness)
    np.testing.assert_allclose(model.flex_solref[0], [config.contact_time, 1.0])
    np.testing.assert_allclose(
        model.flex_solimp[0, 1:3], [config.contact_impedance, config.contact_depth]
    )


# Settings


@pytest.mark.parametrize("name", ["edge", "grip_width", "grip_depth", "contact_time"])
@pytest.mark.parametrize("value", [0.0, -0.1, float("nan"), float("inf")])
def test_a_size_that_is_not_positive_is_an_error_that_names_it(name, value):
    with pytest.raises(InvalidInputError, match=rf"sleeve: {name} is {value}, valid is > 0"):
        SleeveConfig(**{name: value})


@pytest.mark.parametrize("name", ["grip_impedance", "contact_impedance"])
@pytest.mark.parametrize("value", [0.0, 1.0, -0.1, float("nan")])
def test_an_impedance_outside_0_to_1_is_an_error_that_names_it(name, value):
    with pytest.raises(InvalidInputError, match=rf"{name} is {value}, valid is between 0 and 1"):
        SleeveConfig(**{name: value})


@pytest.mark.parametrize("value", [(0.0, 0.0), (0.0, 0.0, float("nan"))])
def test_a_grasp_offset_that_is_not_three_lengths_is_an_error(value):
    with pytest.raises(InvalidInputError, match=r"grasp_offset has .* valid is \(3,\) of finite"):
        SleeveConfig(grasp_offset=value)


@pytest.mark.parametrize(
    ("change", "most"),
    [
        ({"edge": 0.07, "garment": Garment(armscye_circumference=0.9, length=0.8)}, "0.06"),
        ({"contact_time": 1.0}, "0.05"),
    ],
)
def test_what_lets_cloth_through_the_arm_is_an_error_that_says_how_much_is_valid(change, most):
    name = next(iter(change))
    with pytest.raises(InvalidInputError, match=rf"sleeve: {name} is .*, valid is up to {most}"):
        SleeveConfig(**change)


def test_a_contact_heals_in_two_steps_or_more():
    """MuJoCo would silently take two steps instead."""
    WorldConfig(SleeveConfig(contact_time=0.01), solver=SolverConfig(timestep=0.005))
    with pytest.raises(InvalidInputError, match=r"contact_time is 0.01 s, valid is at least twice"):
        WorldConfig(SleeveConfig(contact_time=0.01), solver=SolverConfig(timestep=0.006))


@pytest.mark.parametrize("change", [{"edge": 0.1}, {"garment": Garment(length=0.03)}])
def test_too_coarse_a_mesh_is_an_error_that_says_what_to_do(change):
    with pytest.raises(InvalidInputError, match=r"too coarse, .* choose a shorter edge"):
        SleeveConfig(**change)
