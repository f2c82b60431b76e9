"""LeRobot's own loops dress an arm through the plug-in.

Skipped where LeRobot is not installed; it needs Python 3.12. Run with LeRobot 0.6.1, Python 3.12.1:
``pip install -e '.[test,lerobot]'`` in an environment of that Python, then this file alone.
"""

import os
import subprocess
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from episodes import same

from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.errors import InvalidInputError

pytest.importorskip(
    "lerobot", reason="LeRobot is not installed: pip install 'dressing-sim[lerobot]', Python 3.12"
)

import draccus
import torch
from lerobot.configs.parser import load_plugin
from lerobot.datasets.lerobot_dataset import LeRobotDataset
from lerobot.envs import (
    EnvConfig,
    close_envs,
    env_to_policy_features,
    make_env,
    preprocess_observation,
)
from lerobot.envs.utils import NEW_ROLLOUT_OPTION
from lerobot.policies import ACTConfig, PreTrainedPolicy
from lerobot.processor import PolicyProcessorPipeline
from lerobot.processor.converters import (
    policy_action_to_transition,
    transition_to_policy_action,
)
from lerobot.scripts.lerobot_eval import eval_policy_all, rollout
from lerobot.utils.feature_utils import dataset_to_policy_features

from dressing_sim.datasets.lerobot_sets import write_lerobot
from dressing_sim.datasets.replayed import Cameras
from dressing_sim.envs.lerobot.arm import NEW_ROLLOUT
from dressing_sim.lerobot_names import FRAMES, STATE, TASK

load_plugin("dressing_sim.envs.lerobot")  # what --env.discover_packages_path does

ROOT = Path(__file__).resolve().parents[2]


class Scripted(PreTrainedPolicy):
    """A policy of LeRobot's that does what it was told, (n_envs, n_steps, size), then the last."""

    config_class, name = ACTConfig, "scripted"

    def __init__(self, actions):
        super().__init__(ACTConfig(device="cpu"))
        self.actions, self.saw = torch.from_numpy(np.asarray(actions)), []

    def reset(self):
        self.saw = []

    def select_action(self, batch, **unused):
        step = min(len(self.saw), self.actions.shape[1] - 1)
        self.saw.append(batch)
        return self.actions[:, step]

    def get_optim_params(self):
        return {}

    # LeRobot's base class wants these, its loops of evaluation call neither.
    def forward(self, batch):
        raise NotImplementedError

    def predict_action_chunk(self, batch, **unused):
        raise NotImplementedError


@dataclass
class Asked:
    """What LeRobot's commands parse, of an environment."""

    env: EnvConfig


def pipelines():
    """Nothing is changed on the way between environment and policy."""
    empty = PolicyProcessorPipeline(steps=[])
    acts = PolicyProcessorPipeline(
        steps=[], to_transition=policy_action_to_transition, to_output=transition_to_policy_action
    )
    names = ("env_preprocessor", "env_postprocessor", "preprocessor", "postprocessor")
    return dict(zip(names, (empty, empty, empty, acts), strict=True))


def configured(**choices):
    choices = {"task": "paper5", "task_ids": [1], "finish": "agent", **choices}
    return EnvConfig.get_choice_class("dressing_sim")(**choices)


def staying_and_finishing(env):
    """Two arms: one robot finishes at once, the other never does."""
    start = env.reset(seed=[0, 0], options={NEW_ROLLOUT_OPTION: True})[0]["agent_pos"]
    return Scripted(np.concatenate([start, [[0.0], [1.0]]], axis=1)[:, None])


def test_its_evaluation_has_the_episode_that_the_core_has(posture):
    native = record(Operator(), posture, seed=3)
    ((suite, tasks),) = (envs := make_env(configured())).items()
    (env,) = tasks.values()
    assert (suite, [*tasks]) == ("paper5", [1])
    env.reset()
    policy = Scripted(env.envs[0].unwrapped.actions(Operator(), seed=3)[None])
    done = eval_policy_all(envs, policy, **pipelines(), n_episodes=1, start_seed=0)
    assert done["overall"]["pc_success"] == 100.0 * native.outcome.success
    assert done["per_task"][0]["metrics"]["successes"] == [native.outcome.success]
    same(env.envs[0].unwrapped.recording(), native)
    first = policy.saw[0]
    assert first["task"] == [TASK]
    assert first[STATE].shape == (1, 3)
    assert first[FRAMES].shape == (1, 24)
    np.testing.assert_allclose(first[FRAMES][0, :3], posture.shoulder, atol=1e-6)


def test_who_is_over_waits_for_the_others_at_no_cost():
    (env,) = make_env(configured(), n_envs=2)["paper5"].values()
    stay, finish = staying_and_finishing(env).actions[:, 0]
    for step in range(1, 53):
        _, _, terminated, _, info = env.step(torch.stack([stay, finish]).numpy())
        assert [*terminated] == [False, step >= 50]
        assert ("final_info" in info) == (step >= 50)
    assert [*info["final_info"]["is_success"]] == [False, False]
    assert "stopped_short" in info["final_info"]["reasons"][1]
    assert [*info["is_success"]] == [False, False]
    assert [one.unwrapped.task.time > 1.01 for one in env.envs] == [True, False]
    env.close()


def test_environments_in_processes_of_their_own():
    envs = make_env(configured(), n_envs=2, use_async_envs=True)
    (env,) = envs["paper5"].values()
    policy = staying_and_finishing(env)
    policy.actions[0] = policy.actions[1]
    done = rollout(env, policy, **pipelines(), seeds=[0, 1])
    close_envs(envs)
    assert done["action"].shape == (2, 50, 4)
    assert done["done"][:, -1].all()
    assert not done["success"].any()


def test_what_policies_learn_from_is_what_they_are_shown(demonstration, tmp_path, opengl):
    short = replace(
        demonstration,
        positions=demonstration.positions[:4],
        commands=demonstration.commands[:4],
    )
    cameras = Cameras(("front", "side"), 64, 48)
    write_lerobot(tmp_path / "set", [short], lambda done, total: None, cameras)
    data = LeRobotDataset("dressing-sim/set", root=tmp_path / "set")
    config = configured(
        cameras="front,side", observation_width=64, observation_height=48, finish="arrival"
    )
    learned, told = dataset_to_policy_features(data.features), env_to_policy_features(config)
    assert set(learned) - set(told) == {"observation.joint_command"}
    for name, feature in told.items():
        assert (feature.type, tuple(feature.shape)) == (learned[name].type, learned[name].shape)
    (env,) = make_env(config)["paper5"].values()
    seen = preprocess_observation(env.reset()[0])
    assert {*seen} == {*told} - {"action"}
    for name, value in seen.items():
        np.testing.assert_allclose(value[0], data[0][name], atol=1e-6)
    env.close()


def test_its_command_line_and_its_names():
    given = {
        "type": "dressing_sim",
        "task": "paper5",
        "task_ids": "[0, 2]",
        "cameras": "close,front",
    }
    config = draccus.parse(Asked, args=[f"--env.{key}={value}" for key, value in given.items()]).env
    assert [*make_env(config)["paper5"]] == [0, 2]
    assert [*env_to_policy_features(config)][3:] == [
        "observation.images.close",
        "observation.images.front",
    ]
    assert NEW_ROLLOUT == NEW_ROLLOUT_OPTION
    with pytest.raises(InvalidInputError, match="task_ids"):
        make_env(configured(task_ids=[5]))
    with pytest.raises(InvalidInputError, match="fps is 30"):
        configured(fps=30)


def test_it_finds_the_package_by_its_name(tmp_path):
    pytest.importorskip("hatchling")
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--target", str(tmp_path)]
    package = ROOT / "plugins" / "lerobot_env_dressing_sim"
    subprocess.run([*pip, *options, str(package)], check=True)
    code = (
        "from lerobot.utils.import_utils import register_third_party_plugins as register; "
        "register(); from lerobot.envs import EnvConfig; print([*EnvConfig.get_known_choices()])"
    )
    path = os.pathsep.join([str(tmp_path), str(ROOT)])
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=True,
    )
    assert "'dressing_sim'" in done.stdout
