"""Whole episodes: a path, a policy or the operator dresses one arm. Loops over `Dressing`."""

from __future__ import annotations

from collections.abc import Sequence
from types import NoneType

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import function_or_none, of_kind, real_array, whole_number
from dressing_sim.config import from_plain, to_plain
from dressing_sim.control import JointTrajectory
from dressing_sim.episode.closed_loop import close_the_loop
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer, follow, play
from dressing_sim.episode.rule import Rule
from dressing_sim.episode.rules import RULES
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.learning import Policy
from dressing_sim.path import Path, check_source, policy_path

#: Seconds between the points of a path whose maker does not say.
DEFAULT_PATH_DT = 0.05

PathSource = Policy | Path | NDArray[np.float64]


class DemonstrationFailed(DressingSimError):
    """There is nothing to learn from: the robot never moved.

    Attributes:
        outcome: What became of the episode.
    """

    def __init__(self, message: str, outcome: Outcome) -> None:
        super().__init__(message)
        self.outcome = outcome


def record(
    source: PathSource,
    posture: Posture,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
    rules: Sequence[Rule] = RULES,
) -> Recording:
    """Dress an arm once and keep the measurements.

    Args:
        source: A fitted policy, which is asked with what its class of inputs stands for; or a path,
            a `Path` or an array (T, 3) in the robot's base frame [m], with ``DEFAULT_PATH_DT``
            between its points. A policy with ``act`` is asked for a target in every control step
            instead of for a path.
        posture: The arm to dress.
        seed: Of the policy's own randomness, such as the operator's variability.
        config: World, robot and thresholds.
        observer: Called after every control step.
        rules: What is judged.

    Raises:
        InvalidInputError: The path, or a target, has the wrong shape or is not finite.
    """
    whole_number(seed, "seed", 0, 2**63 - 1)
    function_or_none(observer, "observer")
    if not callable(getattr(source, "act", None)):
        check_source(source)
    dressing = Dressing(posture, config, rules)
    if dressing.invalid is not None:
        # Nobody is asked for a path from a place that makes no sense.
        outcome = Outcome(False, invalid=dressing.invalid)
        return Recording(outcome, None, None, dressing.start[None], broke=dressing.invalid)
    if callable(getattr(source, "act", None)):
        return close_the_loop(dressing, source, seed, observer)
    longest = dressing.config.time_limit
    path = policy_path(source, dressing.seen, dressing.start, seed, DEFAULT_PATH_DT, longest)
    return follow(dressing, path.positions, path.dt or DEFAULT_PATH_DT, observer)


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
) -> Demonstration:
    """Record a demonstration of the scripted operator.

    Returns:
        What the gripper did from its first to its last command, without the final hold. Its
        ``outcome`` says whether it is worth learning from.

    Raises:
        DemonstrationFailed: The robot could not move; the error has the outcome.
    """
    of_kind(operator, (Operator, NoneType), "operator", "an Operator or None")
    of_kind(config, (EpisodeConfig, NoneType), "config", "an EpisodeConfig or None")
    operator = operator or Operator()
    config = config or EpisodeConfig()
    recording = record(operator, posture, seed, config, observer)
    outcome = recording.outcome
    if recording.trace is None or recording.trajectory is None:
        why = outcome.invalid or ", ".join(failure.detail for failure in outcome.failures)
        raise DemonstrationFailed(f"no demonstration on posture {posture.name!r}: {why}", outcome)
    commands = recording.trajectory.positions
    return Demonstration(
        positions=recording.positions[: len(commands)],
        dt=recording.trajectory.dt,
        posture=posture,
        seed=seed,
        commands=commands[: len(recording.positions)],
        settings={"episode": to_plain(config), "operator": to_plain(operator.config)},
        outcome=outcome,
    )


def replay(demonstration: Demonstration, observer: Observer | None = None) -> Recording:
    """Play a demonstration's commands again in the world it was recorded in.

    With the versions that it was recorded with, and on the same kind of processor, the gripper's
    positions are the same to the bit.

    Raises:
        InvalidInputError: It does not say which world it was recorded in.
    """
    dressing, commands = recorded_in(demonstration)
    targets = np.array([dressing.kinematics.tcp_pose(q)[0] for q in commands])
    trajectory = JointTrajectory(commands, demonstration.dt, targets, np.zeros(len(commands)))
    return play(dressing, trajectory, observer)


def recorded_in(demonstration: Demonstration) -> tuple[Dressing, NDArray[np.float64]]:
    """The dressing that a demonstration was, not begun, and its joint commands (T, n) [rad].

    Raises:
        InvalidInputError: It does not say which world it was recorded in.
    """
    commands = demonstration.commands
    if "episode" not in demonstration.settings or commands is None:
        raise InvalidInputError(
            f"the demonstration on {demonstration.posture.name!r} has no settings of its episode; "
            "valid is one that was recorded in the simulator"
        )
    config = from_plain(EpisodeConfig, demonstration.settings["episode"])
    dressing = Dressing(demonstration.posture, config)
    n_joints = dressing.kinematics.robot.n_joints
    return dressing, real_array(commands, ("T", n_joints), "commands have", "rad")
