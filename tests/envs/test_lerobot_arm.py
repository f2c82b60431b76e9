"""The arm as LeRobot looks at it; needs Gymnasium only, see `test_lerobot` for LeRobot's loops."""

import numpy as np
import pytest
from episodes import same

from dressing_sim.datasets.columns import OBSERVED, observations
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.errors import InvalidInputError

pytest.importorskip("gymnasium")

from dressing_sim.envs.gym import DressArm
from dressing_sim.envs.lerobot.arm import NEW_ROLLOUT, LeRobotArm

SMALL = {"width": 64, "height": 48}
BRIEF = EpisodeConfig(hold=0.1, time_limit=0.4)


@pytest.mark.filterwarnings(
    "error::UserWarning",
    "error::DeprecationWarning",
    "ignore:.*different from the unwrapped version:UserWarning",  # as a wrapper's must be
)
def test_gymnasium_finds_nothing_to_complain_of(posture):
    from gymnasium.utils.env_checker import check_env

    check_env(LeRobotArm(DressArm(posture, episode=BRIEF)), skip_render_check=True)


def test_what_is_observed_is_what_data_sets_hold(posture):
    seen, _ = LeRobotArm(DressArm(posture, episode=BRIEF)).reset()
    held = observations(Demonstration([seen["agent_pos"]] * 2, 0.02, posture, 0, None))
    frames = np.concatenate([held[name][0] for name in OBSERVED if name != "gripper"])
    np.testing.assert_array_equal(seen["environment_state"], frames)
    assert len(frames) == 24


def test_it_is_the_same_episode_as_natively_and_ends_in_time(posture):
    config = EpisodeConfig(time_limit=0.8)
    native = record(Operator(), posture, 0, config)
    env = LeRobotArm(DressArm(posture, control="target", episode=config))
    _, info = env.reset(seed=0, options={NEW_ROLLOUT: True})
    actions = env.unwrapped.actions(Operator())[: env.get_wrapper_attr("_max_episode_steps")]
    assert info["is_success"] is False
    for action in actions:
        *_, terminated, truncated, info = env.step(action)
    assert truncated
    assert not terminated
    assert info["is_success"] is native.outcome.success is False
    same(env.unwrapped.recording(), native)


def test_pictures_have_the_names_of_their_cameras(posture, opengl):
    env = LeRobotArm(DressArm(posture, episode=BRIEF, **SMALL), ["front", "side"])
    seen, _ = env.reset()
    assert env.observation_space.contains(seen)
    assert [*seen["pixels"]] == ["front", "side"]
    np.testing.assert_array_equal(seen["pixels"]["front"], env.unwrapped.task.picture())
    assert not np.array_equal(*seen["pixels"].values())
    env.close()


def test_what_is_not_valid_is_named(posture):
    env = LeRobotArm(DressArm(posture, episode=BRIEF))
    with pytest.raises(InvalidInputError, match="no option 'arm'; valid are posture, suite"):
        env.reset(options={NEW_ROLLOUT: True, "arm": 1})
    with pytest.raises(InvalidInputError, match="cameras must be one of front"):
        LeRobotArm(DressArm(posture), ["top"])
