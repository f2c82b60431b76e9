from dataclasses import replace

import mujoco
import numpy as np
import pytest

from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.scene import (
    SolverConfig,
    WorldConfig,
    build_spec,
    force_sensor_name,
    grip_name,
    grip_start,
    resting_sleeve,
)


def test_the_gripper_starts_at_the_top_of_the_armscye_which_is_round_the_wrist(posture):
    config = WorldConfig().sleeve
    mesh = resting_sleeve(posture, config)
    np.testing.assert_allclose(mesh.vertices[0], grip_start(posture, config))
    armscye = mesh.vertices[: config.vertices_around]
    np.testing.assert_allclose(armscye.mean(axis=0), posture.wrist, atol=1e-12)
    assert grip_start(posture, config)[2] > posture.wrist[2]


def test_the_hem_is_beyond_the_hand(posture):
    config = WorldConfig().sleeve
    hem = resting_sleeve(posture, config).vertices[-config.vertices_around :].mean(axis=0)
    away = (posture.wrist - posture.elbow) / posture.arm_size.forearm_length
    np.testing.assert_allclose(hem, posture.wrist + config.length * away, atol=1e-12)


def test_the_model_has_a_sensor_a_link_and_a_grip_a_vertex_held(posture):
    spec, mesh = build_spec(posture, WorldConfig())
    model = spec.compile()
    for link in LINKS:
        for source in ("all", "robot"):
            sensor = model.sensor(force_sensor_name(link, source))
            assert sensor.type[0] == mujoco.mjtSensor.mjSENS_CONTACT
            assert sensor.dim[0] == 4  # found, and a force
    held = [model.equality(grip_name(vertex)) for vertex in mesh.gripped]
    assert model.neq >= len(held) == len(mesh.gripped)


@pytest.mark.parametrize("solver", ["CG", "Newton"])
def test_the_solver_is_the_one_asked_for(posture, solver):
    config = WorldConfig(solver=SolverConfig(0.004, solver, 77, 1e-5))
    option = build_spec(posture, config)[0].compile().opt
    assert option.solver == getattr(mujoco.mjtSolver, f"mjSOL_{solver.upper()}")
    assert (option.timestep, option.iterations, option.tolerance) == (0.004, 77, 1e-5)
    assert option.integrator == mujoco.mjtIntegrator.mjINT_DISCRETE


def test_the_same_posture_makes_the_same_model(posture):
    one, other = (build_spec(posture, WorldConfig())[0].to_xml() for _ in range(2))
    assert one == other
    assert build_spec(replace(posture, elbow_deg=20), WorldConfig())[0].to_xml() != one
