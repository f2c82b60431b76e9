import xml.etree.ElementTree as ET
from dataclasses import replace

import mujoco
import numpy as np
import pinocchio as pin
import pytest

from dressing_sim.arm import rotation_about
from dressing_sim.control import RobotKinematics
from dressing_sim.suites.robots import load_robot
from dressing_sim.world.description import joint_limits, urdf_path
from dressing_sim.world.robot import PANDA, ServoConfig
from dressing_sim.world.robot_spec import robot_spec


@pytest.fixture(scope="module")
def model():
    return robot_spec(PANDA, contype=2, conaffinity=1).compile()


@pytest.fixture(scope="module")
def urdf():
    return ET.parse(urdf_path()).getroot()


def test_every_link_has_the_mass_of_the_urdf(model, urdf):
    masses = {
        link.get("name"): float(link.find("inertial/mass").get("value"))
        for link in urdf.findall("link")
        if link.find("inertial/mass") is not None
    }
    assert {"panda_link0", "panda_link7", "panda_hand"} <= set(masses)
    for name, mass in masses.items():
        assert model.body(name).mass[0] == pytest.approx(mass), name


def test_joints_and_servos_have_the_limits_of_the_urdf(model, urdf):
    joints = {joint.get("name"): joint.find("limit") for joint in urdf.iter("joint")}
    limits = joint_limits()
    for i, name in enumerate(PANDA.joints):
        lower, upper, effort, velocity = (
            float(joints[name].get(key)) for key in ("lower", "upper", "effort", "velocity")
        )
        np.testing.assert_allclose(model.joint(name).range, [lower, upper])
        assert model.joint(name).limited[0]
        np.testing.assert_allclose(model.actuator(name).forcerange, [-effort, effort])
        assert (limits.lower[i], limits.upper[i]) == (lower, upper)
        assert (limits.effort[i], limits.velocity[i]) == (effort, velocity)
    for name in PANDA.fingers:
        assert model.actuator(name).forcerange[1] * 2 == ServoConfig().finger_force


def test_shared_limits_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        joint_limits().effort[0] = 1e6


@pytest.mark.parametrize("name", ["panda", "ur10"])
def test_pinocchio_and_mujoco_agree_where_the_gripper_is(name, rng):
    robot = load_robot(name)
    model = robot_spec(robot, contype=2, conaffinity=1).compile()
    data, kinematics, limits = mujoco.MjData(model), RobotKinematics(robot), joint_limits(robot)
    for _ in range(100):
        q = rng.uniform(limits.lower, limits.upper)
        for name, angle in zip(robot.joints, q, strict=True):
            data.joint(name).qpos[0] = angle
        mujoco.mj_kinematics(model, data)
        position, rotation = kinematics.tcp_pose(q)
        np.testing.assert_allclose(data.body(robot.tool).xpos, position, rtol=0, atol=1e-9)
        np.testing.assert_allclose(
            data.body(robot.tool).xmat.reshape(3, 3), rotation, rtol=0, atol=1e-9
        )


@pytest.mark.parametrize("name", ["panda", "ur10"])
def test_at_rest_the_hand_points_down_in_front_of_the_base(name):
    robot = load_robot(name)
    position, rotation = RobotKinematics(robot).tcp_pose(np.array(robot.home))
    np.testing.assert_allclose(rotation[:, 2], [0, 0, -1], atol=1e-5)
    assert position[0] > 0.3
    assert abs(position[1]) < 0.01


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


def test_a_plain_gripper_weighs_what_it_should_and_reaches_as_far():
    robot = load_robot("ur10")
    model = robot_spec(robot, contype=2, conaffinity=1).compile()
    assert model.body("gripper").mass[0] == pytest.approx(robot.gripper.mass)
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    way = data.body(robot.tool).xpos - data.body(robot.gripper.flange).xpos
    along = data.body(robot.gripper.flange).xmat.reshape(3, 3)[:, 2]
    np.testing.assert_allclose(way, robot.gripper.reach * along, atol=1e-12)


def test_a_robot_stands_where_it_should_and_is_turned_there():
    robot = load_robot("ur10")
    q, moved = np.array(robot.home), replace(robot, base_position=(0.1, -0.2, 0.3), base_yaw=0.5)
    here, there = RobotKinematics(robot).tcp_pose(q)[0], RobotKinematics(moved).tcp_pose(q)[0]
    turn = rotation_about(np.array([0.0, 0.0, 1.0]), 0.5)
    expected = moved.base_position + turn @ (here - robot.base_position)
    np.testing.assert_allclose(there, expected, atol=1e-12)


def test_servos_are_about_critically_damped_for_the_largest_inertia():
    """As the robots' pages say of their gains."""
    robot, rng = load_robot("ur10"), np.random.default_rng(0)
    model = RobotKinematics(robot).model
    data = model.createData()
    felt = [np.diag(pin.crba(model, data, rng.uniform(-np.pi, np.pi, 6))) for _ in range(300)]
    inertia = np.max(felt, axis=0) + robot.servo.armature
    critical = 2.0 * np.sqrt(robot.servo.stiffness * inertia)
    np.testing.assert_allclose(robot.servo.damping, critical, rtol=0.05)
