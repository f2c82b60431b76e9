"""`DressArm` as LeRobot's loops look at an environment."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from dressing_sim.arm import SITUATION
from dressing_sim.checks import one_of
from dressing_sim.envs.gym import DressArm
from dressing_sim.lerobot_names import TASK
from dressing_sim.pictures import CAMERAS

#: How LeRobot's loops say in ``reset(options=)`` that an episode is one of theirs.
NEW_ROLLOUT = "lerobot_new_rollout"

#: What is observed of the frames, in the order of the exported data sets.
_FRAMES = [f"{name}_{part}" for name in SITUATION for part in ("position", "axes")]

Seen = dict[str, Any]


class LeRobotArm(gymnasium.Wrapper[Seen, NDArray[np.float64], Seen, NDArray[np.float64]]):
    """The same episodes; what is observed has the names that LeRobot renames.

    | key | shape | LeRobot's name | what | unit |
    |---|---|---|---|---|
    | ``agent_pos`` | (3,) | ``observation.state`` | the gripper | m |
    | ``environment_state`` | (24,) | ``observation.environment_state`` | the frames of shoulder \
and wrist: position, then axes row by row | m, - |
    | ``pixels``, by camera | (height, width, 3) | ``observation.images.<camera>`` | pictures | - |

    Places are in the robot's base frame.

    Args:
        arm: The environment.
        cameras: Some of `dressing_sim.pictures.CAMERAS`; without any there are no ``pixels``.

    Attributes:
        task: What the robot is told that it does; ``task_description`` is the same.
    """

    def __init__(self, arm: DressArm, cameras: Sequence[str] = ()) -> None:
        super().__init__(arm)
        for camera in cameras:
            one_of(camera, "environment: cameras", CAMERAS)
        self.task = self.task_description = TASK
        self._arm, self._cameras = arm, tuple(cameras)
        config = arm.task.config
        #: No episode is longer [steps].
        self._max_episode_steps = round(config.episode.time_limit / config.episode.tracking.dt)
        given: Any = arm.observation_space
        self._frames = spaces.Tuple([given[name] for name in _FRAMES])
        told: dict[str, spaces.Space[Any]] = {
            "agent_pos": given["gripper"],
            "environment_state": spaces.flatten_space(self._frames),
        }
        if cameras:
            picture = spaces.Box(0, 255, (config.height, config.width, 3), np.uint8)
            told["pixels"] = spaces.Dict(dict.fromkeys(cameras, picture))
        self.observation_space = spaces.Dict(told)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Seen, dict[str, Any]]:
        """Begin an episode, see `DressArm.reset`."""
        ours = {name: value for name, value in (options or {}).items() if name != NEW_ROLLOUT}
        seen, info = self._arm.reset(seed=seed, options=ours)
        return self._seen(seen), info

    def step(self, action: NDArray[np.float64]) -> tuple[Seen, float, bool, bool, dict[str, Any]]:
        """One control step, see `DressArm.step`."""
        seen, reward, terminated, truncated, info = self._arm.step(action)
        return self._seen(seen), reward, terminated, truncated, info

    def _seen(self, seen: Seen) -> Seen:
        frames = spaces.flatten(self._frames, tuple(seen[name] for name in _FRAMES))
        told: Seen = {"agent_pos": seen["gripper"], "environment_state": frames}
        if self._cameras:
            told["pixels"] = {name: self._arm.task.picture(name) for name in self._cameras}
        return told
