"""The study of convergence: do verdicts come from the arm and the cloth, or from the solver?

The same postures and paths are simulated with coarser and finer meshes, longer and shorter steps,
and other solvers; every verdict is compared with that of the finest, and the metrics of those that
change the solver alone with those of a solver that has converged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from dressing_sim.benchmark.records import Json, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.lines import parse_outcome
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.benchmark.run.progress import Progress
from dressing_sim.benchmark.run.store import OpenRun, RunFolder
from dressing_sim.benchmark.studies.convergence_document import convergence_document
from dressing_sim.benchmark.studies.convergence_summary import compare
from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Setting,
    Trial,
    TrialJob,
    settings,
    simulate,
)
from dressing_sim.benchmark.studies.study import Study
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.provenance import versions
from dressing_sim.suites.suites import load_suite


def convergence_plan(
    suite: str = "val50", postures: int = 15, only: Sequence[str] | None = None, seed: int = 0
) -> Plan:
    """The plan of the study.

    Args:
        suite: Postures.
        postures: How many of them, from the first.
        only: Settings to try besides the default, the finest and a converged solver; all if None.
        seed: Of the operator's variability.

    Raises:
        InvalidInputError: There is no such suite or setting.
    """
    names = [setting.name for setting in settings()]
    unknown = sorted(set(only or ()) - set(names))
    if unknown:
        raise InvalidInputError(
            f"unknown setting {unknown[0]!r}; valid is one of {', '.join(names)}"
        )
    wanted = {DEFAULT, FINEST, CONVERGED, *(names if only is None else only)}
    return Plan(
        Protocol("convergence", suite, (), study="convergence"),
        seed,
        EpisodeConfig(),
        tuple(load_suite(suite)[:postures]),
        {},
        {"settings": [name for name in names if name in wanted]},
    )


@dataclass(frozen=True)
class Convergence(Study[TrialJob, Trial]):
    """Every posture with every path under all settings.

    Attributes:
        simulate: What one job does.
    """

    simulate: Callable[[TrialJob, int], Trial] = field(default=simulate)

    def jobs(self, plan: Plan) -> Sequence[TrialJob]:
        """The episodes, by setting, path and posture."""
        places = [
            (setting, path, posture)
            for setting in _chosen(plan)
            for path in PATHS
            for posture in plan.tested
        ]
        return [TrialJob(index, *place) for index, place in enumerate(places)]

    def calls(
        self, folder: OpenRun, jobs: Sequence[TrialJob], workers: Workers, progress: Progress
    ) -> tuple[Callable[..., Trial], Iterable[tuple[TrialJob, tuple[Any, ...]]]]:
        """All settings of an episode after one another: their times see the same machine."""
        n = len(PATHS) * len(folder.plan.tested)
        order = {posture: number for number, posture in enumerate(folder.plan.tested)}
        ordered = sorted(
            jobs,
            key=lambda job: (order[job.posture], PATHS.index(job.path), job.index // n),
        )
        seed = folder.plan.seed
        arguments = ((job, (job, seed)) for job in ordered)
        return self.simulate, arguments

    def values(self, plan: Plan, result: Trial) -> dict[str, Json]:
        """What the line of a trial holds."""
        return {
            "index": result.index,
            "setting": result.setting,
            "path": result.path,
            "posture": result.posture,
            **result.outcome.to_dict(),
            "seconds": result.seconds,
            "versions": versions(),
        }

    def parse(self, plan: Plan, values: Mapping[str, Any]) -> Trial:
        """The trial of a line."""
        try:
            return Trial(
                values["index"],
                values["setting"],
                values["path"],
                values["posture"],
                parse_outcome(values),
                values["seconds"],
            )
        except (KeyError, TypeError) as error:
            raise InvalidInputError(f"not a trial: {values!r:.60} ({error!r})") from error

    def summarise(self, folder: RunFolder, results: Sequence[Trial]) -> dict[str, Any]:
        """Every setting against the finest, and the default on trial."""
        plan = folder.plan
        config = {"suite": plan.protocol.suite, "postures": len(plan.tested), "seed": plan.seed}
        return {
            **compare(results, _chosen(plan)),
            "versions": versions(),
            "config": config,
        }

    def document(
        self,
        folder: RunFolder,
        results: Sequence[Trial],
        summary: Mapping[str, Any],
        command: str,
    ) -> Document:
        """A table, and the default against the finest."""
        return convergence_document(results, summary, command)


def _chosen(plan: Plan) -> list[Setting]:
    names = plan.options.get("settings")
    wanted = names if isinstance(names, list) else []
    return [setting for setting in settings(plan.config) if setting.name in wanted]
