"""Choices of an environment, and the ranges that follow from them."""

import numpy as np
import pytest

from dressing_sim.envs.config import EXTRAS, EnvConfig, checked_action
from dressing_sim.envs.task import chosen_posture, env_config
from dressing_sim.errors import InvalidInputError


@pytest.mark.parametrize(
    ("choices", "size"),
    [
        ({}, 4),
        ({"finish": "arrival"}, 3),
        ({"rotation": True}, 7),
        ({"control": "target", "rotation": True, "finish": "arrival"}, 6),
    ],
)
def test_an_action_has_a_number_for_each_thing_the_agent_does(choices, size):
    actions = EnvConfig(**choices).action_range
    assert actions.shape == (size,)
    assert np.all(actions.low <= 0.0)
    assert np.all(actions.high <= 1.0)


def test_a_displacement_is_what_the_robot_can_do_in_one_step():
    config = EnvConfig()
    tracking = config.episode.tracking
    np.testing.assert_allclose(config.action_range.high[:3], tracking.max_speed * tracking.dt)


@pytest.mark.parametrize(
    ("choices", "told"),
    [
        ({"control": "velocity"}, "displacement, target"),
        ({"finish": "never"}, "agent, arrival"),
        ({"reward": "shaped"}, "dense, sparse"),
        ({"camera": "mine"}, "front"),
        ({"observe": "cloth"}, "arm_coordinate"),
        ({"observe": ["elbow"]}, "arm_coordinate"),
        ({"rotation": 1}, "rotation"),
        ({"width": 0}, "width"),
        ({"speed": 2.0}, "no choice 'speed'; valid is control"),
        ({"episode": None}, "an EpisodeConfig"),
    ],
)
def test_a_choice_that_does_not_exist_says_what_does(choices, told):
    with pytest.raises(InvalidInputError, match=told):
        env_config(choices)


def test_extras_are_seen_by_those_who_ask():
    assert not set(EXTRAS) & set(EnvConfig().observation_ranges)
    assert set(EXTRAS) <= set(EnvConfig(observe=EXTRAS).observation_ranges)


@pytest.mark.parametrize(
    "action", [[0.0] * 3, [np.nan] * 4, np.zeros((4, 1)), 0.0, "left", None, [1j] * 4]
)
def test_an_action_of_another_shape_is_refused(action):
    with pytest.raises(InvalidInputError, match="valid are 4 finite numbers"):
        checked_action(action, 4)


def test_an_arm_is_given_or_of_a_suite_or_random(posture, rng):
    assert chosen_posture(posture, None, rng) is posture
    assert chosen_posture("bent40", None, rng).name == "bent40"
    assert chosen_posture(None, "val50", rng).name.startswith("val")
    drawn = [chosen_posture(None, None, np.random.default_rng(seed)) for seed in (4, 4, 5)]
    assert drawn[0] == drawn[1] != drawn[2]
    with pytest.raises(InvalidInputError, match="valid is one of them"):
        chosen_posture(posture, "val50", rng)
    with pytest.raises(InvalidInputError, match="a Posture or its name"):
        chosen_posture(40, None, rng)
