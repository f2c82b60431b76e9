"""One agent and one dressing: what both kinds of environment share."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dressing_sim.arm import SITUATION, Posture
from dressing_sim.checks import of_kind
from dressing_sim.control import HAND_DOWN
from dressing_sim.envs.config import EnvConfig, checked_action
from dressing_sim.envs.reward import COST_AT_LIMIT, arrival_margins, harshness, progress
from dressing_sim.episode.closed_loop import ClosedLoop
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.record import DEFAULT_PATH_DT, PathSource
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import tracked
from dressing_sim.errors import InvalidInputError
from dressing_sim.path import policy_path
from dressing_sim.pictures.rendering import OffscreenRenderer
from dressing_sim.suites.distribution import sample_postures
from dressing_sim.suites.suites import find_posture, load_suite
from dressing_sim.world.dressed import ArmAxis

#: So many steps apart it is looked whether the armscye winds round the arm, which takes as long as
#: a twentieth of a step.
_LOOK = 10


def chosen_posture(
    posture: str | Posture | None, suite: str | None, rng: np.random.Generator
) -> Posture:
    """The arm of an episode: one that is given, one of a suite, or a random one.

    Args:
        posture: A posture or its name, see `find_posture`.
        suite: Name or file of a suite, of which one is drawn.
        rng: For what is drawn, of a suite or as random suites are.

    Raises:
        InvalidInputError: Both are given, or there is no such posture or suite.
    """
    if posture is not None and suite is not None:
        raise InvalidInputError("both a posture and a suite are given; valid is one of them")
    if suite is not None:
        postures = load_suite(suite)
        return postures[int(rng.integers(len(postures)))]
    if posture is None:
        return sample_postures(1, rng)[0]
    if isinstance(posture, str):
        return find_posture(posture)
    return of_kind(posture, Posture, "posture", "a Posture or its name")


class Task:
    """An agent dresses arms, one after the other.

    Args:
        config: What it sees, does and is rewarded for.

    Attributes:
        config: As given.
        reward: For the last step.
    """

    def __init__(self, config: EnvConfig) -> None:
        self.config, self.reward = of_kind(config, EnvConfig, "config", "an EnvConfig"), 0.0
        self._size = config.action_range.shape[0]
        self._dressing: Dressing | None = None
        self._begun: ClosedLoop | None = None
        self._renderer: OffscreenRenderer | None = None
        self._framed: tuple[Posture | None, dict[str, NDArray[np.float64]]] = None, {}

    def begin(self, posture: Posture) -> None:
        """Begin an episode."""
        if self._dressing is None or self._dressing.posture != posture:
            self.close()
            self._dressing = Dressing(posture, self.config.episode)
        self._begun = ClosedLoop(self._dressing)
        self._steps, self._on = 0, False
        self._recording: Recording | None = None
        self._look()
        self._progress, self.reward = self._now(), 0.0

    @property
    def dressing(self) -> Dressing:
        """The core, to be looked at.

        Raises:
            InvalidInputError: No episode has begun.
        """
        return self._loop.dressing

    @property
    def _loop(self) -> ClosedLoop:
        if self._begun is None:
            raise InvalidInputError("no episode has begun; valid is reset() first")
        return self._begun

    @property
    def time(self) -> float:
        """Since the robot began to move [s]."""
        return self._loop.row.time

    def act(self, action: object) -> None:
        """One control step. In an episode that is over nothing happens.

        Args:
            action: See `EnvConfig.action_range`.

        Raises:
            InvalidInputError: It is of another shape or not finite.
        """
        numbers, dressing = checked_action(action, self._size), self.dressing
        self.reward = 0.0
        if self._loop.over:
            return
        finish = self._arrived() if self.config.finish == "arrival" else numbers[-1] > 0.5
        rotation = None
        if self.config.rotation:
            rotation = Rotation.from_rotvec(numbers[3:6]).as_matrix() @ HAND_DOWN
        moved = self.config.control == "displacement"
        wanted = dressing.target + numbers[:3] if moved else numbers[:3]
        self._loop.step(None if finish else wanted, rotation)
        self._steps += 1
        self._look()
        before, self._progress = self._progress, self._now()
        self.reward = self._rewarded(self._progress - before)

    def _arrived(self) -> bool:
        margins = arrival_margins(
            self._loop.row, self.dressing.shoulder, self.config.episode.thresholds
        )
        return min(margins) >= 0.0

    def _look(self) -> None:
        if self._steps % _LOOK == 0:
            world = self.dressing.world
            axis = ArmAxis(world.arm_joints)
            self._on = bool(axis.winding(world.mesh.rings(world.cloth)[0]) == 1)

    def _now(self) -> float:
        shoulder = self.dressing.shoulder
        return progress(self._loop.row, self._on, shoulder, self.config.episode.thresholds)

    def _rewarded(self, gain: float) -> float:
        success = float(self.success)
        if self.config.reward == "sparse":
            return success
        episode = self.config.episode
        harsh = harshness(self._loop.row, episode.thresholds)
        return gain - COST_AT_LIMIT * episode.tracking.dt * harsh + success

    @property
    def broken(self) -> bool:
        """Whether the simulation broke down before the robot stopped."""
        return self.dressing.invalid is not None and not self.dressing.stopped

    @property
    def terminated(self) -> bool:
        """Whether the robot has finished, is out of reach, or made its protective stop."""
        return self._loop.over and not self.truncated

    @property
    def truncated(self) -> bool:
        """Whether time is up before that, or the simulation broke down."""
        if self.broken:
            return True
        loop = self._loop
        stop = self.dressing.stopped and self.config.episode.protective_stop
        return loop.over and not (loop.finished or loop.out_of_reach or stop)

    @property
    def success(self) -> bool:
        """Whether the episode is over and the arm dressed."""
        return self._loop.over and self.recording().outcome.success

    def recording(self) -> Recording:
        """The episode so far, judged."""
        if not self._loop.over:
            return self._loop.recording()
        if self._recording is None:
            self._recording = self._loop.recording()
        return self._recording

    def information(self) -> dict[str, Any]:
        """``is_success``; at the end ``reasons`` and ``metrics``, and why it is ``invalid``."""
        told: dict[str, Any] = {"is_success": self.success}
        if self._loop.over:
            outcome = self.recording().outcome
            told |= {"reasons": outcome.reasons, "metrics": dict(outcome.metrics)}
            if outcome.invalid is not None:
                told["invalid"] = outcome.invalid
        return told

    def observation(self) -> dict[str, NDArray[Any]]:
        """What the agent sees now: new arrays by name."""
        row, dressing = self._loop.row, self.dressing
        seen: dict[str, NDArray[Any]] = {
            "gripper": row.tcp.copy(),
            "target": dressing.target,
            "grip_force": np.array([row.grip_force]),
        }
        seen |= {name: array.copy() for name, array in self._frames(dressing.seen).items()}
        for name in self.config.observe:
            if name == "arm_coordinate":
                seen[name] = np.array([row.armscye_s, row.hem_s])
            elif name == "link_force":
                seen[name] = row.link_force.copy()
            else:
                seen[name] = dressing.world.cloth if name == "cloth" else self.picture()
        return seen

    def _frames(self, posture: Posture) -> dict[str, NDArray[np.float64]]:
        """The paper's frames of an arm as observations; worked out once for each."""
        if self._framed[0] is not posture:
            arrays: dict[str, NDArray[np.float64]] = {}
            for name, frame in zip(SITUATION, posture.frames(), strict=True):
                axes = np.clip(frame.A, -1.0, 1.0)  # rounded, a cosine may be a bit above one
                arrays |= {f"{name}_position": frame.b, f"{name}_axes": axes}
            self._framed = posture, arrays
        return self._framed[1]

    def picture(self, camera: str | None = None) -> NDArray[np.uint8]:
        """A picture (height, width, 3) of the scene now, from the config's camera or another."""
        dressing, config = self.dressing, self.config
        if self._renderer is None:
            world = config.episode.world
            self._renderer = OffscreenRenderer(dressing.posture, world, config.width, config.height)
        return self._renderer.draw(dressing.world.data.qpos, camera or config.camera)

    def actions(self, source: PathSource, seed: int = 0) -> NDArray[np.float64]:
        """The actions that lead the gripper along a path and finish, (n, size).

        With control by ``target`` the episode is that of `dressing_sim.record`, to the bit; a path
        out of reach, which that refuses, is tried here. With control by ``displacement`` targets
        may be off by a rounding.

        Args:
            source: A path, or a policy that makes one, as in `dressing_sim.record`.
            seed: Of the policy's own randomness.
        """
        dressing, episode = self.dressing, self.config.episode
        path = policy_path(
            source, dressing.seen, dressing.start, seed, DEFAULT_PATH_DT, episode.time_limit
        )
        trajectory = tracked(dressing, path.positions, path.dt or DEFAULT_PATH_DT)
        n_steps = len(trajectory.targets) - 1
        n_hold = round(episode.hold / episode.tracking.dt)
        actions = np.zeros((n_steps + n_hold, self._size))
        if self.config.control == "target":
            actions[:, :3] = np.pad(trajectory.targets[1:], ((0, n_hold), (0, 0)), mode="edge")
        else:
            place = trajectory.targets[0]
            for step, target in zip(actions, trajectory.targets[1:], strict=False):
                step[:3] = target - place
                place = place + step[:3]  # with its rounding, so that none adds up
        if self.config.finish == "agent":
            actions[n_steps:, -1] = 1.0
        return actions

    def close(self) -> None:
        """Free what drew the pictures, if anything did."""
        if self._renderer is not None:
            self._renderer.close()
            self._renderer = None


def env_config(choices: Mapping[str, Any]) -> EnvConfig:
    """The configuration with these fields.

    Raises:
        InvalidInputError: There is no such field, or a value is not valid.
    """
    of_kind(choices, Mapping, "environment: choices", "fields of EnvConfig by name")
    unknown = sorted(map(str, set(choices) - set(EnvConfig.__dataclass_fields__)))
    if unknown:
        valid = ", ".join(EnvConfig.__dataclass_fields__)
        raise InvalidInputError(f"environment: no choice {unknown[0]!r}; valid is {valid}")
    return EnvConfig(**choices)
