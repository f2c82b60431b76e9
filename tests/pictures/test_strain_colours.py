import mujoco
import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.pictures.strain_colours import StrainColours
from dressing_sim.world.scene import WorldConfig, build_spec

POSTURE = Posture("p", flexion_deg=70.0, abduction_deg=20.0, rotation_deg=30.0, elbow_deg=40.0)


@pytest.fixture
def painted():
    spec, mesh = build_spec(POSTURE, WorldConfig())
    colours = StrainColours(spec, mesh, top=0.2)
    return colours, mesh, spec.compile()


@pytest.mark.parametrize(("strain", "share"), [(0.0, 0.0), (0.1, 0.5), (0.2, 1.0), (0.5, 1.0)])
def test_the_colour_is_in_proportion_to_the_strain_up_to_the_top(painted, strain, share):
    colours, mesh, model = painted
    larger = mesh.vertices * (1.0 + strain)
    np.testing.assert_allclose(colours.at_vertices(larger), strain, atol=1e-9)
    colours.paint(model, larger)
    np.testing.assert_allclose(model.flex_texcoord[:, 0], (0.5 + 255 * share) / 256, atol=1e-6)


def test_only_the_strained_part_changes_colour(painted):
    colours, mesh, model = painted
    moved = mesh.vertices.copy()
    moved[-1] += 0.01
    colours.paint(model, moved)
    unstrained = 0.5 / 256
    changed = set(np.flatnonzero(model.flex_texcoord[:, 0] > unstrained + 1e-6))
    near = mesh.triangles[np.any(mesh.triangles == len(moved) - 1, axis=1)]
    around = set(np.unique(mesh.triangles[np.isin(mesh.triangles, near).any(axis=1)]))
    assert len(moved) - 1 in changed
    assert changed <= around


def test_the_compiled_texture_runs_from_dark_to_bright(painted):
    _, _, model = painted
    texture = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_TEXTURE, "strain")
    start = model.tex_adr[texture]
    pixels = model.tex_data[start : start + 3 * 256].reshape(256, 3).astype(float)
    assert pixels[0].sum() < pixels[-1].sum()
    assert np.ptp(pixels, axis=0).min() > 30
