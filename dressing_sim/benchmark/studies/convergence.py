"""The study of convergence: do verdicts come from the arm and the cloth, or from the solver?

The same postures and paths are simulated with coarser and finer meshes, longer and shorter steps,
and other solvers; every verdict is compared with that of the finest, and the metrics of those that
change the solver alone with those of a solver that has converged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

from dressing_sim.benchmark.records import Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.executors import Workers
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
    settings,
    simulate,
)
from dressing_sim.benchmark.studies.study import Calls, Study, Summary
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
class Convergence(Study[Trial, Trial]):
    """Every posture with every path under all settings.

    Attributes:
        simulate: What one job does.
    """

    simulate: Callable[..., Trial] = field(default=simulate)

    result = Trial

    def jobs(self, plan: Plan) -> Sequence[Trial]:
        """The episodes, by setting, path and posture."""
        places = product(_chosen(plan), PATHS, plan.tested)
        return [Trial(i, s.name, path, arm.name) for i, (s, path, arm) in enumerate(places)]

    def calls(
        self, folder: OpenRun, jobs: Sequence[Trial], workers: Workers, progress: Progress
    ) -> Calls[Trial, Trial]:
        """All settings of an episode after one another: their times see the same machine."""
        plan = folder.plan
        n = len(plan.tested)
        configs = {setting.name: setting.config for setting in _chosen(plan)}
        ordered = sorted(jobs, key=lambda job: (job.index % n, job.index // n % len(PATHS)))
        return self.simulate, (
            (job, (job, configs[job.setting], plan.tested[job.index % n], plan.seed))
            for job in ordered
        )

    def summarise(self, folder: RunFolder, results: Sequence[Trial]) -> dict[str, Any]:
        """Every setting against the finest, and the default on trial."""
        plan = folder.plan
        config = {"suite": plan.protocol.suite, "postures": len(plan.tested), "seed": plan.seed}
        return {**compare(results, _chosen(plan)), "versions": versions(), "config": config}

    def document(
        self, folder: RunFolder, results: Sequence[Trial], summary: Summary, command: str
    ) -> Document:
        """A table, and the default against the finest."""
        return convergence_document(results, summary, command)


def _chosen(plan: Plan) -> list[Setting]:
    names = plan.options.get("settings")
    wanted = names if isinstance(names, list) else []
    return [setting for setting in settings(plan.config) if setting.name in wanted]
