"""Whole episodes on postures that may be given by their names: what the package makes public."""

from __future__ import annotations

from collections.abc import Sequence

from dressing_sim.arm import Posture
from dressing_sim.episode import record as episodes
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.record import PathSource
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import Observer
from dressing_sim.episode.rule import Rule
from dressing_sim.episode.rules import RULES
from dressing_sim.suites.suites import find_posture


def record(
    source: PathSource,
    posture: Posture | str,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
    rules: Sequence[Rule] = RULES,
) -> Recording:
    """Dress an arm once and keep the measurements, see `dressing_sim.episode.record.record`.

    Args:
        source: A fitted policy, or a path in the robot's base frame [m].
        posture: The arm to dress, or its name in a suite (see `find_posture`).
        seed: Of the policy's own randomness, such as the operator's variability.
        config: World, robot and thresholds.
        observer: Called after every control step.
        rules: What is judged.

    Raises:
        InvalidInputError: There is no such posture, or the path or a target is not valid.
    """
    return episodes.record(source, _posture(posture), seed, config, observer, rules)


def dress(
    path_or_policy: PathSource,
    posture: Posture | str,
    seed: int = 0,
    config: EpisodeConfig | None = None,
) -> Outcome:
    """Dress an arm once: the outcome of `record`."""
    return episodes.dress(path_or_policy, _posture(posture), seed, config)


def demonstrate(
    posture: Posture | str,
    seed: int,
    operator: Operator | None = None,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
) -> Demonstration:
    """Record a demonstration of the scripted operator, on a posture or one of this name.

    Returns:
        What the gripper did, see `dressing_sim.episode.record.demonstrate`.

    Raises:
        InvalidInputError: There is no such posture.
        DemonstrationFailed: The robot could not move; the error has the outcome.
    """
    return episodes.demonstrate(_posture(posture), seed, operator, config, observer)


def _posture(posture: Posture | str) -> Posture:
    return find_posture(posture) if isinstance(posture, str) else posture
