"""What a convergence study says: every setting against the finest, and the default on trial."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.failures import verdict
from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    Setting,
    Trial,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.world.scene import SolverConfig

#: The least share of verdicts in which the default settings must agree with the finest.
REQUIRED_AGREEMENT = 0.95

#: How far strain and pull may be from those of a converged solver in nine of ten dressings.
ALLOWED_SOLVER_ERROR = 0.05

#: How far the median episode's strain and pull may be off the finest's, as a share of the limits.
ALLOWED_FIGURE_ERROR = 0.05

#: Figures that are compared with the finest's.
COMPARED = ("strain", "grip_force", "armscye_s")


def compare(trials: Sequence[Trial], chosen: Sequence[Setting]) -> dict[str, Any]:
    """The table: every setting against the finest.

    Args:
        trials: As from `validate`.
        chosen: The settings of the trials; `DEFAULT`, `FINEST` and `CONVERGED` are among them.

    Returns:
        ``{"rows": [...], "differing": [...], "agreement": ..., "required": ...,
        "figure_error": ..., "allowed_figure_error": ..., "solver_error": ...,
        "allowed_solver_error": ..., "passed": ...}``; shares from 0 to 1, times relative to the
        default's. Differences of figures are medians of absolute differences over the episodes,
        the figures' error is the larger of those of strain and pull as a share of its limit; None
        if all are void. An episode that is void in either counts as disagreement. The solver's
        error, see `_solver_error`, is None where mesh, step or contacts differ from the default's,
        or where no episode succeeds with both; the default passes only with one that is known.
    """
    by_setting = {
        setting.name: {(t.path, t.posture): t for t in trials if t.setting == setting.name}
        for setting in chosen
    }
    finest = by_setting[FINEST]
    physics = {setting.name: _but_solver(setting.config) for setting in chosen}
    converged = by_setting[CONVERGED]
    cost = np.median([t.seconds for t in by_setting[DEFAULT].values()])
    rows: list[dict[str, Any]] = []
    differing: list[dict[str, Any]] = []
    for setting in chosen:
        own = by_setting[setting.name]
        agree = [agreement(own[key].outcome, finest[key].outcome) for key in finest]
        differences = {name: _median_difference(name, own, finest) for name in COMPARED}
        rows.append(
            {
                "setting": setting.name,
                "what": setting.what,
                "n_episodes": len(own),
                "n_success": sum(t.outcome.success for t in own.values()),
                "n_void": sum(t.outcome.invalid is not None for t in own.values()),
                "n_agree": sum(agree),
                "agreement": float(np.mean(agree)),
                "same_reasons": float(
                    np.mean([own[k].outcome.reasons == finest[k].outcome.reasons for k in finest])
                ),
                **{f"difference_{name}": value for name, value in differences.items()},
                "figure_error": _figure_error(differences, setting.config.thresholds),
                "solver_error": _solver_error(own, converged)
                if physics[setting.name] == physics[CONVERGED]
                else None,
                "relative_cost": float(np.median([t.seconds for t in own.values()]) / cost),
            }
        )
        if setting.name != FINEST:
            differing += [
                _difference(own[key], finest[key])
                for key, same in zip(finest, agree, strict=True)
                if not same
            ]
    default = next(row for row in rows if row["setting"] == DEFAULT)
    errors = (
        (default["figure_error"], ALLOWED_FIGURE_ERROR),
        (default["solver_error"], ALLOWED_SOLVER_ERROR),
    )
    return {
        "agreement": default["agreement"],
        "required": REQUIRED_AGREEMENT,
        "figure_error": default["figure_error"],
        "allowed_figure_error": ALLOWED_FIGURE_ERROR,
        "solver_error": default["solver_error"],
        "allowed_solver_error": ALLOWED_SOLVER_ERROR,
        "passed": default["agreement"] >= REQUIRED_AGREEMENT
        and all(error is not None and error <= allowed for error, allowed in errors),
        "rows": rows,
        "differing": differing,
    }


def _median_difference(
    name: str, own: Mapping[tuple[str, str], Trial], finest: Mapping[tuple[str, str], Trial]
) -> float | None:
    """The median absolute difference of a figure; None if no episode has it with both settings."""
    pairs = [(own[key].outcome.metrics, finest[key].outcome.metrics) for key in finest]
    found = [abs(a[name] - b[name]) for a, b in pairs if name in a and name in b]
    return float(np.median(found)) if found else None


def _figure_error(differences: Mapping[str, float | None], limits: Thresholds) -> float | None:
    """The larger of strain's and pull's differences, as a share of its limit."""
    strain, pull = differences["strain"], differences["grip_force"]
    if strain is None or pull is None:
        return None
    return max(strain / limits.strain, pull / limits.grip_force)


def _but_solver(config: EpisodeConfig) -> EpisodeConfig:
    """The settings without how each step's equations are solved."""
    usual = SolverConfig()
    solver = replace(
        config.world.solver,
        solver=usual.solver,
        iterations=usual.iterations,
        tolerance=usual.tolerance,
    )
    return replace(config, world=replace(config.world, solver=solver))


def _solver_error(
    own: Mapping[tuple[str, str], Trial], converged: Mapping[tuple[str, str], Trial]
) -> float | None:
    """What nine of ten dressings stay within: the larger relative error of strain and pull.

    Only episodes that succeed with both settings count; those of others end at a moment that is
    decided by a limit. None if there are no such episodes.
    """
    errors = [
        max(
            abs(own[key].outcome.metrics[name] / trial.outcome.metrics[name] - 1.0)
            for name in ("strain", "grip_force")
        )
        for key, trial in converged.items()
        if own[key].outcome.success and trial.outcome.success
    ]
    return float(np.percentile(errors, 90.0)) if errors else None


def agreement(one: Outcome, other: Outcome) -> bool:
    """Whether two verdicts are the same; a void episode has none."""
    return one.invalid is None and other.invalid is None and one.success == other.success


def _difference(own: Trial, finest: Trial) -> dict[str, Any]:
    return {
        "setting": own.setting,
        "path": own.path,
        "posture": own.posture,
        "verdict": verdict(own.outcome),
        "finest": verdict(finest.outcome),
        "margins": _margins(own.outcome),
        "finest_margins": _margins(finest.outcome),
    }


def _margins(outcome: Outcome) -> dict[str, float]:
    """Figures that thresholds are set on."""
    names = ("strain", "grip_force", "armscye_s", "gripper_distance", "hit_force")
    return {name: outcome.metrics[name] for name in names if name in outcome.metrics}
