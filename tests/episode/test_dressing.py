from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.config import to_plain
from dressing_sim.control import TrackingConfig
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.judge import judge
from dressing_sim.episode.operator import OperatorConfig
from dressing_sim.episode.record import demonstrate, dress, record, replay
from dressing_sim.episode.rollout import follow
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.description import joint_limits
from dressing_sim.world.scene import SolverConfig, WorldConfig, grip_start
from dressing_sim.world.simulation import World
from dressing_sim.world.sleeve import SleeveConfig

BRIEF = EpisodeConfig(hold=0.1, time_limit=0.2)
"""An episode that is over before much has happened."""


class Told:
    """A policy that returns what it was told to."""

    def __init__(self, path, **attributes):
        self.path = path
        vars(self).update(attributes)

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        self.seen = frames, start
        return self.path


def short_path(posture):
    start = grip_start(posture, WorldConfig().sleeve)
    return np.linspace(start, np.add(start, [0.0, 0.0, 0.02]), 20)


@pytest.fixture(scope="module")
def replayed(demonstration):
    """The demonstration played again, and the arm's configuration after every physics step."""
    configurations = []
    step = World.step

    def watched(world):
        step(world)
        configurations.append(world.arm_configuration)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(World, "step", watched)
        recording = replay(demonstration, observer=lambda world: None)
    return recording, np.array(configurations)


@pytest.mark.parametrize("path", [np.full((5, 3), np.nan), np.zeros((5, 2)), "left", None])
def test_a_policy_that_returns_no_path_is_named(posture, path):
    with pytest.raises(InvalidInputError, match="policy Told: returned"):
        dress(Told(path), posture)


@pytest.mark.parametrize("source", [[[0.4, 0.0, 0.4], [0.4, 0.1, 0.4]], None, "expert"])
def test_what_is_neither_path_nor_policy_is_an_error(posture, source):
    with pytest.raises(InvalidInputError, match=r"cannot dress with .*valid is a policy"):
        dress(source, posture)


def test_an_array_that_is_no_path_is_an_error(posture):
    with pytest.raises(InvalidInputError, match=r"the path: .*\(5, 2\).*valid is \(T, 3\)"):
        dress(np.zeros((5, 2)), posture)


@pytest.mark.parametrize("dt", [float("nan"), float("inf"), -0.05, 0, 1000.0, "slow", True])
def test_a_policy_whose_time_step_is_none_is_named(posture, dt):
    with pytest.raises(InvalidInputError, match=r"policy Told.*dt"):
        dress(Told(short_path(posture), dt=dt), posture, config=BRIEF)


def test_a_policy_sees_the_frames_and_the_gripper_and_nothing_else(posture):
    policy = Told(short_path(posture))
    record(policy, posture, config=BRIEF)
    frames, start = policy.seen
    assert frames == posture.frames()
    np.testing.assert_allclose(start, grip_start(posture, WorldConfig().sleeve), atol=1e-3)


def test_a_policy_may_say_how_fast_its_path_is(posture):
    config = EpisodeConfig(hold=0.0, time_limit=2.0)

    def duration(**attributes):
        trajectory = record(Told(short_path(posture), **attributes), posture, 0, config).trajectory
        return len(trajectory.positions) * trajectory.dt

    # Twenty points, and the way from the gripper to the first.
    assert duration(dt=0.06) - duration(dt=0.04) == pytest.approx(20 * 0.02, abs=0.05)
    assert duration(dt=0.04) < duration() == duration(dt=None) < duration(dt=0.06)


@pytest.mark.parametrize("dt", [np.float32(0.04), np.float64(0.04), np.int64(1), 1])
def test_numbers_of_numpy_are_numbers(posture, dt):
    config = replace(BRIEF, time_limit=1.0)
    path = short_path(posture)[:2]
    assert record(Told(path, dt=dt), posture, 0, config).outcome.reasons[-1] != "ik_unreachable"


@pytest.mark.parametrize("dt", [0.19, 0.2])
def test_no_more_of_a_path_is_tracked_than_there_is_time_for(posture, dt):
    """A path may be hours long."""
    path = np.vstack([short_path(posture)] * 5000)
    recording = record(Told(path, dt=dt), posture, 0, BRIEF)
    assert "timeout" in recording.outcome.reasons
    assert not recording.finished
    duration = len(recording.trajectory.positions) * recording.trajectory.dt
    assert BRIEF.time_limit < duration < BRIEF.time_limit + 1.0


def test_what_is_tracked_does_not_depend_on_how_much_comes_later(posture):
    def trajectory(time_limit):
        config = EpisodeConfig(hold=0.0, time_limit=time_limit)
        return follow(Dressing(posture, config), short_path(posture), 0.05).trajectory.positions

    whole, part = trajectory(9.0), trajectory(0.5)
    n = round(0.5 / TrackingConfig().dt) + 1
    assert len(whole) > len(part) > n
    np.testing.assert_array_equal(part[:n], whole[:n])


def test_every_episode_begins_with_the_same_bits_whatever_came_before(posture):
    first = Dressing(posture)
    first.reset()
    begun = first.world.data.qpos.copy(), first.world.time
    follow(first, short_path(posture), 0.05)
    again = Dressing(posture)
    Dressing(replace(posture, name="another"))
    afresh = Dressing(posture)
    for episode in (first, again, afresh):
        episode.reset()
        np.testing.assert_array_equal(episode.world.data.qpos, begun[0])
        np.testing.assert_array_equal(episode.start, again.start)
        assert episode.world.time == begun[1]


@pytest.mark.parametrize("far", [1.0, 1e12])
def test_an_unreachable_path_is_reported_and_not_simulated(posture, far):
    episode = Dressing(posture)
    path = np.vstack([episode.start, np.add(episode.start, [far, 0.0, 0.0])])
    recording = follow(episode, path, 0.05)
    assert recording.outcome.reasons == ("ik_unreachable",)
    assert recording.outcome.metrics["tracking_error"] > 0.3
    assert "the path" in recording.outcome.failures[0].detail
    assert not recording.outcome.success
    assert recording.outcome.invalid is None
    assert recording.trace is None
    assert recording.trajectory is None


def test_a_sleeve_out_of_reach_is_unreachable_too():
    # The hand of an arm that is held out backwards.
    posture = Posture("backwards", -60, 0, 0, 0)
    outcome = record(short_path(posture), posture).outcome
    assert outcome.reasons == ("ik_unreachable",)


def test_a_path_that_takes_too_long_is_a_timeout(posture):
    recording = record(short_path(posture), posture, config=BRIEF)
    assert "timeout" in recording.outcome.reasons
    assert recording.outcome.metrics["duration"] == pytest.approx(BRIEF.time_limit)
    assert len(recording.positions) == round(BRIEF.time_limit / BRIEF.tracking.dt) + 1


def test_a_world_that_breaks_down_before_the_robot_moves_is_void(posture, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves its log of warnings in the current folder
    far = np.full((2, 3), 3.0)

    def asked(*_):
        raise AssertionError("a policy was asked for a path from nowhere")

    real = World.step
    monkeypatch.setattr(World, "step", lambda world: (spoil(world), real(world)))
    config = replace(BRIEF, world=replace(BRIEF.world, settle_time=0.123))  # a world of its own

    def spoil(world):
        world.data.qvel[-1] = np.nan

    for source in (short_path(posture), far, SimpleNamespace(fit=asked, generate=asked, dt=0.1)):
        recording = record(source, posture, 0, config)
        assert recording.outcome.invalid is not None
        assert recording.outcome.reasons == ()
        assert recording.broke == recording.outcome.invalid


def test_the_gripper_is_compared_with_where_it_should_be_at_that_time(demonstration):
    """A physics step of 10 ms at the gripper's speed would be a millimetre."""
    error = replay(demonstration).trace.tracking_error
    assert error.max() < 5e-4


@pytest.mark.parametrize("quantity", ["qpos", "qvel"])
def test_a_simulation_that_breaks_down_is_void_and_no_failure(
    posture, quantity, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves its log of warnings in the current folder

    def spoil(world):
        getattr(world.data, quantity)[-1] = np.nan

    recording = record(short_path(posture), posture, 0, BRIEF, spoil)
    outcome = recording.outcome
    assert outcome.invalid is not None
    assert not outcome.success
    assert outcome.reasons == ()
    assert recording.trace is None


def test_the_observer_sees_every_control_step(posture):
    times = []
    record(short_path(posture), posture, 0, BRIEF, lambda world: times.append(world.time))
    assert len(times) == round(BRIEF.time_limit / BRIEF.tracking.dt)
    np.testing.assert_allclose(np.diff(times), BRIEF.tracking.dt)


def test_a_replayed_demonstration_is_the_same_to_the_bit(demonstration, replayed):
    positions = replayed[0].positions[: len(demonstration.positions)]
    assert positions.tobytes() == demonstration.positions.tobytes()


def test_a_replay_is_judged_as_the_demonstration_was(demonstrated, replayed):
    expected, outcome = demonstrated[1].to_dict(), replayed[0].outcome.to_dict()
    # Its targets are where the commands lead, not the path that they were made from.
    del expected["figures"]["tracking_error"], outcome["figures"]["tracking_error"]
    assert outcome == expected


def test_joints_stay_within_the_limits_of_the_urdf_in_every_step(demonstration, replayed):
    limits = joint_limits()
    for positions in (demonstration.commands, replayed[1]):
        assert len(positions) > 100
        assert np.all((limits.lower <= positions) & (positions <= limits.upper))
    moves = np.abs(np.diff(demonstration.commands, axis=0)) / demonstration.dt
    assert np.all(moves <= limits.velocity * (1 + 1e-6))
    assert np.all(np.abs(replayed[0].trace.torque) <= limits.effort)


def test_a_demonstration_has_a_command_a_position(demonstration):
    assert len(demonstration.positions) == len(demonstration.commands)
    assert demonstration.dt == TrackingConfig().dt
    assert demonstration.settings["episode"] == to_plain(EpisodeConfig())
    assert demonstration.settings["operator"] == to_plain(OperatorConfig())


def test_a_demonstration_without_the_settings_of_its_world_cannot_be_replayed(demonstration):
    bare = replace(demonstration, settings={})
    assert isinstance(bare, Demonstration)
    with pytest.raises(InvalidInputError, match="settings"):
        replay(bare)


@pytest.fixture(scope="module")
def straight():
    """A straight line to the shoulder of a bent arm, with the protective stop and without."""
    posture = Posture("bent", 66, 30, 48, 65, size="male")
    recordings = []
    for protective_stop in (True, False):
        episode = Dressing(posture, EpisodeConfig(protective_stop=protective_stop))
        end = np.add(posture.shoulder, [0.0, 0.0, OperatorConfig().shoulder_height])
        duration = np.linalg.norm(end - episode.start) / OperatorConfig().speed
        path = np.linspace(episode.start, end, round(duration / 0.05) + 1)
        recordings.append(follow(episode, path, 0.05))
    return recordings


def test_a_straight_line_to_the_shoulder_of_a_bent_arm_catches_at_the_elbow(straight):
    outcome = straight[0].outcome
    assert not outcome.success
    assert outcome.invalid is None
    assert "over_force" in outcome.reasons or "over_strain" in outcome.reasons
    stuck = outcome.failures[outcome.reasons.index("stuck")]
    assert stuck.where == "elbow"
    assert "stopped_short" not in outcome.reasons


def test_the_verdict_is_the_same_without_the_protective_stop(straight):
    stopped, whole = straight
    assert whole.outcome.to_dict() == stopped.outcome.to_dict()
    n = len(stopped.trace)
    assert n < len(whole.trace)
    assert stopped.outcome.metrics["duration"] == pytest.approx(n * stopped.trace.dt)
    for column in ("tcp", "strain", "grip_force", "armscye_s", "wound", "joint_velocity"):
        np.testing.assert_array_equal(
            getattr(stopped.trace, column), getattr(whole.trace, column)[:n]
        )
    np.testing.assert_array_equal(stopped.positions, whole.positions[: n + 1])


def test_an_episode_can_be_judged_again_by_other_rules(straight):
    whole = straight[1]
    lax = replace(Thresholds(), strain=9.0, grip_force=1e3, link_force=1e3)
    shoulder = Posture("bent", 66, 30, 48, 65, size="male").shoulder
    again = judge(whole.trace, shoulder, whole.finished, lax)
    assert whole.finished
    # By other rules the robot would not have stopped so early; in the end the cloth slips away.
    assert again.metrics["duration"] > whole.outcome.metrics["duration"] + 0.5
    assert not {"over_force", "over_strain"} & set(again.reasons)


def test_a_simulation_that_breaks_down_after_the_stop_was_stopped(posture, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # MuJoCo leaves its log of warnings in the current folder
    config = replace(BRIEF, time_limit=1.0, protective_stop=False)

    def drop_and_spoil(world):
        if world.holding:
            world.release()
        else:
            world.data.qvel[-1] = np.nan

    recording = record(short_path(posture), posture, 0, config, drop_and_spoil)
    assert recording.outcome.invalid is None
    assert recording.outcome.reasons == ("grasp_lost",)
    assert recording.trace is not None


def test_a_lost_grasp_ends_the_episode(posture):
    recording = record(short_path(posture), posture, 0, BRIEF, World.release)
    assert recording.outcome.reasons == ("grasp_lost",)
    assert len(recording.trace) == 2


@pytest.mark.parametrize(
    "change",
    [
        {"tracking": TrackingConfig(dt=0.012)},
        {"tracking": TrackingConfig(dt=0.0025)},
        {
            "world": WorldConfig(
                SleeveConfig(contact_time=0.03), solver=SolverConfig(timestep=0.015)
            )
        },
    ],
)
def test_a_control_step_must_be_whole_physics_steps(change):
    with pytest.raises(InvalidInputError, match="control step"):
        EpisodeConfig(**change)


@pytest.mark.parametrize("change", [{"hold": -1.0}, {"time_limit": 0.0}, {"time_limit": 0.01}])
def test_impossible_times_are_errors_that_name_them(change):
    with pytest.raises(InvalidInputError, match=next(iter(change))):
        EpisodeConfig(**change)


def test_a_dressing_comes_out_as_it_always_has(demonstrated):
    """The operator on an easy arm: what is published hangs on these. Forces to a few per cent, as
    other processors round otherwise."""
    demonstration, outcome = demonstrated
    assert outcome.success
    assert len(demonstration.positions) == 294
    figures = outcome.metrics
    assert figures["duration"] == pytest.approx(6.86)
    assert figures["armscye_s"] == pytest.approx(2.0015, abs=0.01)
    assert figures["gripper_distance"] == pytest.approx(0.0866, abs=5e-4)
    assert figures["strain"] == pytest.approx(0.0349, rel=0.05)
    assert figures["grip_force"] == pytest.approx(0.2989, rel=0.05)
    assert figures["link_normal_force"] == pytest.approx(0.5681, rel=0.1)
    assert figures["torque"] == pytest.approx(29.87, rel=0.01)
    assert figures["speed_near_arm"] == pytest.approx(0.1356, rel=0.02)
    assert figures["joint_speed_ratio"] == pytest.approx(0.1454, rel=0.02)
    assert figures["joint_position_ratio"] == pytest.approx(0.9046, rel=0.01)


def test_the_operator_s_seed_is_that_of_the_episode(posture):
    one, same, other = (demonstrate(posture, seed).commands for seed in (3, 3, 4))
    np.testing.assert_array_equal(one, same)
    assert one.shape != other.shape or not np.allclose(one, other, atol=1e-4)


def test_margins_of_robot_and_path_change_gradually_through_zero(posture):
    """Lowered in steps, the gripper comes nearer to the arm, and then it touches it."""
    forearm = 0.5 * (posture.wrist + posture.elbow)
    found = []
    for height in (0.07, 0.06, 0.05, 0.0):
        dressing = Dressing(posture)
        recording = follow(
            dressing, np.linspace(dressing.start, forearm + [0, 0, height], 60), 0.05
        )
        margins = dressing.margins(recording.time_left, recording.reach_left)
        assert (margins["hit"] < 0.0) == ("hit" in recording.outcome.reasons)
        assert margins["timeout"] == pytest.approx(recording.time_left)
        assert recording.finished
        assert 0.0 < margins["ik_unreachable"] <= dressing.config.tracking.max_error
        found.append(margins["hit"])
    assert found == sorted(found, reverse=True)
    assert found[0] > 0.0 > found[-1]
    # While nothing is in the way the robot comes nearer as it is lowered.
    assert found[0] - found[1] == pytest.approx(0.01, abs=0.002)


def test_a_path_that_takes_too_long_says_by_how_much(posture):
    config = EpisodeConfig(time_limit=2.0, hold=0.2)
    left = []
    for seconds in (1.0, 3.0, 5.0):
        dressing = Dressing(posture, config)
        path = np.repeat(dressing.start[None], 21, axis=0)
        left.append(follow(dressing, path, seconds / 20).time_left)
    assert left[0] > 0.0 > left[1] > left[2]
    # The way to the first point takes as long as one between two points.
    assert left[1] - left[2] == pytest.approx(2.0 * 21 / 20, abs=0.03)
