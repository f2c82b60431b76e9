"""One line of ``episodes.jsonl``, run again."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.run.agreement import Agreement, compare
from dressing_sim.benchmark.run.lines import episode_values
from dressing_sim.benchmark.run.plan import Job
from dressing_sim.benchmark.run.runner import learned_from, learned_source, record_answer
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.rollout import Observer
from dressing_sim.errors import InvalidInputError
from dressing_sim.numerics import numerics, single_threaded


class Repeatable(Protocol):
    """A study whose jobs are episodes that can be run again."""

    def repeat(
        self, folder: RunFolder, job: Job, observer: Observer | None = None
    ) -> EpisodeResult:
        """Run a job of a run again."""


@dataclass(frozen=True, slots=True)
class Replay:
    """An episode that was run again.

    Attributes:
        result: What came out now.
        agreement: How that compares with the recorded line.
        posture: The arm, after variation.
        config: World, robot and rules, after variation.
    """

    result: EpisodeResult
    agreement: Agreement
    posture: Posture
    config: EpisodeConfig

    @property
    def differences(self) -> list[str]:
        """In what it is not the recorded episode, a line each; none if it is."""
        return self.agreement.beyond


def replay_episode(
    study: Repeatable, folder: RunFolder, index: int, observer: Observer | None = None
) -> Replay:
    """Run an episode again, with a policy that learns again from the folder's demonstrations.

    The study is the one that the folder's config names; the observer is called after every step.

    Raises:
        InvalidInputError: There is no such episode, or a demonstration is missing.
    """
    recorded = folder.line(index)
    jobs = folder.plan.jobs
    if index >= len(jobs):
        raise InvalidInputError(
            f"{folder.path}: its study {folder.plan.protocol.study!r} cannot be replayed; valid "
            "is a run of policies that dress"
        )
    job = jobs[index]
    result = single_threaded(study.repeat, folder, job, observer)
    again = json.loads(json.dumps(episode_values(folder.plan, result)))
    posture, config, _ = job.situation(folder.plan.config)
    agreement = compare(recorded, again, folder.origin.other_numerics(numerics()))
    return Replay(result, agreement, posture, config)


def intended(
    folder: RunFolder, index: int
) -> tuple[NDArray[np.float64] | None, tuple[NDArray[np.float64], ...]]:
    """What an episode was meant to be; the policy learns and dresses again for it.

    Returns:
        Where the gripper was to go (n, 3), None if nobody said, and the paths (T, 3) that the
        policy had learned from, in the robot's base frame [m].
    """
    job = folder.plan.jobs[index]
    shown, number = job.entry.demonstrations, job.demonstration_set
    learned = () if shown is None else learned_from(folder, shown, number)
    posture, config, _ = job.situation(folder.plan.config)
    source = learned_source(folder, job)
    recording = single_threaded(record_answer, source, posture, job.seed, config)
    path = None if recording.trajectory is None else recording.trajectory.targets
    return path, tuple(one.positions for one in learned)
