"""The study of convergence: do verdicts come from the arm and the cloth, or from the solver?

The same postures and paths are simulated with coarser and finer meshes, longer and shorter steps,
and other solvers; every verdict is compared with that of the finest, and the metrics of those that
change the solver alone with those of a solver that has converged.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.records import Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.plan import Plan, dressing_person
from dressing_sim.benchmark.run.progress import Progress
from dressing_sim.benchmark.run.store import OpenRun, RunFolder
from dressing_sim.benchmark.studies.agreement import REQUIRED_AGREEMENT, first_postures
from dressing_sim.benchmark.studies.convergence_document import convergence_document
from dressing_sim.benchmark.studies.convergence_ladders import refined
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
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.outcome import Outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.provenance import versions
from dressing_sim.suites.wardrobe import world_with
from dressing_sim.world.scene import SolverConfig

#: How far strain and pull may be from those of a converged solver in nine of ten dressings.
ALLOWED_SOLVER_ERROR = 0.05

#: How far the median episode's strain and pull may be off the finest's, as a share of the limits.
ALLOWED_METRIC_ERROR = 0.05

#: Metrics that are compared with the finest's.
COMPARED = ("strain", "grip_force", "armscye_s")

#: Metrics that thresholds are set on.
MARGINS = (*COMPARED, "gripper_distance", "hit_force")


def convergence_plan(
    suite: str = "val50",
    postures: int | None = None,
    only: Sequence[str] | None = None,
    seed: int = 0,
    garment: str | None = None,
    person: str | None = None,
) -> Plan:
    """The plan of the study.

    Args:
        suite: Postures.
        postures: How many of them, from the first; if None all, and of `val50` 15.
        only: Settings to try besides the default, the finest and a converged solver; all if None.
        seed: Of the operator's variability.
        garment: What is put on: a name or a TOML file, see `load_garment`.
        person: Whose arm it is: a name or a TOML file, see `load_person`.

    Raises:
        InvalidInputError: There is no such suite, setting, garment or person, or fewer postures.
    """
    names = [setting.name for setting in settings()]
    unknown = sorted(set(only or ()) - set(names))
    if unknown:
        raise InvalidInputError(
            f"unknown setting {unknown[0]!r}; valid is one of {', '.join(names)}"
        )
    wanted = {DEFAULT, FINEST, CONVERGED, *(names if only is None else only)}
    plan = Plan(
        Protocol("convergence", suite, (), study="convergence"),
        seed,
        world_with(garment),
        first_postures(suite, postures),
        {},
        {"settings": [name for name in names if name in wanted]},
    )
    return dressing_person(plan, person)


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
        if plan.config != EpisodeConfig():
            config["episode"] = to_plain(plan.config)
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


def compare(trials: Sequence[Trial], chosen: Sequence[Setting]) -> dict[str, Any]:
    """The table: every setting against the finest.

    Args:
        trials: All those of each setting, in the order of the study's jobs.
        chosen: The settings of the trials; `DEFAULT`, `FINEST` and `CONVERGED` are among them.

    Returns:
        ``{"agreement", "required", "figure_error", "allowed_figure_error", "solver_error",
        "allowed_solver_error", "passed", "rows", "differing", "refinement"}``, with shares from 0
        to 1. An episode that is void in either counts as disagreement. Differences of metrics are
        medians of absolute differences; ``figure_error`` is the larger of those of strain and pull
        as a share of its limit. ``solver_error``, see `_solver_error`, is None where mesh, step or
        contacts differ from the default's. None is what no episode tells: then nothing passes.
    """
    by_setting = {s.name: [t for t in trials if t.setting == s.name] for s in chosen}
    finest, converged = by_setting[FINEST], by_setting[CONVERGED]
    physics = {setting.name: _but_solver(setting.config) for setting in chosen}
    cost = {name: np.median([t.seconds for t in own]) for name, own in by_setting.items()}
    rows = {}
    for setting in chosen:
        name, own = setting.name, by_setting[setting.name]
        alike = physics[name] == physics[CONVERGED]
        rows[name] = {
            **_against_finest(setting, own, finest),
            "solver_error": _solver_error(own, converged) if alike else None,
            "relative_cost": float(cost[name] / cost[DEFAULT]),
        }
    agreed, metric_error, solver_error = (
        rows[DEFAULT][name] for name in ("agreement", "figure_error", "solver_error")
    )
    return {
        "agreement": agreed,
        "required": REQUIRED_AGREEMENT,
        "figure_error": metric_error,
        "allowed_figure_error": ALLOWED_METRIC_ERROR,
        "solver_error": solver_error,
        "allowed_solver_error": ALLOWED_SOLVER_ERROR,
        "passed": agreed >= REQUIRED_AGREEMENT
        and _at_most(metric_error, ALLOWED_METRIC_ERROR)
        and _at_most(solver_error, ALLOWED_SOLVER_ERROR),
        "rows": list(rows.values()),
        "differing": [
            _difference(a, b)
            for name, own in by_setting.items()
            for a, b in zip(own, finest, strict=True)
            if name != FINEST and not agreement(a.outcome, b.outcome)
        ],
        "refinement": refined(trials, chosen),
    }


def _at_most(error: float | None, allowed: float) -> bool:
    return error is not None and error <= allowed


def _against_finest(
    setting: Setting, own: Sequence[Trial], finest: Sequence[Trial]
) -> dict[str, Any]:
    """What of a row is about a setting's trials next to the finest's of the same episodes."""
    pairs = [(a.outcome, b.outcome) for a, b in zip(own, finest, strict=True)]
    agree = [agreement(a, b) for a, b in pairs]
    off = np.ma.masked_invalid(np.abs(_metrics(own) - _metrics(finest)))
    differences = np.ma.median(off, axis=0)  # masked, and None in a list, where nothing is known
    limits = setting.config.thresholds
    shares = (differences[:2] / (limits.strain, limits.grip_force)).tolist()
    return {
        "setting": setting.name,
        "what": setting.what,
        "n_episodes": len(own),
        "n_success": sum(a.success for a, _ in pairs),
        "n_void": sum(a.invalid is not None for a, _ in pairs),
        "n_agree": sum(agree),
        "agreement": float(np.mean(agree)),
        "same_reasons": float(np.mean([a.reasons == b.reasons for a, b in pairs])),
        **{f"difference_{name}": d for name, d in zip(COMPARED, differences.tolist(), strict=True)},
        "figure_error": None if None in shares else max(shares),
    }


def _metrics(trials: Sequence[Trial]) -> NDArray[np.float64]:
    """`COMPARED` of trials, shape (n, 3); NaN where not measured."""
    return np.array([[t.outcome.metrics.get(name, np.nan) for name in COMPARED] for t in trials])


def _but_solver(config: EpisodeConfig) -> EpisodeConfig:
    """The config without how each step's equations are solved."""
    names = ("solver", "iterations", "tolerance")
    usual = {name: getattr(SolverConfig(), name) for name in names}
    solver = replace(config.world.solver, **usual)
    return replace(config, world=replace(config.world, solver=solver))


def _solver_error(own: Sequence[Trial], converged: Sequence[Trial]) -> float | None:
    """What nine of ten dressings stay within: the larger relative error of strain and pull.

    Only episodes that succeed with both settings count; those of others end at a moment that is
    decided by a limit. None if there are no such episodes.
    """
    pairs = zip(own, converged, strict=True)
    both = [a.outcome.success and b.outcome.success for a, b in pairs]
    if not any(both):
        return None
    errors = np.abs(_metrics(own)[both, :2] / _metrics(converged)[both, :2] - 1.0).max(axis=1)
    return float(np.percentile(errors, 90.0))


def agreement(one: Outcome, other: Outcome) -> bool:
    """Whether two verdicts are the same; a void episode has none."""
    return one.invalid is None and other.invalid is None and one.success == other.success


def _difference(own: Trial, finest: Trial) -> dict[str, Any]:
    margins, finest_margins = (
        {name: t.outcome.metrics[name] for name in MARGINS if name in t.outcome.metrics}
        for t in (own, finest)
    )
    return {
        "setting": own.setting,
        "path": own.path,
        "posture": own.posture,
        "verdict": own.outcome.verdict,
        "finest": finest.outcome.verdict,
        "margins": margins,
        "finest_margins": finest_margins,
    }
