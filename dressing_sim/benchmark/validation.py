"""Do verdicts come from the arm and the cloth, or from the solver? A convergence study.

The same postures and paths are simulated with coarser and finer meshes, longer and shorter steps,
and other solvers; every verdict is compared with that of the finest settings, and the figures of
settings that change the solver alone with those of a solver that has converged.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.executors import Workers, completed
from dressing_sim.benchmark.plan import posture_seed
from dressing_sim.benchmark.report.text import verdict
from dressing_sim.benchmark.runner import Progress
from dressing_sim.episode import DEFAULT_PATH_DT, Episode, EpisodeConfig
from dressing_sim.judge import Outcome, Thresholds
from dressing_sim.operator import Operator
from dressing_sim.world.scene import SolverConfig, grip_start

#: The least share of verdicts in which the default settings must agree with the finest.
REQUIRED_AGREEMENT = 0.95

#: How far strain and pull may be from those of a converged solver in nine of ten dressings.
ALLOWED_SOLVER_ERROR = 0.05

#: How far the median episode's strain and pull may be off the finest's, as a share of the limits.
ALLOWED_FIGURE_ERROR = 0.05

#: Settings that all others are compared with, those that every episode has otherwise, and those
#: of a solver that has converged on the same mesh and step.
FINEST, DEFAULT, CONVERGED = "finest", "default", "tolerance 1e-12"

#: Figures that are compared with the finest's.
COMPARED = ("strain", "grip_force", "armscye_s")


@dataclass(frozen=True, slots=True)
class Setting:
    """One row of the table.

    Attributes:
        name: What it is called.
        what: How it differs from the default.
        config: World, robot and rules.
    """

    name: str
    what: str
    config: EpisodeConfig


def settings(default: EpisodeConfig | None = None) -> tuple[Setting, ...]:
    """The default, the finest, and changes between and beyond them.

    One change at a time, but for the coarse mesh with double step, and for CG, which needs other
    iterations than Newton.
    """
    base = default or EpisodeConfig()

    def change(name: str, what: str, solver: Mapping[str, Any], **sleeve: Any) -> Setting:
        world = replace(
            base.world,
            solver=replace(base.world.solver, **solver),
            sleeve=replace(base.world.sleeve, **sleeve),
        )
        return Setting(name, what, replace(base, world=world))

    solver, edge = base.world.solver, base.world.sleeve.edge
    step, tolerance = solver.timestep, solver.tolerance
    return (
        change(
            DEFAULT,
            f"edges {1e3 * edge:g} mm, {1e3 * step:g} ms, {solver.solver}, {tolerance:.0e}",
            {},
        ),
        change(
            FINEST,
            f"edges 24 mm, {500 * step:g} ms, tolerance 1e-12",
            {"timestep": step / 2, "tolerance": 1e-12},
            edge=0.024,
        ),
        change("finer mesh", "edges 29 mm", {}, edge=0.029),
        change("fine mesh", "edges 34 mm", {}, edge=0.034),
        change("coarse mesh", "edges 48 mm", {}, edge=0.048),
        change("half step", f"{500 * step:g} ms", {"timestep": step / 2}),
        change("double step", f"{2000 * step:g} ms", {"timestep": 2 * step}),
        change(
            "coarse mesh and double step",
            f"edges 48 mm, {2000 * step:g} ms",
            {"timestep": 2 * step},
            edge=0.048,
        ),
        change("tolerance 1e-7", "of the solver", {"tolerance": 1e-7}),
        change("tolerance 1e-8", "of the solver", {"tolerance": 1e-8}),
        change(CONVERGED, "of the solver", {"tolerance": 1e-12}),
        change("20 iterations", "at most", {"iterations": 20}),
        change("3 iterations", "at most", {"iterations": 3}),
        change("CG", "conjugate gradients, 500 iterations", {"solver": "CG", "iterations": 500}),
        change("CG with 10 iterations", "at most", {"solver": "CG", "iterations": 10}),
        change("soft contact", "impedance 0.975", {}, contact_impedance=0.975),
        change("hard contact", "impedance 0.995", {}, contact_impedance=0.995),
    )


#: How far below or above the operator's path the two wrong ones are [m].
_LOWER, _HIGHER = 0.06, 0.12

PATHS = ("expert", "straight", "too low", "too high")


def path_of(
    kind: str, posture: Posture, start: NDArray[np.float64], seed: int
) -> tuple[NDArray[np.float64], float]:
    """A path of the study, which does not depend on what is simulated.

    Args:
        kind: One of `PATHS`: the operator's; straight from the start to the operator's end, at
            0.1 m/s; and the operator's, lowered or raised after its first quarter.
        posture: The arm.
        start: Gripper (3,), in the robot's base frame [m].
        seed: Of the operator's variability.

    Returns:
        Positions, shape (n, 3) [m], and the time between two of them [s].
    """
    operator = Operator()
    path = operator.path(posture, start, np.random.default_rng(seed))
    if kind == "straight":
        length = float(np.linalg.norm(path[-1] - start))
        fraction = np.linspace(0.0, 1.0, max(2, round(length / 0.1 / DEFAULT_PATH_DT)))
        return start + fraction[:, None] * (path[-1] - start), DEFAULT_PATH_DT
    shift = {"expert": 0.0, "too low": -_LOWER, "too high": _HIGHER}[kind]
    ramp = np.clip(np.linspace(0.0, 4.0, len(path)), 0.0, 1.0)
    return path + shift * ramp[:, None] * np.array([0.0, 0.0, 1.0]), operator.config.dt


@dataclass(frozen=True, slots=True)
class Trial:
    """One simulated episode of the study.

    Attributes:
        setting: Name of its settings.
        path: One of `PATHS`.
        posture: Name of the posture.
        outcome: The verdict.
        seconds: What it cost [s of CPU].
    """

    setting: str
    path: str
    posture: str
    outcome: Outcome
    seconds: float


def simulate(setting: Setting, kind: str, posture: Posture, seed: int) -> Trial:
    """Simulate one episode of the study."""
    begun = time.process_time()
    episode = Episode(posture, setting.config)
    # Not where the gripper has settled to: that depends, if little, on the settings.
    start = grip_start(posture, setting.config.world.sleeve)
    path, dt = path_of(kind, posture, start, posture_seed(seed, posture))
    outcome = episode.follow(path, dt).outcome
    return Trial(setting.name, kind, posture.name, outcome, time.process_time() - begun)


def validate(
    postures: Sequence[Posture],
    chosen: Sequence[Setting],
    workers: Workers,
    seed: int = 0,
    progress: Progress | None = None,
) -> list[Trial]:
    """Simulate every posture with every path and all settings.

    Returns:
        The trials, by setting, path and posture, in the order given.
    """
    # All settings of an episode after one another, so that their times see the same machine.
    calls = [
        ((setting.name, kind, posture.name), (setting, kind, posture, seed))
        for posture in postures
        for kind in PATHS
        for setting in chosen
    ]
    trials: dict[tuple[str, str, str], Trial] = {}
    for key, future in completed(workers, simulate, calls):
        trials[key] = future.result()
        if progress is not None:
            progress("episodes", len(trials), len(calls), ())
    return [
        trials[setting.name, kind, posture.name]
        for setting in chosen
        for kind in PATHS
        for posture in postures
    ]


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
                "n_void": sum(t.outcome.void is not None for t in own.values()),
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
    pairs = [(own[key].outcome.figures, finest[key].outcome.figures) for key in finest]
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
            abs(own[key].outcome.figures[name] / trial.outcome.figures[name] - 1.0)
            for name in ("strain", "grip_force")
        )
        for key, trial in converged.items()
        if own[key].outcome.success and trial.outcome.success
    ]
    return float(np.percentile(errors, 90.0)) if errors else None


def agreement(one: Outcome, other: Outcome) -> bool:
    """Whether two verdicts are the same; a void episode has none."""
    return one.void is None and other.void is None and one.success == other.success


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
    return {name: outcome.figures[name] for name in names if name in outcome.figures}
