import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.pictures.strain_colours import StrainScale
from dressing_sim.world.scene import WorldConfig, resting_sleeve

POSTURE = Posture("p", flexion_deg=70.0, abduction_deg=20.0, rotation_deg=30.0, elbow_deg=40.0)


@pytest.fixture
def scale():
    mesh = resting_sleeve(POSTURE, WorldConfig().sleeve)
    return StrainScale(mesh, top=0.2), mesh


@pytest.mark.parametrize(("strain", "share"), [(0.0, 0.0), (0.1, 0.5), (0.2, 1.0), (0.5, 1.0)])
def test_the_colour_is_in_proportion_to_the_strain_up_to_the_top(scale, strain, share):
    colours, mesh = scale
    found = colours.at_vertices(mesh.vertices * (1.0 + strain))
    np.testing.assert_allclose(found, strain, atol=1e-9)
    np.testing.assert_allclose(colours.column(found), (0.5 + 255 * share) / 256, atol=1e-6)


def test_only_the_strained_part_changes_colour(scale):
    colours, mesh = scale
    moved = mesh.vertices.copy()
    moved[-1] += 0.01
    changed = set(np.flatnonzero(colours.at_vertices(moved) > 1e-6))
    near = mesh.triangles[np.any(mesh.triangles == len(moved) - 1, axis=1)]
    around = set(np.unique(mesh.triangles[np.isin(mesh.triangles, near).any(axis=1)]))
    assert len(moved) - 1 in changed
    assert changed <= around


def test_the_colours_run_from_dark_to_bright(scale):
    pixels = scale[0].picture()[0].astype(float)
    assert pixels.shape == (256, 3)
    assert pixels[0].sum() < pixels[-1].sum()
    assert np.ptp(pixels, axis=0).min() > 30
