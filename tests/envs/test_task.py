"""An agent in a dressing: when it ends, what it is told, and what it is rewarded for."""

from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.envs.config import EXTRAS, EnvConfig
from dressing_sim.envs.task import Task
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import Operator
from dressing_sim.errors import InvalidInputError

BRIEF = EpisodeConfig(hold=0.1, time_limit=0.4)
STAY, FINISH = np.zeros(4), np.array([0.0, 0.0, 0.0, 1.0])


def begun(posture, **choices):
    task = Task(EnvConfig(**{"episode": BRIEF, **choices}))
    task.begin(posture)
    return task


def acted(task, *actions):
    for action in actions:
        task.act(action)
    return task


def test_nothing_is_over_when_it_begins(posture):
    task = begun(posture)
    assert (task.terminated, task.truncated, task.success) == (False, False, False)
    assert task.information() == {"is_success": False}


def test_who_says_for_long_enough_that_it_has_finished_is_judged(posture):
    task = acted(begun(posture), *[FINISH] * 4)
    assert not task.terminated
    task.act(FINISH)
    assert task.terminated
    assert not task.truncated
    told = task.information()
    assert "stopped_short" in told["reasons"]
    assert "timeout" not in told["reasons"]
    assert told["metrics"]["duration"] == pytest.approx(0.1)


def test_who_goes_on_has_not_finished(posture):
    task = acted(begun(posture), *[FINISH] * 4, STAY, *[FINISH] * 4)
    assert not task.terminated
    assert acted(task, FINISH).terminated


def test_the_time_limit_truncates(posture):
    task = acted(begun(posture), *[STAY] * 20)
    assert task.truncated
    assert not task.terminated
    assert "timeout" in task.information()["reasons"]


def test_who_finishes_with_the_last_step_was_in_time(posture):
    task = acted(begun(posture), *[STAY] * 15, *[FINISH] * 5)
    assert task.terminated
    assert not task.truncated


def test_a_protective_stop_terminates(posture):
    task = begun(posture)
    task.dressing.world.release()
    task.act(STAY)
    assert task.terminated
    assert "grasp_lost" in task.information()["reasons"]


def test_a_target_out_of_reach_terminates(posture):
    task = begun(posture, control="target", episode=EpisodeConfig(protective_stop=False))
    while not (task.terminated or task.truncated):
        task.act([0.2, 0.4, 1.9, 0.0])
    assert task.terminated
    assert task.information()["reasons"] == ("ik_unreachable",)


def test_a_world_that_breaks_down_truncates_and_says_why(posture, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    task = acted(begun(posture), STAY)
    task.dressing.world.data.qvel[-1] = np.nan
    task.act(STAY)
    assert task.truncated
    assert not task.terminated
    told = task.information()
    assert "step" in told["invalid"] or "non-finite" in told["invalid"] or "BAD" in told["invalid"]
    assert not told["is_success"]


def test_a_world_that_is_broken_from_the_start_is_cut_at_once(posture):
    task = begun(posture)
    spoilt = task.dressing._settled.world.copy()
    spoilt.data.warning.number[0] = 1
    task.dressing._settled = replace(task.dressing._settled, world=spoilt)
    task.begin(posture)
    assert acted(task, STAY).truncated
    assert "solver warning" in task.information()["invalid"]
    assert task.reward == 0.0


def test_after_the_end_nothing_happens(posture):
    task = acted(begun(posture), *[FINISH] * 5)
    before = task.dressing.snapshot()
    acted(task, STAY)
    assert task.dressing.snapshot() == before
    assert task.terminated
    assert task.reward == 0.0


def test_a_displacement_is_from_the_last_target_and_a_target_is_one(posture):
    step = np.array([0.001, -0.002, 0.003, 0.0])
    moved = begun(posture)
    place = moved.dressing.target
    acted(moved, step, step)
    np.testing.assert_allclose(moved.observation()["target"], place + 2.0 * step[:3], atol=1e-15)
    led = begun(posture, control="target")
    acted(led, np.append(place + step[:3], 0.0), np.append(place + 2.0 * step[:3], 0.0))
    np.testing.assert_allclose(led.dressing.command, moved.dressing.command, atol=1e-9)


def test_the_hand_turns_as_the_agent_says(posture):
    task = begun(posture, rotation=True, episode=EpisodeConfig(hold=0.1, time_limit=2.0))
    turn = [0.0, 0.0, 0.3]
    acted(task, *[[0.0, 0.0, 0.0, *turn, 0.0]] * 60)
    reached = task.dressing.kinematics.tcp_pose(task.dressing.command)[1]
    along = reached[:, 1]  # the fingers open along it; pointing down it is the base's -y
    assert np.arctan2(along[0], -along[1]) == pytest.approx(0.3, abs=0.03)
    acted(task, *[[0.0] * 6 + [1.0]] * 5)
    assert task.terminated


def test_observations_have_the_ranges_they_promise(posture, opengl):
    task = begun(posture, observe=EXTRAS, width=48, height=32)
    ranges = task.config.observation_ranges
    for seen in (task.observation(), acted(task, STAY).observation()):
        assert list(seen) == list(ranges)
        for name, array in seen.items():
            assert array.shape == ranges[name].shape, name
            assert array.dtype == ranges[name].dtype, name
            assert np.all((array >= ranges[name].low) & (array <= ranges[name].high)), name
    task.close()
    task.close()


def test_what_is_seen_is_what_was_measured(posture):
    task = acted(begun(posture, observe=("arm_coordinate", "link_force", "cloth")), STAY)
    seen, row = task.observation(), task.dressing.row
    np.testing.assert_array_equal(seen["gripper"], row.tcp)
    np.testing.assert_array_equal(seen["link_force"], row.link_force)
    assert seen["grip_force"][0] == row.grip_force
    assert tuple(seen["arm_coordinate"]) == (row.armscye_s, row.hem_s)
    np.testing.assert_array_equal(seen["cloth"], task.dressing.world.cloth)
    np.testing.assert_array_equal(seen["wrist_axes"], posture.frames().wrist.A)
    np.testing.assert_array_equal(seen["shoulder_position"], posture.shoulder)


def test_no_array_is_given_out_twice(posture):
    task = begun(posture)
    first = task.observation()
    for array in first.values():
        array += 1.0
    again = task.observation()
    assert all(not np.array_equal(first[name], again[name]) for name in first)


def test_a_dense_return_is_progress_and_success_is_one_more(posture):
    dense = Task(EnvConfig(control="target"))
    sparse = Task(EnvConfig(control="target", reward="sparse"))
    for task in (dense, sparse):
        task.begin(posture)
    rewards, rare = [], []
    for action in dense.actions(Operator(), seed=0):
        for task, kept in ((dense, rewards), (sparse, rare)):
            task.act(action)
            kept.append(task.reward)
    assert dense.terminated
    assert dense.success
    assert rare == [0.0] * (len(rare) - 1) + [1.0]
    assert 1.5 < sum(rewards) <= 2.0
    assert min(rewards) > -0.2
    assert rewards[-1] == pytest.approx(1.0, abs=0.05)


def test_arrival_finishes_for_the_agent(posture):
    task = Task(EnvConfig(control="target", finish="arrival"))
    task.begin(posture)
    for action in task.actions(Operator(), seed=0):
        task.act(action)
        if task.terminated:
            break
    assert task.success
    assert task.dressing.row.armscye_s > task.config.episode.thresholds.armscye_s


def test_nobody_acts_before_an_episode_begins():
    with pytest.raises(InvalidInputError, match=r"reset\(\) first"):
        Task(EnvConfig()).act(STAY)
