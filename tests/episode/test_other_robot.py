"""That the robot is data: another one dresses, within its own limits."""

import numpy as np
import pytest

from dressing_sim.config import from_plain, to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.suites.robots import with_robot
from dressing_sim.suites.suites import find_posture
from dressing_sim.world.description import joint_limits


@pytest.fixture(scope="module")
def dressed():
    """The operator with seed 0 and a UR10 on an arm that is easy to dress."""
    config = with_robot(EpisodeConfig(), "ur10")
    return config, record(Operator(), find_posture("bent40"), 0, config)


def test_another_robot_dresses_an_arm(dressed):
    _, recording = dressed
    assert recording.outcome.success, recording.outcome
    assert recording.trajectory.positions.shape[1] == 6


def test_it_follows_the_path_and_keeps_its_own_limits(dressed):
    config, recording = dressed
    limits, trace = joint_limits(config.world.robot), recording.trace
    assert trace.joint_position.shape == (len(trace.tcp), 6)
    assert trace.tracking_error.max() < config.tracking.max_error
    assert np.all(np.abs(trace.joint_velocity) < limits.velocity)
    assert np.all(np.abs(trace.torque) < limits.effort)
    assert trace.limit_ratio.max() < 1.0
    commanded = np.diff(recording.trajectory.positions, axis=0) / recording.trajectory.dt
    most = np.abs(np.diff(commanded, axis=0)).max(axis=0) / recording.trajectory.dt
    assert np.all(most <= np.multiply(config.world.robot.acceleration, 1.0 + 1e-6))


def test_its_settings_say_which_robot_it_was(dressed):
    config, _ = dressed
    assert from_plain(EpisodeConfig, to_plain(config)) == config
