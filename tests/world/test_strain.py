import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from dressing_sim.world.garment import Garment
from dressing_sim.world.sleeve import SleeveConfig, SleeveMesh, sleeve_mesh
from dressing_sim.world.strain import StrainGauge

seeds = st.integers(0, 2**32 - 1)


def sleeve():
    config = SleeveConfig(garment=Garment(body=0.25))
    return sleeve_mesh(config, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))


def flat(corners, triangles):
    """A mesh in the plane z = 0."""
    vertices = np.column_stack([corners, np.zeros(len(corners))])
    masses, gripped = np.zeros(0), np.zeros(0, dtype=np.int32)
    return SleeveMesh(vertices, np.array(triangles, dtype=np.int32), masses, gripped, 0, 0)


def random_triangles(seed, count=10):
    rng = np.random.default_rng(seed)
    corners = rng.uniform(-1, 1, (count, 3, 2))
    # All near one proper triangle: no slivers, and all the same way round.
    corners = np.array([[0, 0], [1, 0], [0.3, 0.9]]) + 0.2 * corners
    return flat(corners.reshape(-1, 2), np.arange(3 * count).reshape(-1, 3))


def moved(points, seed):
    rng = np.random.default_rng(seed)
    return Rotation.from_quat(rng.standard_normal(4)).apply(points) + rng.uniform(-1, 1, 3)


@given(seeds)
def test_a_rigid_motion_is_no_strain(seed):
    mesh = sleeve()
    strain = StrainGauge(mesh).principal(moved(mesh.vertices, seed))
    np.testing.assert_allclose(strain, 0.0, atol=1e-7)


@given(seeds, st.floats(0.5, 2.0))
def test_a_uniform_stretch_is_its_strain(seed, stretch):
    mesh = sleeve()
    strain = StrainGauge(mesh).principal(moved(stretch * mesh.vertices, seed))
    np.testing.assert_allclose(strain, stretch - 1.0, atol=1e-7)


@given(seeds, st.floats(0.5, 2.0), st.floats(0.5, 2.0))
def test_of_two_stretches_the_larger_counts(seed, first, second):
    mesh = random_triangles(seed)
    strain = StrainGauge(mesh).principal(moved(mesh.vertices * [first, second, 1.0], seed))
    np.testing.assert_allclose(strain, max(first, second) - 1.0, atol=1e-7)


@given(seeds, st.floats(-2.0, 2.0))
def test_simple_shear_has_its_closed_form(seed, shear):
    mesh = random_triangles(seed)
    sheared = mesh.vertices + np.outer(mesh.vertices[:, 1], [shear, 0.0, 0.0])
    strain = StrainGauge(mesh).principal(moved(sheared, seed))
    expected = 0.5 * abs(shear) + np.sqrt(1.0 + 0.25 * shear**2) - 1.0
    np.testing.assert_allclose(strain, expected, atol=1e-7)


@given(seeds)
def test_any_deformation_agrees_with_singular_values(seed):
    gradient = np.random.default_rng(seed).standard_normal((3, 2))
    mesh = random_triangles(seed)
    strain = StrainGauge(mesh).principal(mesh.vertices[:, :2] @ gradient.T)
    np.testing.assert_allclose(
        strain, np.linalg.svd(gradient, compute_uv=False)[0] - 1.0, atol=1e-7
    )


def test_areas_are_those_at_rest():
    mesh = flat([[0, 0], [2, 0], [0, 3], [2, 3]], [[0, 1, 2], [1, 3, 2]])
    np.testing.assert_allclose(StrainGauge(mesh).areas, [3.0, 3.0])


@pytest.mark.parametrize(
    ("percent", "expected"), [(0, 0.1), (20, 0.1), (30, 0.2), (89, 0.2), (91, 0.3), (100, 0.3)]
)
def test_the_percentile_is_one_of_area_not_of_triangles(percent, expected):
    # Areas 0.25, 0.1 and 0.65 of the whole; strains in another order.
    corners = [[0, 0], [5, 0], [0, 1], [2, 0], [13, 0]]
    gauge = StrainGauge(flat(corners, [[0, 1, 2], [0, 3, 2], [0, 4, 2]]))
    np.testing.assert_allclose(gauge.areas, [2.5, 1.0, 6.5])
    assert gauge.percentile(np.array([0.1, 0.3, 0.2]), percent) == expected


@given(seeds, st.floats(0.0, 100.0))
def test_so_much_of_the_area_stays_at_or_below_the_percentile(seed, percent):
    gauge = StrainGauge(sleeve())
    strain = np.random.default_rng(seed).uniform(0, 1, len(gauge.areas))
    value = gauge.percentile(strain, percent)
    share = gauge.areas / gauge.areas.sum() * 100.0
    assert share[strain <= value].sum() >= percent - 1e-9
    assert share[strain < value].sum() <= percent + 1e-9


def test_edges_stretch_as_the_cloth_does_along_them():
    """An edge at an angle a to a stretch s gets sqrt(1 + (s^2 - 1) cos^2 a) as long."""
    mesh = flat([[0, 0], [1, 0], [0.5, np.sqrt(0.75)]], [[0, 1, 2]])
    gauge = StrainGauge(mesh)
    stretched = mesh.vertices * [1.2, 1.0, 1.0]
    slanted = np.sqrt(1.0 + (1.2**2 - 1.0) / 4.0) - 1.0
    assert gauge.edge_percentile(stretched, 100.0) == pytest.approx(0.2)
    # Two of the three edges, all as long at rest.
    assert gauge.edge_percentile(stretched, 60.0) == pytest.approx(slanted)
    assert gauge.edge_percentile(mesh.vertices, 50.0) == pytest.approx(0.0, abs=1e-12)


@given(seeds)
def test_no_edge_is_strained_more_than_the_triangles(seed):
    """An edge sees a stretch between a triangle's two principal ones."""
    mesh = random_triangles(seed)
    gauge = StrainGauge(mesh)
    rng = np.random.default_rng(seed)
    deformed = mesh.vertices @ (np.eye(3) + 0.2 * rng.uniform(-1, 1, (3, 3)))
    most = gauge.principal(deformed).max()
    assert gauge.edge_percentile(deformed, 100.0) <= most + 1e-9
