"""The robot's limits, as Pinocchio reads them from the URDF, hold in every physics step."""

import numpy as np
import pytest

from dressing_sim.control import RobotKinematics, TrackingConfig
from dressing_sim.control.tracking import track_path
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.rollout import play
from dressing_sim.episode.trace import NEAR
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.robot import PANDA
from dressing_sim.world.simulation import World

NAMES = [posture.name for posture in load_suite("paper5")]
MODEL = RobotKinematics().model


def check(positions, velocities, torques):
    assert len(positions) > 100
    assert np.all(MODEL.lowerPositionLimit <= positions)
    assert np.all(positions <= MODEL.upperPositionLimit)
    assert np.all(np.abs(velocities) <= MODEL.velocityLimit)
    assert np.all(np.abs(torques) <= MODEL.effortLimit)


@pytest.mark.parametrize("name", NAMES)
def test_limits_hold_in_every_step_of_an_episode(watched, name):
    recording, *arm = watched(name)
    check(*arm)
    figures, trace = recording.outcome.metrics, recording.trace
    assert figures["joint_speed_ratio"] <= np.abs(arm[1] / MODEL.velocityLimit).max() < 0.5
    assert figures["torque_ratio"] <= np.abs(arm[2] / MODEL.effortLimit).max() < 0.8
    # Next to a person a robot is slow, and it is next to one for most of the way.
    assert 0.0 < figures["speed_near_arm"] <= TrackingConfig().max_speed
    assert np.mean(trace.clearance < NEAR) > 0.3
    assert figures["hit_force"] == 0.0


def test_limits_hold_on_a_path_that_asks_for_too_much(posture, monkeypatch):
    """Through the axis of the robot's base and back and forth, where joints cannot keep up."""
    tracking = TrackingConfig(max_speed=1.0, smoothing=0.0)
    config = EpisodeConfig(tracking=tracking, hold=0.0, protective_stop=False)
    episode = Dressing(posture, config)
    up = np.add(episode.start, [0.0, 0.0, 0.3])
    side, behind = np.array([0.05, 0.4, 0.75]), np.array([-0.3, 0.02, 0.8])
    path = np.array([up, side, behind, side, behind, side])
    trajectory = track_path(
        path, 0.05, episode.start_configuration, episode.kinematics, config.tracking
    )
    assert trajectory.max_error > config.tracking.max_error
    commanded = np.diff(trajectory.positions, axis=0) / trajectory.dt
    acceleration = np.abs(np.diff(commanded, axis=0)) / trajectory.dt
    assert np.all(acceleration <= np.array(PANDA.acceleration) * (1.0 + 1e-6))
    assert np.any(acceleration > 0.99 * np.array(PANDA.acceleration))

    rows, step = [], World.step

    def watch(world):
        step(world)
        rows.append((world.arm_configuration, world.arm_velocity, world.arm_torque))

    monkeypatch.setattr(World, "step", watch)
    assert play(episode, trajectory, World.release).outcome.reasons == ("grasp_lost",)
    check(*np.array(rows).transpose(1, 0, 2))
