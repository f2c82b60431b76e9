"""Gymnasium's environment ``dressing_sim/DressArm-v0``."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import of_kind, one_of, whole_number
from dressing_sim.envs.config import Range
from dressing_sim.envs.task import Task, chosen_posture, env_config
from dressing_sim.episode.record import PathSource
from dressing_sim.episode.recording import Recording
from dressing_sim.errors import InvalidInputError

OPTIONS = ("posture", "suite")  # of `DressArm.reset`


class DressArm(gymnasium.Env[dict[str, NDArray[Any]], NDArray[np.float64]]):
    """A Panda pulls a sleeve over a hand, round an elbow and up to a shoulder.

    All places are in the robot's base frame. One step is 20 ms.

    **Action**, one array:

    | numbers | what | range |
    |---|---|---|
    | 3 | displacement of the gripper's target | -5 to 5 mm, in [m] |
    | or 3, with ``control="target"`` | that target | -1 to 1 m |
    | 3 more, with ``rotation=True`` | turn of the hand from pointing down | -1 to 1 rad |
    | 1, unless ``finish="arrival"`` | above 0.5: I have finished, stop and hold | 0 to 1 |

    The turn is a rotation vector; without it the hand points down and turns freely about that. With
    ``finish="arrival"`` the robot stops and holds by itself wherever gripper and sleeve arrived.

    The range is what the robot can do; beyond it a target is a direction, approached at 0.25 m/s.

    **Observation**, a dictionary of arrays:

    | key | shape | what | unit |
    |---|---|---|---|
    | ``gripper`` | (3,) | the gripper | m |
    | ``target`` | (3,) | the target that it last approached | m |
    | ``grip_force`` | (1,) | pull on the cloth, as a force sensor reads it | N |
    | ``shoulder_position``, ``wrist_position`` | (3,) | origins of the two frames | m |
    | ``shoulder_axes``, ``wrist_axes`` | (3, 3) | their axes, one a column; x to the elbow | - |
    | ``arm_coordinate`` | (2,) | of armscye and hem: 0 wrist, 1 elbow, 2 shoulder | - |
    | ``link_force`` | (5, 3) | of the cloth on hand, forearm, upper arm, torso, head | N |
    | ``cloth`` | (n, 3) | vertices of the garment | m |
    | ``image`` | (height, width, 3) | a picture, as `render` gives | - |

    The last four only if ``observe`` names them: no robot in a ward has the first three.

    **Reward** ``"dense"``: what a step gains of `dressing_sim.envs.reward.progress` (0 to 1), less
    up to 0.5 a second near the limits of force and strain, and 1 for success. ``"sparse"``: 1 for
    success.

    **Start**: the sleeve hangs still from the gripper in front of the hand. ``reset(seed=)`` draws
    an arm as ``random:N:SEED`` suites do, unless ``posture`` or ``suite`` say which, here or in
    its ``options``.

    **End**: ``terminated`` once the agent has said for a second, in one go, that it has finished,
    which is then judged; or at the protective stop (a hit, a lost grasp, too much force or strain);
    or if the target is out of reach. ``truncated`` at the time limit of 30 s, or if the simulation
    broke down (``info["invalid"]``): then it is neither success nor failure.

    ``info["is_success"]`` is there always, ``info["reasons"]`` and ``info["metrics"]`` at the end.

    Args:
        posture: Whom to dress, a `Posture` or its name.
        suite: Or whose postures to draw from.
        render_mode: ``"rgb_array"`` or None.
        choices: Fields of `dressing_sim.envs.config.EnvConfig`.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 50}  # noqa: RUF012 (Gymnasium's)

    def __init__(
        self,
        posture: str | Posture | None = None,
        suite: str | None = None,
        render_mode: str | None = None,
        **choices: Any,
    ) -> None:
        if render_mode is not None:
            one_of(render_mode, "render_mode", ("rgb_array",))
        self.render_mode = render_mode
        self._given = posture, suite
        self.task = Task(env_config(choices))
        self.action_space: spaces.Space[Any] = _box(self.task.config.action_range)
        ranges = self.task.config.observation_ranges
        self.observation_space: spaces.Space[Any] = spaces.Dict(
            {name: _box(one) for name, one in ranges.items()}
        )

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, NDArray[Any]], dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: Of what is drawn from now on.
            options: ``posture`` or ``suite``, for this episode, instead of the constructor's.

        Raises:
            InvalidInputError: There is no such option, posture or suite.
        """
        super().reset(seed=None if seed is None else whole_number(seed, "seed"))
        if options is not None:
            of_kind(options, dict, "reset: options", "a dictionary or None")
        unknown = sorted(map(str, set(options or {}) - set(OPTIONS)))
        if unknown:
            raise InvalidInputError(
                f"reset: no option {unknown[0]!r}; valid are {', '.join(OPTIONS)}"
            )
        posture, suite = self._given
        if options:
            posture, suite = options.get("posture"), options.get("suite")
        arm = chosen_posture(posture, suite, self.np_random)
        self.task.begin(arm)
        return self.task.observation(), {**self.task.information(), "posture": arm.name}

    def step(
        self, action: NDArray[np.float64]
    ) -> tuple[dict[str, NDArray[Any]], float, bool, bool, dict[str, Any]]:
        """One control step; once the episode is over nothing happens any more."""
        (task := self.task).act(action)
        ends = task.terminated, task.truncated
        return task.observation(), task.reward, *ends, task.information()

    def render(self) -> NDArray[np.uint8] | None:
        """A picture (height, width, 3), with ``render_mode="rgb_array"``."""
        return self.task.picture() if self.render_mode == "rgb_array" else None

    def actions(self, source: PathSource, seed: int = 0) -> NDArray[np.float64]:
        """The actions that play a path, or a policy's, see `Task.actions`."""
        return self.task.actions(source, seed)

    def recording(self) -> Recording:
        """The episode so far, judged: its outcome and its trace."""
        return self.task.recording()

    def close(self) -> None:
        """Free what drew the pictures."""
        self.task.close()


def _box(one: Range) -> spaces.Box:
    return spaces.Box(one.low, one.high, one.shape, one.dtype)
