"""One line of ``episodes.jsonl``, run again."""

from __future__ import annotations

import json
from dataclasses import dataclass

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.run import runner
from dressing_sim.benchmark.run.agreement import Agreement, compare
from dressing_sim.benchmark.run.executors import single_threaded
from dressing_sim.benchmark.run.plan import Job, fitting_seed
from dressing_sim.benchmark.run.store import RunFolder, episode_line
from dressing_sim.benchmark.studies import thresholds as sensitivity
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.record import Observer
from dressing_sim.learning import Policy
from dressing_sim.numerics import numerics
from dressing_sim.policies.registry import make_policy


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


def replay_episode(folder: RunFolder, index: int, observer: Observer | None = None) -> Replay:
    """Run an episode again, with a policy that learns again from the folder's demonstrations.

    Args:
        folder: A run.
        index: Of the episode.
        observer: Called after every control step.

    Raises:
        InvalidInputError: There is no such episode, or a demonstration is missing.
    """
    recorded = json.loads(folder.line(index))
    job = folder.plan.jobs[index]
    # Of the study of thresholds an episode has a verdict for each; they are made again too.
    study = folder.plan.protocol.name == sensitivity.PROTOCOL.name
    dress = sensitivity.dress_job if study else runner.dress_job
    source = single_threaded(learned_source, folder, job)
    result = single_threaded(dress, source, job, folder.plan.config, observer)
    again = json.loads(episode_line(folder.plan.protocol, result))
    posture, config, _ = job.situation(folder.plan.config)
    agreement = compare(recorded, again, folder.origin.other_numerics(numerics()))
    return Replay(result, agreement, posture, config)


def learned_source(folder: RunFolder, job: Job) -> Policy:
    """What dresses in a job: the operator, or the policy as it was, learned again."""
    shown, number = job.entry.demonstrations, job.demonstration_set
    if shown is None:
        return make_policy(job.entry.policy)
    demonstrations = [folder.load_demonstration(p, number) for p in folder.plan.shown[shown]]
    seed = fitting_seed(folder.plan.seed, job.entry, number)
    return runner.fit_policy(job.entry.policy, seed, demonstrations)
