"""The Gymnasium environment: its contract, its seeds, and the same bits as the core."""

import subprocess
import sys
from operator import attrgetter

import numpy as np
import pytest
from episodes import same

from dressing_sim.envs import GYMNASIUM_ID
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.suites import load_suite

gymnasium = pytest.importorskip("gymnasium")

from dressing_sim.envs.gym import DressArm  # noqa: E402 (needs what was asked for above)

BRIEF = EpisodeConfig(hold=0.1, time_limit=0.4)
STAY, FINISH = np.zeros(4), np.array([0.0, 0.0, 0.0, 1.0])


def made(posture=None, **choices):
    return gymnasium.make(GYMNASIUM_ID, posture=posture, **choices)


def played(env, source, seed=0):
    """The episode of a path, through nothing but Gymnasium's interface."""
    env.reset()
    for action in env.unwrapped.actions(source, seed):
        *_, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            break
    return env.unwrapped.recording(), info


@pytest.mark.parametrize("choices", [{}, {"control": "target", "rotation": True}])
@pytest.mark.filterwarnings("error::UserWarning", "error::DeprecationWarning")
def test_gymnasium_finds_nothing_to_complain_of(posture, opengl, choices):
    from gymnasium.utils.env_checker import check_env

    check_env(made(posture, width=64, height=48, **choices).unwrapped)


@pytest.mark.filterwarnings("error::UserWarning", "error::DeprecationWarning")
def test_nor_when_more_is_seen_and_arms_are_random():
    from gymnasium.utils.env_checker import check_env

    more = ("arm_coordinate", "link_force", "cloth")
    env = made(observe=more, finish="arrival", reward="sparse")
    check_env(env.unwrapped, skip_render_check=True)


def test_it_can_be_made_by_name_alone():
    code = (
        f"import gymnasium; env = gymnasium.make('dressing_sim.envs:{GYMNASIUM_ID}', "
        "posture='bent10'); env.reset(seed=0); print(env.spec.id)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == GYMNASIUM_ID


def test_a_path_is_the_same_episode_as_natively():
    name = "bent65"
    posture = {one.name: one for one in load_suite("paper5")}[name]
    native = record(Operator(), posture, seed=3)
    ours, info = played(made(name, control="target"), Operator(), seed=3)
    same(ours, native)
    assert info["is_success"] == native.outcome.success
    assert info["reasons"] == native.outcome.reasons
    assert info["metrics"] == native.outcome.metrics


def test_a_path_that_gets_caught_ends_as_it_does_natively():
    posture = load_suite("paper5")[4]
    end = np.add(posture.shoulder, [0.0, 0.0, 0.09])
    path = np.linspace([0.35, 0.15, 0.3], end, 60)
    native = record(path, posture)
    assert not native.outcome.success
    ours, info = played(made(posture, control="target"), path)
    same(ours, native)
    assert info["reasons"] == native.outcome.reasons


def test_a_path_that_is_too_slow_ends_as_it_does_natively(posture):
    config = EpisodeConfig(time_limit=1.0)
    native = record(Operator(), posture, 0, config)
    env = made(posture, control="target", episode=config)
    env.reset()
    for action in env.unwrapped.actions(Operator()):
        *_, terminated, truncated, _ = env.step(action)
        if truncated:
            break
    assert not terminated
    same(env.unwrapped.recording(), native)


def test_a_path_by_displacements_has_the_same_verdict(posture):
    native = record(Operator(), posture, seed=1)
    ours, _ = played(made(posture), Operator(), seed=1)
    np.testing.assert_allclose(ours.trace.tcp, native.trace.tcp, atol=1e-6)
    assert ours.outcome.reasons == native.outcome.reasons


def test_a_policy_in_closed_loop_is_the_same_episode_as_natively(posture):
    class Up:
        def fit(self, demonstrations):
            return self

        def act(self, observation):
            up = observation.target + [0.0, 0.0, 0.001]
            return up if observation.time < 0.2 else None

    native = record(Up(), posture, config=BRIEF)
    env = made(posture, control="target", episode=BRIEF)
    seen, info = env.reset()
    for step in range(100):
        target = seen["target"] + [0.0, 0.0, 0.001] if step < 10 else np.zeros(3)
        seen, _, terminated, _, info = env.step(np.append(target, float(step >= 10)))
        if terminated:
            break
    same(env.unwrapped.recording(), native)
    assert info["reasons"] == native.outcome.reasons


def test_a_seed_repeats_to_the_bit_arm_and_all():
    runs = []
    for seed in (7, 7, 8):
        env = made(episode=BRIEF)
        seen, info = env.reset(seed=seed)
        arms = [info["posture"]]
        after = [seen["wrist_position"], env.step(STAY)[0]["gripper"]]
        seen, info = env.reset()  # the next arm follows from the same seed
        runs.append(np.concatenate([*after, seen["wrist_position"]]))
        assert arms[0]
    np.testing.assert_array_equal(runs[0], runs[1])
    assert not np.array_equal(runs[0], runs[2])
    assert not np.array_equal(runs[0][:3], runs[0][-3:])


def test_options_say_whom_to_dress_in_this_episode(posture):
    env = made("bent10", episode=BRIEF)
    assert env.reset(options={"posture": posture})[1]["posture"] == posture.name
    assert env.reset(options={"suite": "val50"}, seed=0)[1]["posture"].startswith("val")
    assert env.reset()[1] == {"is_success": False, "posture": "bent10"}
    with pytest.raises(InvalidInputError, match="no option 'arm'; valid are posture, suite"):
        env.reset(options={"arm": 1})


@pytest.mark.parametrize(
    ("asked", "part"),
    [
        ({"seed": "x"}, "seed is 'x'"),
        ({"seed": -1}, "seed is -1"),
        ({"seed": 0.5}, "seed is 0.5"),
        ({"options": 3}, "options is 3"),
        ({"options": {3: 1, "x": 2}}, "no option '3'"),
    ],
)
def test_what_cannot_be_asked_of_reset_is_named(asked, part):
    with pytest.raises(InvalidInputError, match=part):
        made("bent10", episode=BRIEF).reset(**asked)


def test_a_seed_may_be_a_number_of_numpy():
    env = made("bent10", episode=BRIEF)
    assert env.reset(seed=np.int64(3))[1]["posture"] == "bent10"


@pytest.mark.parametrize("look", ["time", "dressing", "success"])
def test_before_the_first_reset_there_is_no_episode(look):
    task = DressArm().task
    with pytest.raises(InvalidInputError, match="no episode has begun; valid is reset"):
        attrgetter(look)(task)


def test_nor_anything_that_was_recorded():
    task = DressArm().task
    with pytest.raises(InvalidInputError, match="no episode has begun; valid is reset"):
        task.recording()


def test_a_huge_action_is_refused_without_a_warning(posture, recwarn):
    env = made("bent10", episode=BRIEF)
    env.reset()
    with pytest.raises(InvalidInputError, match="action"):
        env.step(np.full(4, 1e300))
    assert not [w for w in recwarn if issubclass(w.category, RuntimeWarning)]


def test_a_name_that_does_not_exist_says_what_does():
    with pytest.raises(InvalidInputError, match="must be one of rgb_array"):
        DressArm(render_mode="ansi")
    with pytest.raises(InvalidInputError, match="unknown posture"):
        made("bent11").reset()


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_vectors_of_environments_step_together(mode):
    names = ("bent10", "bent25")
    make = [lambda n=name: made(n, episode=BRIEF) for name in names]
    kind = {"sync": gymnasium.vector.SyncVectorEnv, "async": gymnasium.vector.AsyncVectorEnv}[mode]
    vector = kind(make)
    try:
        seen, _ = vector.reset(seed=0)
        for _ in range(5):
            seen, _, terminated, _, info = vector.step(np.stack([STAY, FINISH]))
    finally:
        vector.close()
    assert list(terminated) == [False, True]
    assert list(info["is_success"]) == [False, False]
    assert "stopped_short" in info["reasons"][1]
    single = made("bent10", episode=BRIEF)
    single.reset()
    for _ in range(5):
        alone = single.step(STAY)[0]
    np.testing.assert_array_equal(seen["gripper"][0], alone["gripper"])


def test_pictures_of_two_environments_do_not_mix(posture, opengl):
    size = {"render_mode": "rgb_array", "width": 64, "height": 48, "episode": BRIEF}
    envs = [made(name, **size) for name in ("bent10", "bent65")]
    for env in envs:
        env.reset()
    first = [env.render() for env in envs]
    again = [env.render() for env in envs]
    for picture, same_again in zip(first, again, strict=True):
        assert picture.shape == (48, 64, 3)
        assert picture.dtype == np.uint8
        np.testing.assert_array_equal(picture, same_again)
    assert not np.array_equal(*first)
    envs[0].close()
    np.testing.assert_array_equal(envs[1].render(), first[1])
    envs[1].close()
