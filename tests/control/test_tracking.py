import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from dressing_sim.control import RobotKinematics, TrackingConfig, configuration_at, track_path
from dressing_sim.control.retiming import retime, smooth
from dressing_sim.world.description import joint_limits
from dressing_sim.world.robot import PANDA

KINEMATICS = RobotKinematics()
HOME_TCP = KINEMATICS.tcp_pose(np.array(PANDA.home))[0]

paths = st.integers(2, 12).flatmap(
    lambda n: arrays(float, (n, 3), elements=st.floats(-1, 1, width=32))
)
steps = st.sampled_from([0.005, 0.02, 0.05])


def on_polyline(points, corners, tolerance=1e-9):
    """Whether every point is on one of the corners' straight lines."""
    start, along = corners[:-1], np.diff(corners, axis=0)
    length = np.maximum(np.einsum("ij,ij->i", along, along), 1e-300)
    share = np.clip(((points[:, None] - start) * along).sum(axis=2) / length, 0.0, 1.0)
    nearest = start + share[:, :, None] * along
    return np.linalg.norm(points[:, None] - nearest, axis=2).min(axis=1) < tolerance


@given(paths, steps, steps, st.floats(0.05, 1.0))
def test_a_retimed_path_keeps_its_ends_and_line_and_the_speed_limit(path, path_dt, dt, max_speed):
    result = retime(path, path_dt, dt, max_speed)
    np.testing.assert_array_equal(result[[0, -1]], path[[0, -1]])
    speeds = np.linalg.norm(np.diff(result, axis=0), axis=1) / dt
    assert speeds.max(initial=0.0) <= max_speed * (1 + 1e-6)
    assert on_polyline(result, path).all()


def test_a_path_that_is_slow_enough_keeps_its_time():
    path = np.linspace([0, 0, 0], [0.1, 0, 0], 11)
    np.testing.assert_allclose(retime(path, 0.1, 0.1, max_speed=0.25), path, atol=1e-12)
    finer = retime(path, 0.1, 0.02, max_speed=0.25)
    np.testing.assert_allclose(finer[::5], path, atol=1e-12)


def test_only_what_is_too_fast_is_slowed_down():
    path = np.array([[0.0, 0, 0], [0.1, 0, 0], [1.1, 0, 0], [1.2, 0, 0]])
    result = retime(path, 1.0, 0.1, max_speed=0.5)
    # One second, two seconds at half a metre a second, one second.
    assert len(result) == 41
    np.testing.assert_allclose(result[10, 0], 0.1)
    np.testing.assert_allclose(result[30, 0], 1.1)


@given(paths, st.sampled_from([0.0, 0.04, 0.3, 0.31]))
def test_smoothing_keeps_the_ends_and_never_speeds_up(points, window):
    dt = 0.02
    result = smooth(points, dt, window)
    np.testing.assert_allclose(result[[0, -1]], points[[0, -1]], atol=1e-12)
    longest = np.linalg.norm(np.diff(points, axis=0), axis=1).max()
    assert np.linalg.norm(np.diff(result, axis=0), axis=1).max() <= longest + 1e-12


@pytest.mark.parametrize("window", [0.0, 0.04, 0.2, 0.3])
def test_smoothing_takes_as_much_longer_as_its_window_to_the_step(window):
    longer = len(smooth(np.zeros((10, 3)), 0.02, window)) - 10
    assert abs(longer - window / 0.02) < 1.0 + 1e-9


def test_smoothing_rounds_a_corner():
    line = np.linspace(0, 1, 50)
    corner = np.vstack([np.column_stack([line, 0 * line]), np.column_stack([0 * line + 1, line])])

    def sharpest(points):
        return np.linalg.norm(np.diff(points, 2, axis=0), axis=1).max()

    assert sharpest(smooth(corner, 0.02, 0.3)) < 0.3 * sharpest(corner)


@pytest.fixture(scope="module")
def tracked():
    """A path round a corner, within the robot's reach."""
    path = HOME_TCP + np.array([[0, 0, 0], [0.05, 0.15, -0.1], [0.1, -0.2, -0.15], [0, -0.2, 0]])
    trajectory = track_path(path, 0.5, np.array(PANDA.home), KINEMATICS)
    return path, trajectory


def test_a_reachable_path_is_tracked_below_a_millimetre(tracked):
    path, trajectory = tracked
    assert trajectory.max_error < 1e-3
    gripper = np.array([KINEMATICS.tcp_pose(q)[0] for q in trajectory.positions])
    errors = np.linalg.norm(gripper - trajectory.targets, axis=1)
    np.testing.assert_allclose(trajectory.errors, errors, atol=1e-9)
    np.testing.assert_allclose(gripper[0], HOME_TCP, atol=1e-3)
    np.testing.assert_allclose(gripper[-1], path[-1], atol=1e-3)


def test_the_hand_keeps_pointing_down(tracked):
    for q in tracked[1].positions:
        assert KINEMATICS.tcp_pose(q)[1][2, 2] < -0.9


def test_joints_stay_within_position_and_velocity_limits_even_for_paths_out_of_reach(tracked):
    limits = joint_limits()
    far = np.array([[0.4, 0.0, 0.4], [2.0, 1.0, 1.0], [-2.0, -1.0, 0.2], [0.3, 0.0, 0.1]])
    for trajectory in (tracked[1], track_path(far, 0.1, np.array(PANDA.home), KINEMATICS)):
        assert np.all(trajectory.positions >= limits.lower)
        assert np.all(trajectory.positions <= limits.upper)
        moves = np.diff(np.vstack([PANDA.home, trajectory.positions]), axis=0)
        assert np.all(np.abs(moves) <= limits.velocity * trajectory.dt * (1 + 1e-6))


def test_targets_are_never_faster_than_the_gripper_may_go(tracked):
    trajectory = tracked[1]
    speeds = np.linalg.norm(np.diff(trajectory.targets, axis=0), axis=1) / trajectory.dt
    assert speeds.max() <= TrackingConfig().max_speed * (1 + 1e-6)


def test_the_path_is_entered_from_where_the_gripper_is():
    path = HOME_TCP + np.array([[0.1, 0, 0], [0.1, 0.05, 0]])
    trajectory = track_path(path, 0.05, np.array(PANDA.home), KINEMATICS)
    np.testing.assert_allclose(trajectory.targets[0], HOME_TCP, atol=1e-12)
    np.testing.assert_allclose(trajectory.targets[-1], path[-1], atol=1e-12)


def test_an_unreachable_path_reports_how_far_the_robot_stays_away():
    path = np.vstack([HOME_TCP, HOME_TCP + np.array([1.0, 0, 0])])
    trajectory = track_path(path, 0.1, np.array(PANDA.home), KINEMATICS)
    gap = np.linalg.norm(path[-1] - KINEMATICS.tcp_pose(trajectory.positions[-1])[0])
    assert trajectory.max_error >= gap - 1e-9
    assert trajectory.max_error > 0.3


def test_a_configuration_is_found_for_a_reachable_place_and_the_distance_for_another():
    place = HOME_TCP + np.array([0.1, 0.1, -0.1])
    q, error = configuration_at(place, KINEMATICS)
    assert error < 1e-3
    assert np.linalg.norm(KINEMATICS.tcp_pose(q)[0] - place) == pytest.approx(error, abs=1e-9)
    q, error = configuration_at(np.array([1.5, 0.0, 0.3]), KINEMATICS)
    assert error > 0.4
    assert np.linalg.norm(KINEMATICS.tcp_pose(q)[0] - [1.5, 0, 0.3]) == pytest.approx(error)
