"""What a convergence study says: every setting against the finest, and the default on trial."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.analysis.failures import verdict
from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    Setting,
    Trial,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.rules import Outcome, Thresholds
from dressing_sim.world.scene import SolverConfig

#: The least share of verdicts in which the default settings must agree with the finest.
REQUIRED_AGREEMENT = 0.95

#: How far strain and pull may be from those of a converged solver in nine of ten dressings.
ALLOWED_SOLVER_ERROR = 0.05

#: How far the median episode's strain and pull may be off the finest's, as a share of the limits.
ALLOWED_METRIC_ERROR = 0.05

#: Metrics that are compared with the finest's.
COMPARED = ("strain", "grip_force", "armscye_s")

#: Metrics that thresholds are set on.
_MARGINS = (*COMPARED, "gripper_distance", "hit_force")


def compare(trials: Sequence[Trial], chosen: Sequence[Setting]) -> dict[str, Any]:
    """The table: every setting against the finest.

    Args:
        trials: All those of each setting, in the order of the study's jobs.
        chosen: The settings of the trials; `DEFAULT`, `FINEST` and `CONVERGED` are among them.

    Returns:
        ``{"rows": [...], "differing": [...], "agreement": ..., "required": ...,
        "figure_error": ..., "allowed_figure_error": ..., "solver_error": ...,
        "allowed_solver_error": ..., "passed": ...}``; shares from 0 to 1, times relative to the
        default's. Differences of metrics are medians of absolute differences over the episodes,
        ``figure_error`` is the larger of those of strain and pull as a share of its limit; None
        if all are void. An episode that is void in either counts as disagreement. The solver's
        error, see `_solver_error`, is None where mesh, step or contacts differ from the default's,
        or where no episode succeeds with both; the default passes only with one that is known.
    """
    by_setting = {s.name: [t for t in trials if t.setting == s.name] for s in chosen}
    finest, converged = by_setting[FINEST], by_setting[CONVERGED]
    physics = {setting.name: _but_solver(setting.config) for setting in chosen}
    cost = np.median([t.seconds for t in by_setting[DEFAULT]])
    rows = {}
    for setting in chosen:
        own = by_setting[setting.name]
        same_physics = physics[setting.name] == physics[CONVERGED]
        rows[setting.name] = {
            **_against_finest(setting, own, finest),
            "solver_error": _solver_error(own, converged) if same_physics else None,
            "relative_cost": float(np.median([t.seconds for t in own]) / cost),
        }
    default = rows[DEFAULT]
    errors = (
        (default["figure_error"], ALLOWED_METRIC_ERROR),
        (default["solver_error"], ALLOWED_SOLVER_ERROR),
    )
    return {
        "agreement": default["agreement"],
        "required": REQUIRED_AGREEMENT,
        "figure_error": default["figure_error"],
        "allowed_figure_error": ALLOWED_METRIC_ERROR,
        "solver_error": default["solver_error"],
        "allowed_solver_error": ALLOWED_SOLVER_ERROR,
        "passed": default["agreement"] >= REQUIRED_AGREEMENT
        and all(error is not None and error <= allowed for error, allowed in errors),
        "rows": list(rows.values()),
        "differing": [
            _difference(a, b)
            for name, own in by_setting.items()
            if name != FINEST
            for a, b in zip(own, finest, strict=True)
            if not agreement(a.outcome, b.outcome)
        ],
    }


def _against_finest(
    setting: Setting, own: Sequence[Trial], finest: Sequence[Trial]
) -> dict[str, Any]:
    """What of a row is about a setting's trials next to the finest's of the same episodes."""
    pairs = [(a.outcome, b.outcome) for a, b in zip(own, finest, strict=True)]
    agree = [agreement(a, b) for a, b in pairs]
    differences = [_median(column) for column in np.abs(_metrics(own) - _metrics(finest)).T]
    return {
        "setting": setting.name,
        "what": setting.what,
        "n_episodes": len(own),
        "n_success": sum(a.success for a, _ in pairs),
        "n_void": sum(a.invalid is not None for a, _ in pairs),
        "n_agree": sum(agree),
        "agreement": float(np.mean(agree)),
        "same_reasons": float(np.mean([a.reasons == b.reasons for a, b in pairs])),
        **{f"difference_{name}": d for name, d in zip(COMPARED, differences, strict=True)},
        "figure_error": _metric_error(differences, setting.config.thresholds),
    }


def _metric_error(differences: Sequence[float | None], limits: Thresholds) -> float | None:
    """The larger of strain's and pull's differences, as a share of its limit."""
    strain, pull, _ = differences
    if strain is None or pull is None:
        return None
    return max(strain / limits.strain, pull / limits.grip_force)


def _metrics(trials: Sequence[Trial]) -> NDArray[np.float64]:
    """`COMPARED` of trials, shape (n, 3); NaN where not measured."""
    return np.array([[t.outcome.metrics.get(name, np.nan) for name in COMPARED] for t in trials])


def _median(values: NDArray[np.float64]) -> float | None:
    """The median of what is known; None if nothing is."""
    known = values[~np.isnan(values)]
    return float(np.median(known)) if known.size else None


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
        {name: t.outcome.metrics[name] for name in _MARGINS if name in t.outcome.metrics}
        for t in (own, finest)
    )
    return {
        "setting": own.setting,
        "path": own.path,
        "posture": own.posture,
        "verdict": verdict(own.outcome),
        "finest": verdict(finest.outcome),
        "margins": margins,
        "finest_margins": finest_margins,
    }
