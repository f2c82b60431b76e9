from dataclasses import replace

import mujoco
import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.world.garment import Fabric, Garment
from dressing_sim.world.robot import PANDA
from dressing_sim.world.scene import (
    SolverConfig,
    WorldConfig,
    build_spec,
    grip_name,
    grip_start,
    resting_sleeve,
)
from dressing_sim.world.sleeve import SleeveConfig

SHIRT = SleeveConfig(garment=Garment(body=0.25))


@pytest.mark.parametrize("edge", [0.040, 0.034, 0.020, 0.017])
def test_the_gripper_starts_at_the_top_of_the_armscye_which_is_round_the_wrist(posture, edge):
    config = SleeveConfig(edge=edge)
    armscye = resting_sleeve(posture, config).rings(resting_sleeve(posture, config).vertices)[0]
    away = np.linalg.norm(armscye - posture.wrist, axis=1)
    np.testing.assert_allclose(away, away[0])
    forearm = posture.wrist - posture.elbow
    np.testing.assert_allclose((armscye - posture.wrist) @ forearm, 0.0, atol=1e-12)
    # A polygon as long as the circle has corners beyond it, by (edge / radius)^2 / 24.
    top = grip_start(posture, config)
    radius = np.linalg.norm(top - posture.wrist)
    assert radius == pytest.approx(config.garment.armscye_circumference / (2 * np.pi))
    longest = np.linalg.norm(np.roll(armscye, 1, axis=0) - armscye, axis=1).max()
    beyond = np.linalg.norm(armscye[0] - top)
    assert 0.0 < beyond < 1.1 * longest**2 / (24.0 * radius)
    assert top[2] > posture.wrist[2]


def test_a_grasp_offset_moves_the_gripper_and_nothing_else(posture):
    plain = SleeveConfig()
    config = SleeveConfig(grasp_offset=(0.01, -0.02, 0.03))
    axes = posture.frames()[1].A
    moved = grip_start(posture, config) - grip_start(posture, plain)
    np.testing.assert_allclose(moved, axes @ config.grasp_offset)
    one, other = resting_sleeve(posture, plain), resting_sleeve(posture, config)
    np.testing.assert_array_equal(one.vertices, other.vertices)
    np.testing.assert_array_equal(one.gripped, other.gripped)
    specs = [build_spec(posture, WorldConfig(sleeve=sleeve))[0] for sleeve in (plain, config)]
    assert specs[0].to_xml() == specs[1].to_xml()


def test_the_hem_is_beyond_the_hand(posture):
    config = WorldConfig().sleeve
    mesh = resting_sleeve(posture, config)
    away = (posture.wrist - posture.elbow) / posture.arm_size.forearm_length
    hem = mesh.rings(mesh.vertices)[-1] - posture.wrist
    np.testing.assert_allclose(hem @ away, config.garment.length)


def test_the_shirts_body_is_on_the_arms_side_of_the_wrist(posture):
    mesh = resting_sleeve(posture, SHIRT)
    body = mesh.vertices[mesh.along * mesh.around :] - posture.wrist
    towards = (posture.elbow - posture.wrist) / posture.arm_size.forearm_length
    assert np.all(body @ towards > 0.0)
    assert (body @ towards).max() == pytest.approx(SHIRT.garment.body)
    assert np.all(body @ posture.frames()[1].A[:, 2] < 1e-9)


@pytest.mark.parametrize("sleeve", [SleeveConfig(), SHIRT])
def test_the_model_has_a_grip_a_vertex_held_and_a_body_a_vertex(posture, sleeve):
    spec, mesh = build_spec(posture, WorldConfig(sleeve=sleeve))
    model = spec.compile()
    held = [model.equality(grip_name(vertex)) for vertex in mesh.gripped]
    assert model.neq >= len(held) == len(mesh.gripped)
    assert model.nflexvert == len(mesh.vertices)


def test_cloth_and_mannequin_have_the_fabrics_friction(posture):
    """MuJoCo takes the larger of two frictions, so both must have it."""
    garment = Garment(fabric=Fabric(friction=0.17))
    spec, _ = build_spec(posture, WorldConfig(sleeve=SleeveConfig(garment=garment)))
    model = spec.compile()
    touched = model.geom_friction[(model.geom_contype & model.flex_conaffinity[0]) > 0, 0]
    assert len(touched) > 0
    np.testing.assert_allclose(touched, 0.17)
    assert model.flex_friction[0, 0] == pytest.approx(0.17)


@pytest.mark.parametrize("solver", ["CG", "Newton"])
def test_the_solver_is_the_one_asked_for(posture, solver):
    config = WorldConfig(solver=SolverConfig(0.004, solver, 77, 1e-5, 3.0))
    option = build_spec(posture, config)[0].compile().opt
    assert option.solver == getattr(mujoco.mjtSolver, f"mjSOL_{solver.upper()}")
    assert (option.timestep, option.iterations, option.tolerance) == (0.004, 77, 1e-5)
    assert option.impratio == 3.0
    assert option.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE


def test_the_same_posture_makes_the_same_model(posture):
    one, other = (build_spec(posture, WorldConfig())[0].to_xml() for _ in range(2))
    assert one == other
    assert build_spec(replace(posture, elbow_deg=20), WorldConfig())[0].to_xml() != one


@pytest.mark.parametrize(
    "change",
    [
        {"solver": "PGS"},
        {"iterations": 0},
        {"timestep": 0.0},
        {"tolerance": -1.0},
        {"impratio": 0.0},
    ],
)
def test_an_impossible_solver_is_an_error_that_names_what_is(change):
    with pytest.raises(InvalidInputError, match=rf"{next(iter(change))} (is .*valid is|must be)"):
        SolverConfig(**change)


@pytest.mark.parametrize(
    "make",
    [lambda: WorldConfig(settle_time=-1.0), lambda: replace(PANDA, grip_strength=-1.0)],
    ids=["settle_time", "grip_strength"],
)
def test_an_impossible_world_is_an_error_that_names_what_is(make, request):
    with pytest.raises(InvalidInputError, match=request.node.callspec.id):
        make()
