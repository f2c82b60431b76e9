"""What ``--env.type=dressing_sim`` takes on LeRobot's command line, and makes."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import gymnasium
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs import EnvConfig
from lerobot.envs.utils import (
    _LazyAsyncVectorEnv,
    freeze_after_episode_end,
    parse_camera_names,
)

from dressing_sim.arm import Posture
from dressing_sim.checks import whole_number
from dressing_sim.envs.gym import DressArm
from dressing_sim.envs.lerobot.arm import LeRobotArm
from dressing_sim.lerobot_names import FRAMES, PICTURES, STATE
from dressing_sim.suites.suites import load_suite


def made(posture: Posture | None, cameras: list[str], **choices: Any) -> LeRobotArm:
    """An environment that dresses one arm."""
    return LeRobotArm(DressArm(posture, **choices), cameras)


@EnvConfig.register_subclass("dressing_sim")
@dataclass
class DressingSimEnv(EnvConfig):
    """Arms of a suite, each a task of LeRobot's; see `LeRobotArm` for what is observed.

    By default it acts as the data sets that ``dressing-sim export --to lerobot`` writes: an action
    is the gripper's target, 3 numbers in m.
    """

    task: str = "val50"
    """Name or file of a suite."""
    task_ids: list[int] | None = None
    """Which arms of it, from 0; all if not given."""
    fps: int = 50
    """Of the control loop, which cannot be changed."""
    cameras: str = ""
    """Cameras, with commas between; their pictures take longer than physics."""
    observation_height: int = 480
    """Of a picture [pixels]."""
    observation_width: int = 640
    """Of a picture [pixels]."""
    control: str = "target"
    """``displacement`` or ``target``, see `dressing_sim.envs.config.EnvConfig`."""
    finish: str = "arrival"
    """``agent`` or ``arrival``, see there."""

    def __post_init__(self) -> None:
        env = made(None, **self.gym_kwargs)
        rate = env.metadata["render_fps"]
        whole_number(self.fps, "environment: fps", rate, rate)
        space: Any = env.observation_space
        kinds = {
            "action": ("action", FeatureType.ACTION, env.action_space),
            "agent_pos": (STATE, FeatureType.STATE, space["agent_pos"]),
            "environment_state": (FRAMES, FeatureType.ENV, space["environment_state"]),
        }
        for camera, picture in space.spaces.get("pixels", {}).items():
            # Under its own name, by which LeRobot looks for it when it records an evaluation.
            kinds[f"{PICTURES}.{camera}"] = (f"{PICTURES}.{camera}", FeatureType.VISUAL, picture)
        self.features = {
            key: PolicyFeature(kind, box.shape) for key, (_, kind, box) in kinds.items()
        }
        self.features_map = {key: name for key, (name, _, _) in kinds.items()}

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """What an environment is made with."""
        return {
            "cameras": parse_camera_names(self.cameras) if self.cameras else [],
            "render_mode": "rgb_array",  # for films of an evaluation
            "width": self.observation_width,
            "height": self.observation_height,
            "control": self.control,
            "finish": self.finish,
        }

    def create_envs(
        self, n_envs: int, use_async_envs: bool = False
    ) -> dict[str, dict[int, gymnasium.vector.VectorEnv]]:
        """Environments as ``{suite: {number of the arm: n_envs of that arm}}``.

        One that is over costs nothing until all are. In one process ``final_info`` has the end of
        an episode; in several it stays in ``info``.

        Raises:
            InvalidInputError: There is no such suite, or no such arm in it.
        """
        postures = load_suite(self.task)
        chosen = range(len(postures)) if self.task_ids is None else self.task_ids
        envs: dict[int, Any] = {}
        for number in chosen:
            arm = postures[whole_number(number, "environment: task_ids", 0, len(postures) - 1)]
            make = [partial(made, arm, **self.gym_kwargs)] * n_envs
            if use_async_envs and n_envs > 1:
                envs[number] = _LazyAsyncVectorEnv(make)
            else:
                envs[number] = gymnasium.vector.SyncVectorEnv(
                    [freeze_after_episode_end(one) for one in make],
                    autoreset_mode=gymnasium.vector.AutoresetMode.SAME_STEP,
                )
        return {self.task: envs}
