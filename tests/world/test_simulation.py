import re
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from dressing_sim.control import RobotKinematics, configuration_at
from dressing_sim.control.limits import SPEED_SHARE
from dressing_sim.world.description import joint_limits
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.robot import PANDA
from dressing_sim.world.scene import SolverConfig, WorldConfig, grip_start
from dressing_sim.world.simulation import World
from dressing_sim.world.sleeve import SleeveConfig


def steps(world, seconds):
    return range(round(seconds / world.config.solver.timestep))


def fresh_world(posture, solver=None):
    solver = solver or SolverConfig()
    heals = max(SleeveConfig().contact_time, 2.0 * solver.timestep)
    config = WorldConfig(SleeveConfig(contact_time=heals), solver=solver)
    q, _ = configuration_at(grip_start(posture, config.sleeve), RobotKinematics())
    return World(posture, config, q)


def sweep(world, seconds=0.6, speed=0.3, ramp=0.3):
    """Turn the arm's base joint, ever faster and then evenly, and yield after every step."""
    start = world.arm_configuration
    for i in steps(world, seconds):
        t = (i + 1) * world.config.solver.timestep
        angle = 0.5 * speed * t**2 / ramp if t < ramp else speed * (t - 0.5 * ramp)
        base = np.eye(7)[0]
        world.command(start + angle * base, speed * min(1.0, t / ramp) * base)
        world.step()
        yield angle


def hand_pose(world):
    """Position (3,) and rotation (3, 3) of the gripper."""
    hand = world.data.body(PANDA.tool)
    return hand.xpos.copy(), hand.xmat.reshape(3, 3).copy()


def test_grip_and_arm_together_carry_the_weight_of_a_cloth_that_hangs_still(world):
    for _ in steps(world, 3.0):
        world.step()
    readings = []
    for _ in steps(world, 0.5):
        world.step()
        on_links = sum(world.link_force(link) for link in LINKS)
        readings.append((world.grip_force, on_links))
    grip, on_links = np.mean(readings, axis=0)
    weight = world.mesh.masses.sum() * -world.model.opt.gravity[2]
    # The fingers pull the cloth up, the cloth presses the arm down; sideways all is in balance.
    assert grip[2] > 0.1 * weight
    assert on_links[2] < 0.0
    assert grip[2] - on_links[2] == pytest.approx(weight, rel=0.02)
    np.testing.assert_allclose((grip - on_links)[:2], 0.0, atol=0.02 * weight)


def test_the_grip_holds_the_cloth_to_a_millimetre_while_the_arm_moves(world):
    position, rotation = hand_pose(world)
    in_hand = (world.cloth[world.mesh.gripped] - position) @ rotation
    moved, worst = position.copy(), 0.0
    for _ in sweep(world):
        moved, rotation = hand_pose(world)
        held = moved + in_hand @ rotation.T
        slip = np.linalg.norm(world.cloth[world.mesh.gripped] - held, axis=1)
        worst = max(worst, slip.max())
    assert np.linalg.norm(moved - position) > 0.03
    assert worst < 1e-3


def test_the_arm_follows_its_reference_without_a_warning(world):
    start, error = world.arm_configuration, 0.0
    for angle in sweep(world):
        assert world.invalid_reason is None
        error = max(error, np.abs(world.arm_configuration - start - angle * np.eye(7)[0]).max())
    assert error < 2e-3
    assert world.arm_velocity[0] == pytest.approx(0.3, rel=0.05)
    assert not any(warning.number for warning in world.data.warning)


def test_a_released_cloth_falls_and_pulls_no_more(world):
    assert np.linalg.norm(world.grip_force) > 0.0
    before = world.cloth[world.mesh.gripped].mean(axis=0)
    world.release()
    for _ in steps(world, 0.5):
        world.step()
        np.testing.assert_array_equal(world.grip_force, 0.0)
    assert before[2] - world.cloth[world.mesh.gripped].mean(axis=0)[2] > 0.02
    assert world.invalid_reason is None
    assert not world.holding


def test_the_grip_s_load_is_its_force_after_a_low_pass_of_10_hz(world):
    """The exact solution of x' = 2 pi f (u - x) for a force u that is constant in each step."""
    decay = np.exp(-2.0 * np.pi * 10.0 * world.config.solver.timestep)
    expected = world.grip_load
    for _ in sweep(world, seconds=0.2):
        expected = decay * expected + (1.0 - decay) * world.grip_force
        np.testing.assert_allclose(world.grip_load, expected, atol=1e-12)
    assert np.linalg.norm(expected) > 0.0


def test_the_links_loads_are_their_forces_after_the_same_low_pass(world):
    """As the grip's; a filter with gain one keeps the mean: the sleeve's weight on the arm."""
    decay = np.exp(-2.0 * np.pi * 10.0 * world.config.solver.timestep)
    net, normal = world.cloth_load.net, world.cloth_load.normal
    for _ in sweep(world, seconds=0.2):
        net = decay * net + (1.0 - decay) * world.cloth_forces().net
        normal = decay * normal + (1.0 - decay) * world.cloth_forces().normal
        np.testing.assert_allclose(world.cloth_load.net, net, atol=1e-12)
        np.testing.assert_allclose(world.cloth_load.normal, normal, atol=1e-12)
    assert normal.max() > 0.0


@pytest.mark.parametrize("strength", [0.05, 42.0])
def test_cloth_that_pulls_harder_than_the_fingers_hold_slips_out(posture, strength):
    config = WorldConfig(robot=replace(PANDA, grip_strength=strength))
    q, _ = configuration_at(grip_start(posture, config.sleeve), RobotKinematics())
    world = World(posture, config, q)
    loads = []
    while world.holding and world.time < 0.5:
        world.step()
        loads.append(np.linalg.norm(world.grip_load))
    assert world.holding == (strength == PANDA.grip_strength)
    assert max(loads[:-1], default=0.0) <= strength
    assert (loads[-1] > strength) == (not world.holding)


def test_clearance_is_the_distance_to_the_skin(world):
    posture, size = world.posture, world.posture.arm_size
    along = (posture.elbow - posture.wrist) / size.forearm_length
    across = np.cross(along, [0.3, 0.2, 0.9])
    across /= np.linalg.norm(across)
    middle = 0.5 * (posture.wrist + posture.elbow)
    points = middle + np.outer([0.0, size.forearm_radius, 0.1], across)
    expected = np.array([0.0, size.forearm_radius, 0.1]) - size.forearm_radius
    np.testing.assert_allclose(world.clearance(points), expected, atol=1e-9)
    shoulder = np.add(posture.shoulder, [[0.0, 0.0, 1.0]])
    assert 0.9 < world.clearance(shoulder)[0] < 1.0


def as_fast_as_commands_may(posture, joint, timestep):
    """From rest to the fastest command, as hard as commands may, and to rest again.

    Returns:
        Size of the joints' velocities and torques after each step, (n_steps, 7) each.
    """
    world, limits = fresh_world(posture, SolverConfig(timestep=timestep)), joint_limits()
    world.release()
    start = world.arm_configuration
    room = limits.upper - start, start - limits.lower
    side = 1.0 if room[0][joint] > room[1][joint] else -1.0
    fastest = SPEED_SHARE * limits.velocity[joint]
    speeds = np.minimum(np.arange(0.0, 1.0, timestep) * PANDA.acceleration[joint], fastest)
    speeds = np.concatenate([speeds, speeds[::-1], np.zeros(10)])
    way, measured = np.zeros(7), []
    for speed in speeds:
        way[joint] += side * speed * timestep
        if way[joint] * side > max(room[0][joint], room[1][joint]) - 0.3:
            break
        world.command(start + way, side * speed * np.eye(7)[joint])
        world.step()
        if world.touches():
            break
        measured.append((world.arm_velocity, world.arm_torque))
    return np.abs(np.array(measured)).transpose(1, 0, 2)


@pytest.mark.parametrize("joint", range(7))
def test_a_servo_at_the_commands_limits_stays_within_the_robot_s(posture, joint):
    limits = joint_limits()
    velocity, torque = as_fast_as_commands_may(posture, joint, SolverConfig().timestep)
    assert velocity[:, joint].max() > 0.7 * SPEED_SHARE * limits.velocity[joint]
    assert np.all(velocity <= 0.6 * limits.velocity)
    assert np.all(torque < limits.effort)


def test_twice_the_step_would_not_do_for_the_servos(posture):
    """Why the step is not longer: joints swing, beyond the robot's limits (measured: 1.14)."""
    velocity, _ = as_fast_as_commands_may(posture, 0, 2.0 * SolverConfig().timestep)
    assert np.any(velocity > joint_limits().velocity)


def test_torques_are_those_that_move_the_arm(posture):
    """M dv/dt = torque - bias + contact and grip: MuJoCo's own equation of motion, in 1 % steps."""
    world = fresh_world(posture)
    dofs = [world.model.joint(name).dofadr[0] for name in PANDA.joints]
    inertia = np.zeros((world.model.nv, world.model.nv))
    worst = 0.0
    before = world.arm_velocity
    for _ in sweep(world, seconds=0.5):
        mujoco.mj_fullM(world.model, world.data, inertia)
        acceleration = (world.arm_velocity - before) / world.config.solver.timestep
        before = world.arm_velocity
        rest = (world.data.qfrc_bias - world.data.qfrc_constraint)[dofs]
        needed = inertia[np.ix_(dofs, dofs)] @ acceleration + rest
        worst = max(worst, np.abs(world.arm_torque - needed).max())
    assert worst < 0.01


def test_the_same_steps_give_the_same_bits(posture):
    def history():
        world = fresh_world(posture)
        states = []
        for _ in sweep(world):
            state = (world.data.qpos, world.data.qvel, world.cloth_forces().net, world.grip_load)
            states.append(b"".join(part.tobytes() for part in state))
        return states

    assert history() == history()


def test_the_world_starts_with_the_gripper_where_it_was_put(posture):
    world = fresh_world(posture)
    assert world.time == 0.0
    np.testing.assert_allclose(
        world.tcp_position, grip_start(posture, world.config.sleeve), atol=1e-3
    )
    np.testing.assert_allclose(world.cloth, world.mesh.vertices, atol=1e-12)


@pytest.mark.parametrize("quantity", ["qpos", "qvel"])
@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_state_that_is_not_finite_makes_a_world_void(world, quantity, value):
    assert world.invalid_reason is None
    getattr(world.data, quantity)[-1] = value
    assert "non-finite" in world.invalid_reason


@pytest.mark.parametrize("value", [np.nan, 1e15])
def test_a_state_that_mujoco_gives_up_on_makes_a_world_void(world, value):
    world.data.qvel[-1] = value
    world.step()
    assert "solver warning BADQVEL" in world.invalid_reason
    world.step()
    assert world.invalid_reason is not None  # and it stays so


def test_a_robot_that_leans_on_the_arm_is_felt_and_told_from_cloth(posture, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    kinematics = RobotKinematics()
    q, _ = configuration_at(0.5 * (posture.wrist + posture.elbow), kinematics)
    world = World(posture, WorldConfig(), q)
    mujoco.mj_forward(world.model, world.data)
    touches = {LINKS[touch.link]: touch for touch in world.touches()}
    assert world.robot_links[touches["forearm"].robot_link].startswith("panda_")
    assert touches["forearm"].force > 1.0
    assert np.linalg.norm(world.link_force("forearm", "robot")) > 1.0
    assert "head" not in touches
    np.testing.assert_array_equal(world.link_force("head", "robot"), 0.0)


def test_a_copy_goes_on_with_the_same_bits_and_leaves_the_original_alone(world):
    before = world.data.qpos.copy(), world.grip_load
    other = world.copy()
    for _ in sweep(other, seconds=0.2):
        pass
    np.testing.assert_array_equal(world.data.qpos, before[0])
    np.testing.assert_array_equal(world.grip_load, before[1])
    for _ in sweep(world, seconds=0.2):
        pass
    for read in (lambda w: w.data.qpos, lambda w: w.data.qvel, lambda w: w.grip_load):
        np.testing.assert_array_equal(read(world), read(other))
    other.release()
    assert world.holding
    assert world.data.eq_active.all()


@pytest.mark.parametrize("step", [3, 4])
def test_a_world_says_when_it_broke_down_also_after_mujoco_has_set_its_clock_back(world, step):
    begun = world.time
    for number in range(6):
        if number == step:
            world.data.qvel[-1] = np.nan
        world.step()
    dt = world.config.solver.timestep
    told = float(re.search(r"([\d.]+) s after", world.invalid_reason)[1])
    assert begun + (step - 1) * dt <= told + 1e-9 <= begun + step * dt + 2e-9
