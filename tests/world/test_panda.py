import xml.etree.ElementTree as ET
from importlib.metadata import PackageNotFoundError

import mujoco
import numpy as np
import pytest

from dressing_sim.control import PandaKinematics
from dressing_sim.errors import DressingSimError
from dressing_sim.world import panda
from dressing_sim.world.panda import (
    ARM_JOINTS,
    BASE_BODY,
    FINGER_JOINTS,
    HOME,
    TCP_BODY,
    ServoConfig,
    joint_limits,
    panda_spec,
    urdf_path,
)


@pytest.fixture(scope="module")
def model():
    return panda_spec(ServoConfig(), contype=2, conaffinity=1).compile()


@pytest.fixture(scope="module")
def urdf():
    return ET.parse(urdf_path()).getroot()


def test_every_link_has_the_mass_of_the_urdf(model, urdf):
    masses = {
        link.get("name"): float(link.find("inertial/mass").get("value"))
        for link in urdf.findall("link")
        if link.find("inertial/mass") is not None
    }
    assert {BASE_BODY, "panda_link7", "panda_hand"} <= set(masses)
    for name, mass in masses.items():
        assert model.body(name).mass[0] == pytest.approx(mass), name


def test_joints_and_servos_have_the_limits_of_the_urdf(model, urdf):
    joints = {joint.get("name"): joint.find("limit") for joint in urdf.iter("joint")}
    limits = joint_limits()
    for i, name in enumerate(ARM_JOINTS):
        lower, upper, effort, velocity = (
            float(joints[name].get(key)) for key in ("lower", "upper", "effort", "velocity")
        )
        np.testing.assert_allclose(model.joint(name).range, [lower, upper])
        assert model.joint(name).limited[0]
        np.testing.assert_allclose(model.actuator(name).forcerange, [-effort, effort])
        assert (limits.lower[i], limits.upper[i]) == (lower, upper)
        assert (limits.effort[i], limits.velocity[i]) == (effort, velocity)
    for name in FINGER_JOINTS:
        assert model.actuator(name).forcerange[1] * 2 == ServoConfig().finger_force


def test_shared_limits_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        joint_limits().effort[0] = 1e6


def test_pinocchio_and_mujoco_agree_where_the_gripper_is(model, rng):
    data, kinematics, limits = mujoco.MjData(model), PandaKinematics(), joint_limits()
    for _ in range(100):
        q = rng.uniform(limits.lower, limits.upper)
        for name, angle in zip(ARM_JOINTS, q, strict=True):
            data.joint(name).qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        position, rotation = kinematics.tcp_pose(q)
        np.testing.assert_allclose(data.body(TCP_BODY).xpos, position, rtol=0, atol=1e-9)
        np.testing.assert_allclose(
            data.body(TCP_BODY).xmat.reshape(3, 3), rotation, rtol=0, atol=1e-9
        )


def test_at_rest_the_hand_points_down_in_front_of_the_base():
    position, rotation = PandaKinematics().tcp_pose(np.array(HOME))
    np.testing.assert_allclose(rotation[:, 2], [0, 0, -1], atol=1e-5)
    assert position[0] > 0.3
    assert abs(position[1]) < 1e-6


def test_servos_hold_still_and_never_exceed_their_torque(world):
    start, limits = world.arm_configuration, joint_limits()
    world.command(start, np.zeros(7))
    for _ in range(20):
        world.step()
    np.testing.assert_allclose(world.arm_configuration, start, atol=1e-4)
    saturated = np.zeros(7, dtype=bool)
    for direction in (1.0, -1.0):
        world.command(start + direction * 0.5, np.zeros(7))
        for _ in range(10):
            world.step()
            assert np.all(np.abs(world.data.actuator_force[:7]) <= limits.effort)
            saturated |= np.abs(world.data.actuator_force[:7]) == limits.effort
    assert saturated.all()  # so the limit was at work


def test_a_missing_robot_description_is_an_error_that_says_what_to_install(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(panda, "distribution", missing)
    with pytest.raises(DressingSimError, match="install the package example-robot-data"):
        urdf_path()
