"""Policies that are asked for a target in every control step."""

from dataclasses import fields

import numpy as np
import pytest

from dressing_sim.episode.closed_loop import ClosedLoop
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.record import record
from dressing_sim.episode.rollout import begin, follow, tracked
from dressing_sim.episode.trace import Trace
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.robot import PANDA

BRIEF = EpisodeConfig(hold=0.1, time_limit=1.0)
NO_STOP = EpisodeConfig(protective_stop=False)


class Follower:
    """Asks for its next targets, one after the other."""

    def __init__(self, targets, inputs="frames"):
        self.targets, self.inputs, self.observed, self.resets = targets, inputs, [], 0

    def fit(self, demonstrations):
        return self

    def reset(self):
        self.left, self.resets = iter(self.targets), self.resets + 1

    def act(self, observation):
        self.observed.append(observation)
        return next(self.left, None)


@pytest.fixture
def up(posture):
    start = Dressing(posture).start
    return [np.add(start, [0.0, 0.0, 0.001 * i]) for i in range(1, 11)]


def test_a_policy_acts_in_every_step_until_it_returns_nothing_then_holds(posture, up):
    policy = Follower(up)
    recording = record(policy, posture, config=BRIEF)
    assert policy.resets == 1
    assert len(policy.observed) == len(up) + 1
    assert len(recording.trace) == len(up) + round(BRIEF.hold / BRIEF.tracking.dt)
    assert recording.finished
    np.testing.assert_allclose(recording.trajectory.targets[-1], up[-1])
    times = [observation.time for observation in policy.observed]
    np.testing.assert_allclose(np.diff(times), BRIEF.tracking.dt)
    assert times[0] == 0.0
    np.testing.assert_array_equal(policy.observed[3].tcp, recording.trace.tcp[2])
    assert policy.observed[0].frames == posture.frames()


def test_acting_on_targets_is_stepping_a_dressing(posture, up):
    recording = record(Follower(up), posture, config=BRIEF)
    made = Dressing(posture, BRIEF)
    begin(made)
    rows = [made.step(target) for target in up]
    np.testing.assert_array_equal([row.tcp for row in rows], recording.trace.tcp[: len(up)])


def test_the_force_is_for_those_who_declare_it(posture, up):
    policy = Follower(up, inputs="frames+force")
    recording = record(policy, posture, config=BRIEF)
    forces = [observation.force.grip for observation in policy.observed[1:]]
    np.testing.assert_array_equal(forces, recording.trace.grip_force[: len(forces)])
    assert policy.observed[1].force.links.shape == recording.trace.link_force[0].shape
    blind = Follower(up)
    record(blind, posture, config=BRIEF)
    with pytest.raises(InvalidInputError, match=r"frames\+force"):
        _ = blind.observed[0].force


def test_a_policy_that_never_ends_is_a_timeout(posture, up):
    recording = record(Follower(up * 100), posture, config=BRIEF)
    assert "timeout" in recording.outcome.reasons
    assert len(recording.trace) == round(BRIEF.time_limit / BRIEF.tracking.dt)


@pytest.mark.parametrize("target", [[np.nan, 0.0, 0.0], [1.0], "up"])
def test_a_target_that_is_none_names_the_policy(posture, target):
    with pytest.raises(InvalidInputError, match="policy Follower: act returned"):
        record(Follower([target]), posture, config=BRIEF)


def test_a_target_out_of_reach_is_unreachable_and_the_robot_stops(posture):
    recording = record(Follower([[0.2, 0.4, 1.9]] * 2000), posture, config=NO_STOP)
    assert recording.outcome.reasons == ("ik_unreachable",)
    assert "from the target" in recording.outcome.failures[0].detail
    assert recording.outcome.failures[0].time > 0.0


def test_a_path_led_target_by_target_is_the_path_that_is_followed(posture):
    start = Dressing(posture).start
    path = np.linspace(start, np.add(start, [0.0, -0.05, 0.02]), 12)
    config = EpisodeConfig(hold=0.1, time_limit=3.0)
    played = follow(Dressing(posture, config), path, 0.05)
    targets = tracked(Dressing(posture, config), path, 0.05).targets[1:]
    led = record(Follower(targets), posture, config=config)
    for one in fields(Trace):
        ours, theirs = getattr(led.trace, one.name), getattr(played.trace, one.name)
        np.testing.assert_array_equal(ours, theirs, err_msg=one.name)
    assert led.outcome == played.outcome
    assert led.time_left == pytest.approx(played.time_left)


def test_a_robot_at_speed_brakes_within_its_limits_before_it_holds(posture):
    made = Dressing(posture)
    begin(made)
    far = np.add(made.start, [0.0, 0.5, 0.0])
    for _ in range(40):
        made.step(far)
    commands = [made.command]
    for _ in range(40):
        made.hold()
        commands.append(made.command)
    velocity = np.diff(commands, axis=0) / made.config.tracking.dt
    acceleration = np.diff(velocity, axis=0) / made.config.tracking.dt
    assert np.all(np.abs(acceleration).max(axis=0) <= np.multiply(PANDA.acceleration, 1.001))
    assert np.abs(velocity[0]).max() > 0.0
    np.testing.assert_array_equal(commands[-1], commands[-10])


def test_who_stops_holding_goes_on(posture, up):
    loop = ClosedLoop(Dressing(posture, BRIEF))
    for _ in range(4):
        loop.step(None)
    assert not loop.over
    loop.step(up[0])
    assert loop.held == 0
    for _ in range(5):
        loop.step(None)
    assert loop.finished
    assert loop.over
