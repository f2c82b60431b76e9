"""The tracker, stepped: limits are kept whatever is asked for, and nonsense is refused."""

import numpy as np
import pinocchio as pin
import pytest

from dressing_sim.control import RobotKinematics, Tracker, TrackingConfig, track_path
from dressing_sim.control.limits import POSITION_MARGIN, SPEED_SHARE
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.description import joint_limits
from dressing_sim.world.robot import PANDA

KINEMATICS = RobotKinematics()
DT = TrackingConfig().dt
LIMITS = joint_limits()


@pytest.fixture
def tracker():
    made = Tracker(KINEMATICS)
    made.reset(np.array(PANDA.home))
    return made


def run(tracker, targets):
    return np.array([tracker.command, *(tracker.step(target) for target in targets)])


def assert_limits_kept(commands):
    speeds = np.diff(commands, axis=0) / DT
    assert np.all(np.abs(speeds) <= SPEED_SHARE * LIMITS.velocity + 1e-9)
    accelerations = np.diff(speeds, axis=0) / DT
    assert np.all(np.abs(accelerations) <= np.array(PANDA.acceleration) + 1e-6)


def test_a_path_tracked_at_once_is_its_targets_stepped():
    q = np.array(PANDA.home)
    path = np.array([[0.5, 0.0, 0.4], [0.5, 0.3, 0.4], [0.6, 0.3, 0.3]])
    whole = track_path(path, 0.5, q, KINEMATICS)
    tracker = Tracker(KINEMATICS)
    tracker.reset(q)
    for target, command, error in zip(whole.targets, whole.positions, whole.errors, strict=True):
        np.testing.assert_array_equal(tracker.step(target), command)
        assert tracker.error == error


@pytest.mark.parametrize("seed", range(5))
def test_limits_are_kept_whatever_is_asked_for(tracker, seed):
    rng = np.random.default_rng(seed)
    targets = np.repeat(rng.uniform(-2.0, 2.0, (8, 3)), 25, axis=0)
    commands = run(tracker, targets)
    assert_limits_kept(commands)
    assert np.all(commands >= LIMITS.lower + POSITION_MARGIN - 1e-12)
    assert np.all(commands <= LIMITS.upper - POSITION_MARGIN + 1e-12)


@pytest.mark.parametrize("joint", range(7))
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_start_beyond_the_limits_comes_back_within_all_limits(joint, side):
    q = np.array(PANDA.home)
    q[joint] = (LIMITS.upper if side > 0 else LIMITS.lower)[joint] + side * 0.4
    tracker = Tracker(KINEMATICS)
    tracker.reset(q)
    commands = run(tracker, np.repeat(KINEMATICS.tcp_pose(q)[0][None], 150, axis=0))
    assert_limits_kept(commands)
    outside = np.maximum(commands - LIMITS.upper, LIMITS.lower - commands)
    assert np.all(np.diff(np.maximum(outside[:, joint], 0.0)) <= 1e-12)
    assert np.all(outside[-1] < 0.0)
    assert np.all(np.delete(outside, joint, axis=1) <= 0.0)


def test_a_target_that_is_reached_is_held(tracker):
    place = KINEMATICS.tcp_pose(np.array(PANDA.home))[0] + [0.0, 0.1, 0.05]
    commands = run(tracker, np.repeat(place[None], 100, axis=0))
    assert tracker.error < 1e-4
    assert np.abs(np.diff(commands[-5:], axis=0)).max() < 1e-5
    way = np.array([KINEMATICS.tcp_pose(q)[0] for q in commands])
    speed = np.linalg.norm(np.diff(way, axis=0), axis=1) / DT
    assert speed.max() <= TrackingConfig().max_speed * 1.05


def test_a_matrix_and_its_quaternion_are_the_same_rotation():
    turn = pin.Quaternion(pin.rpy.rpyToMatrix(np.pi, 0.2, 0.3))
    commands = []
    for rotation in (turn.toRotationMatrix(), [turn.w, turn.x, turn.y, turn.z]):
        tracker = Tracker(KINEMATICS)
        tracker.reset(np.array(PANDA.home))
        place = tracker.target
        commands.append([tracker.step(place, rotation) for _ in range(100)])
    np.testing.assert_allclose(*commands, atol=1e-9)
    reached = KINEMATICS.tcp_pose(commands[0][-1])[1]
    angle = np.arccos((np.trace(reached.T @ turn.toRotationMatrix()) - 1.0) / 2.0)
    assert angle < 0.03


@pytest.mark.parametrize(
    "rotation",
    [
        np.full((3, 3), np.nan),
        np.diag([1.0, 1.0, -1.0]),
        2.0 * np.eye(3),
        [1.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.0],
        np.eye(2),
        "down",
    ],
)
def test_what_is_no_rotation_is_refused_and_changes_nothing(tracker, rotation):
    before, place = tracker.command, tracker.target
    with pytest.raises(InvalidInputError, match="rotation"):
        tracker.step(place, rotation)
    np.testing.assert_array_equal(tracker.command, before)


@pytest.mark.parametrize("target", [[np.nan, 0, 0], [0, np.inf, 0], [0.1, 0.2], "left", None])
def test_targets_that_are_not_finite_are_refused_never_tracked(tracker, target):
    before = tracker.command
    with pytest.raises(InvalidInputError, match="target"):
        tracker.step(target)
    np.testing.assert_array_equal(tracker.command, before)


@pytest.mark.parametrize("q", [np.full(7, np.nan), np.zeros(6), None])
def test_a_start_that_is_none_is_refused(q):
    with pytest.raises(InvalidInputError, match="joint positions"):
        Tracker(KINEMATICS).reset(q)
