"""Whole episodes: a path, a policy or the operator dresses one arm."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.config import from_plain, to_plain
from dressing_sim.control import JointTrajectory
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.dressing import Episode, Observer
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rules import Outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy
from dressing_sim.path import checked_path, policy_path

#: Seconds between the points of a path whose maker does not say.
DEFAULT_PATH_DT = 0.05


PathSource = Policy | Operator | NDArray[np.float64]


def record(
    source: PathSource,
    posture: Posture,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
) -> Recording:
    """Dress an arm once and keep the measurements.

    Args:
        source: A fitted policy, which sees the frames and the gripper's position only; the
            scripted operator, which sees the posture; or a path, shape (T, 3), in the robot's base
            frame [m], with ``DEFAULT_PATH_DT`` between its points.
        posture: The arm to dress.
        seed: Seed of the operator's variability.
        config: World, robot and rules.
        observer: Called after every control step.

    Raises:
        InvalidInputError: The path has the wrong shape or is not finite.
    """
    episode = Episode(posture, config)
    broke = episode.world.invalid_reason
    if broke is not None:
        return episode.void(broke)  # nobody is asked for a path from a place that makes no sense
    if isinstance(source, Operator):
        path = source.path(posture, episode.start, np.random.default_rng(seed))
        return episode.follow(path, source.config.dt, observer)
    if isinstance(source, np.ndarray):
        return episode.follow(checked_path(source, "the path"), DEFAULT_PATH_DT, observer)
    path, dt = policy_path(
        source, posture.frames(), episode.start, DEFAULT_PATH_DT, episode.config.time_limit
    )
    return episode.follow(path, dt, observer)


def dress(
    path_or_policy: PathSource,
    posture: Posture,
    seed: int = 0,
    config: EpisodeConfig | None = None,
) -> Outcome:
    """Dress an arm once: the outcome of `record`."""
    return record(path_or_policy, posture, seed, config).outcome


def demonstrate(
    posture: Posture,
    seed: int,
    operator: Operator | None = None,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
) -> tuple[Demonstration | None, Outcome]:
    """Record a demonstration of the scripted operator.

    Returns:
        What the gripper did from its first to its last command, without the final hold, or None
        if the robot could not move; and the outcome, which says whether it is worth learning from.
    """
    operator = operator or Operator()
    config = config or EpisodeConfig()
    recording = record(operator, posture, seed, config, observer)
    if recording.trace is None or recording.trajectory is None:
        return None, recording.outcome
    commands = recording.trajectory.positions
    demonstration = Demonstration(
        positions=recording.positions[: len(commands)],
        dt=recording.trajectory.dt,
        posture=posture,
        seed=seed,
        commands=commands[: len(recording.positions)],
        settings={"episode": to_plain(config), "operator": to_plain(operator.config)},
    )
    return demonstration, recording.outcome


def replay(demonstration: Demonstration, observer: Observer | None = None) -> Recording:
    """Play a demonstration's commands again in the world it was recorded in.

    With the versions that it was recorded with, the gripper's positions are the same to the bit.

    Raises:
        InvalidInputError: It does not say which world it was recorded in.
    """
    if "episode" not in demonstration.settings:
        raise InvalidInputError(
            f"the demonstration on {demonstration.posture.name!r} has no settings of its episode; "
            "valid is one that was recorded in the simulator"
        )
    config = from_plain(EpisodeConfig, demonstration.settings["episode"])
    episode = Episode(demonstration.posture, config)
    commands = demonstration.commands
    targets = np.array([episode.kinematics.tcp_pose(q)[0] for q in commands])
    return episode.play(
        JointTrajectory(commands, demonstration.dt, targets, np.zeros(len(commands))), observer
    )
