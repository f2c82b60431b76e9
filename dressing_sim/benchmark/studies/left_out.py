"""The study of what is left out of the simulation: would verdicts differ if it were in?

Policies dress in the default world; the same joint commands are played again with one thing more.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

from dressing_sim.benchmark.records import EpisodeResult, Json, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.plan import Job, Plan
from dressing_sim.benchmark.run.progress import Progress
from dressing_sim.benchmark.run.runner import Work, job_result, record_answer
from dressing_sim.benchmark.run.store import OpenRun, RunFolder
from dressing_sim.benchmark.studies.agreement import (
    DECIDED,
    REFERENCE,
    SECONDS,
    Agreement,
    agreement_plan,
)
from dressing_sim.benchmark.studies.agreement_document import left_out_document
from dressing_sim.benchmark.studies.study import Calls, Summary
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.rollout import Observer, play
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy

#: Setting of the sleeve that puts each thing in, by what it is called.
LEFT_OUT: Mapping[str, str] = {
    "bending": "bending",
    "self-contact": "self_contact",
    "robot-contact": "robot_contact",
    "air-drag": "air_drag",
}

_OPTION = "left_out"


def with_it(config: EpisodeConfig, what: str) -> EpisodeConfig:
    """The same world with one of `LEFT_OUT`."""
    more: Any = {LEFT_OUT[what]: True}
    sleeve = replace(config.world.sleeve, **more)
    return replace(config, world=replace(config.world, sleeve=sleeve))


def left_out_plan(what: str, *chosen: Any) -> Plan:
    """The plan of the study.

    Args:
        what: One of `LEFT_OUT`.
        chosen: As of `agreement_plan`.

    Raises:
        InvalidInputError: Nothing of that name is left out, or as of `agreement_plan`.
    """
    if what not in LEFT_OUT:
        raise InvalidInputError(f"left-out is {what!r}, valid is one of {', '.join(LEFT_OUT)}")
    plan = agreement_plan(*chosen)
    protocol = Protocol("left-out", plan.protocol.suite, plan.protocol.entries, study="left-out")
    return replace(plan, protocol=protocol, options={**plan.options, _OPTION: what})


def dress_with_it(
    what: str, source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode in the default world, and its commands in one with something more."""
    posture, varied, drawn = job.situation(config)
    begun = time.process_time()
    recording = other = record_answer(source, posture, job.seed, varied, observer)
    seconds = [time.process_time() - begun]
    if recording.trajectory is not None:
        begun = time.process_time()
        other = play(Dressing(posture, with_it(varied, what)), recording.trajectory)
        seconds.append(time.process_time() - begun)
    extra: dict[str, Json] = {REFERENCE: other.outcome.to_dict(), DECIDED: True, SECONDS: seconds}
    return job_result(job, posture, drawn, recording.outcome, extra)


class LeftOut(Agreement):
    """How often the default world gives the verdict of one with something more."""

    def other(self, plan: Plan) -> EpisodeConfig:
        """The world that verdicts are compared with."""
        return with_it(plan.config, _what(plan))

    def calls(
        self, folder: OpenRun, jobs: Sequence[Job], workers: Workers, progress: Progress
    ) -> Calls[EpisodeResult, Job]:
        """Demonstrate and learn; then each job dresses twice."""
        return Agreement(_work(folder.plan)).calls(folder, jobs, workers, progress)

    def repeat(
        self, folder: RunFolder, job: Job, observer: Observer | None = None
    ) -> EpisodeResult:
        """Run an episode again, with a policy that learns again."""
        return Agreement(_work(folder.plan)).repeat(folder, job, observer)

    def summarise(self, folder: RunFolder, results: Sequence[EpisodeResult]) -> dict[str, Any]:
        """What is in, the share of equal verdicts, and which differ."""
        return {"left_out": _what(folder.plan), **super().summarise(folder, results)}

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """A sentence, a table of rows, and the episodes whose verdicts differ."""
        return left_out_document(results, summary, command)


def _what(plan: Plan) -> str:
    return str(plan.options[_OPTION])


def _work(plan: Plan) -> Work:
    return Work(dress=partial(dress_with_it, _what(plan)))
