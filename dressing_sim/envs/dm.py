"""The same task for dm_env: ``dressing_sim.envs.dm.load("bent40")``."""

from __future__ import annotations

from typing import Any

import numpy as np
from dm_control.rl import control
from dm_env import specs
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import whole_number
from dressing_sim.envs.config import Range
from dressing_sim.envs.task import Task, chosen_posture, env_config


class DressPhysics(control.Physics):
    """A dressing as dm_control's physics: one of its steps is one control step.

    Attributes:
        task: The dressing, and how it is seen.
    """

    def __init__(self, task: Task) -> None:
        self.task = task
        self._action: NDArray[np.float64] | None = None

    def set_control(self, control: NDArray[np.float64]) -> None:
        """The action of the steps that follow, see `EnvConfig.action_range`."""
        self._action = control

    def step(self, n_sub_steps: int = 1) -> None:
        """Act."""
        for _ in range(n_sub_steps):
            self.task.act(self._action)

    def time(self) -> float:
        """Since the robot began to move [s]."""
        return self.task.time

    def timestep(self) -> float:
        """Length of a control step [s]."""
        return self.task.config.episode.tracking.dt

    def reset(self) -> None:
        """The task begins the episode: it knows whom to dress."""

    def after_reset(self) -> None:
        """There is nothing more to do."""


class DressTask(control.Task):
    """Dress an arm: what `dressing_sim.envs.gym.DressArm` says, for dm_env.

    Args:
        posture: Whom to dress, a `Posture` or its name.
        suite: Or whose postures to draw from; without either, arms are random.
        seed: Of what is drawn.
    """

    def __init__(self, posture: str | Posture | None, suite: str | None, seed: int | None) -> None:
        self._given, self._rng = (
            (posture, suite),
            np.random.default_rng(None if seed is None else whole_number(seed, "seed")),
        )

    def initialize_episode(self, physics: DressPhysics) -> None:
        """The sleeve hangs still from the gripper in front of the hand."""
        physics.task.begin(chosen_posture(*self._given, self._rng))

    def before_step(self, action: NDArray[np.float64], physics: DressPhysics) -> None:
        """Tell the robot what to do."""
        physics.set_control(action)

    def action_spec(self, physics: DressPhysics) -> specs.BoundedArray:
        """Shape and bounds of an action."""
        return _spec(physics.task.config.action_range, "action")

    def observation_spec(self, physics: DressPhysics) -> dict[str, specs.BoundedArray]:
        """Shape and bounds of what is observed, by name."""
        ranges = physics.task.config.observation_ranges
        return {name: _spec(one, name) for name, one in ranges.items()}

    def get_observation(self, physics: DressPhysics) -> dict[str, NDArray[Any]]:
        """What the agent sees."""
        return physics.task.observation()

    def get_reward(self, physics: DressPhysics) -> float:
        """For the last step."""
        return physics.task.reward

    def get_termination(self, physics: DressPhysics) -> float | None:
        """Discount 0 where the episode ends by itself, 1 where it is cut short, else None."""
        if physics.task.truncated:
            return 1.0
        return 0.0 if physics.task.terminated else None


class DressEnvironment(control.Environment):
    """Frees the pictures' OpenGL context when it is closed."""

    def close(self) -> None:
        """Free what drew the pictures."""
        self.physics.task.close()


def load(
    posture: str | Posture | None = None,
    suite: str | None = None,
    seed: int | None = None,
    **choices: Any,
) -> control.Environment:
    """The environment: ``load("bent40")``, ``load(suite="val50", seed=1)``.

    Args:
        posture: Whom to dress, a `Posture` or its name.
        suite: Or whose postures to draw from; without either, arms are random.
        seed: Of what is drawn.
        choices: Fields of `dressing_sim.envs.config.EnvConfig`.

    Returns:
        It ends its episodes itself; ``environment.physics.task`` says how they went.

    Raises:
        InvalidInputError: There is no such posture, suite or choice.
    """
    physics = DressPhysics(Task(env_config(choices)))
    if posture is not None or suite is not None:
        chosen_posture(posture, suite, np.random.default_rng(0))
    return DressEnvironment(physics, DressTask(posture, suite, seed))


def _spec(one: Range, name: str) -> specs.BoundedArray:
    return specs.BoundedArray(one.shape, one.dtype, one.low, one.high, name)
