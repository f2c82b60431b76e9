"""The study of a change of the simulation: would verdicts differ, and what does it cost?

Policies dress in the default world; the same joint commands are played again in one with another
mesh, another solver, or something more, such as contacts of the cloth with itself.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import fields, replace
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
from dressing_sim.benchmark.studies.agreement_document import change_document
from dressing_sim.benchmark.studies.study import Calls, Summary
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.rollout import Observer, play
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy
from dressing_sim.policies.hyperparameters import changed
from dressing_sim.world.scene import SolverConfig
from dressing_sim.world.sleeve import SleeveConfig

#: What can be changed: how the cloth and the solver are, not what the garment is.
_KINDS: tuple[type[Any], ...] = (SleeveConfig, SolverConfig)
_NAMES = tuple(
    field.name
    for kind in _KINDS
    for field in fields(kind)
    if field.name not in ("garment", "grasp_offset", "solver")
)

_OPTION = "change"


def with_change(config: EpisodeConfig, change: str) -> EpisodeConfig:
    """The same with another world.

    Args:
        config: The default world's.
        change: ``name=value&...``, fields of `SleeveConfig` and `SolverConfig`.

    Raises:
        InvalidInputError: An unknown name, or a value that cannot be.
    """
    unknown = [part.partition("=")[0] for part in change.split("&")]
    unknown = [name for name in unknown if name not in _NAMES]
    if unknown:
        raise InvalidInputError(
            f"change: unknown setting {unknown[0]!r}; valid is name=value&..., of "
            f"{', '.join(_NAMES)}"
        )
    return replace(config, world=changed(config.world, change))


def change_plan(change: str, *chosen: Any) -> Plan:
    """The plan of the study.

    Args:
        change: As of `with_change`.
        chosen: As of `agreement_plan`.

    Raises:
        InvalidInputError: As of both.
    """
    plan = agreement_plan(*chosen)
    if with_change(plan.config, change) == plan.config:
        raise InvalidInputError(f"change is {change!r}, valid is what the default is not")
    protocol = Protocol("change", plan.protocol.suite, plan.protocol.entries, study="change")
    return replace(plan, protocol=protocol, options={**plan.options, _OPTION: change})


def dress_changed(
    change: str, source: Policy, job: Job, config: EpisodeConfig, observer: Observer | None = None
) -> EpisodeResult:
    """Run one episode in the default world, and its commands in the other."""
    posture, varied, drawn = job.situation(config)
    begun = time.process_time()
    recording = other = record_answer(source, posture, job.seed, varied, observer)
    seconds = [time.process_time() - begun]
    if recording.trajectory is not None:
        begun = time.process_time()
        other = play(Dressing(posture, with_change(varied, change)), recording.trajectory)
        seconds.append(time.process_time() - begun)
    extra: dict[str, Json] = {REFERENCE: other.outcome.to_dict(), DECIDED: True, SECONDS: seconds}
    return job_result(job, posture, drawn, recording.outcome, extra)


class Change(Agreement):
    """How often the default world gives the verdict of another."""

    def other(self, plan: Plan) -> EpisodeConfig:
        """The world that verdicts are compared with."""
        return with_change(plan.config, _change(plan))

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
        """The change, the share of equal verdicts, and which differ."""
        return {"change": _change(folder.plan), **super().summarise(folder, results)}

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """A sentence, a table of rows, and the episodes whose verdicts differ."""
        return change_document(results, summary, command)


def _change(plan: Plan) -> str:
    return str(plan.options[_OPTION])


def _work(plan: Plan) -> Work:
    return Work(dress=partial(dress_changed, _change(plan)))
