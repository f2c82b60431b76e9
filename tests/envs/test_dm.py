"""The dm_env environment: its contract, and the same bits as the core."""

from dataclasses import fields

import numpy as np
import pytest

from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.episode.trace import Trace
from dressing_sim.errors import InvalidInputError

pytest.importorskip("dm_control.rl.control")

from absl.testing import absltest
from dm_env import test_utils

from dressing_sim.envs import dm

BRIEF = EpisodeConfig(hold=0.1, time_limit=0.4)
STAY, FINISH = np.zeros(4), np.array([0.0, 0.0, 0.0, 1.0])


class TestContract(test_utils.EnvironmentTestMixin, absltest.TestCase):
    """What dm_env asks of every environment."""

    def make_object_under_test(self):
        return dm.load("bent25", episode=BRIEF, observe=("arm_coordinate", "link_force", "cloth"))

    def make_action_sequence(self):
        yield from [STAY] * 3 + [FINISH] * 8 + [STAY] * 22


def test_a_path_is_the_same_episode_as_natively(posture):
    native = record(Operator(), posture, seed=3)
    environment = dm.load(posture, control="target")
    step, task = environment.reset(), environment.physics.task
    for action in task.actions(Operator(), seed=3):
        step = environment.step(action)
        if step.last():
            break
    assert step.last()
    assert step.discount == 0.0
    for field in fields(Trace):
        ours = getattr(task.recording().trace, field.name)
        np.testing.assert_array_equal(ours, getattr(native.trace, field.name), field.name)
    assert task.recording().outcome == native.outcome


@pytest.mark.parametrize(("action", "discount", "steps"), [(FINISH, 0.0, 5), (STAY, 1.0, 20)])
def test_an_end_has_discount_zero_and_a_cut_one(action, discount, steps):
    environment = dm.load("bent25", episode=BRIEF)
    environment.reset()
    made = [environment.step(action) for _ in range(steps)]
    assert not made[-2].last()
    assert made[-1].last()
    assert made[-1].discount == discount
    assert environment.physics.time() == pytest.approx(steps * environment.control_timestep())
    assert environment.step(action).first()


def test_a_seed_repeats():
    seen = [dm.load(seed=seed, episode=BRIEF).reset().observation for seed in (3, 3, 4)]
    np.testing.assert_array_equal(seen[0]["wrist_position"], seen[1]["wrist_position"])
    assert not np.array_equal(seen[0]["wrist_position"], seen[2]["wrist_position"])


def test_what_does_not_exist_is_refused_at_once():
    for arguments in ({"posture": "bent11"}, {"suite": "val51"}, {"control": "speed"}):
        with pytest.raises(InvalidInputError, match=r"valid is|must be one of"):
            dm.load(**arguments)
