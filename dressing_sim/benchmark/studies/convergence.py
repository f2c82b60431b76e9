"""Do verdicts come from the arm and the cloth, or from the solver? A convergence study.

The same postures and paths are simulated with coarser and finer meshes, longer and shorter steps,
and other solvers; every verdict is compared with that of the finest settings, and the figures of
settings that change the solver alone with those of a solver that has converged.
"""

from __future__ import annotations

import json
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.run.executors import Workers, completed
from dressing_sim.benchmark.run.plan import posture_seed
from dressing_sim.benchmark.run.runner import Progress
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import DEFAULT_PATH_DT, follow
from dressing_sim.episode.rules import Outcome
from dressing_sim.files import write_text
from dressing_sim.world.scene import grip_start

#: Settings that all others are compared with, those that every episode has otherwise, and those
#: of a solver that has converged on the same mesh and step.
FINEST, DEFAULT, CONVERGED = "finest", "default", "tolerance 1e-12"


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
    dressing = Dressing(posture, setting.config)
    # Not where the gripper has settled to: that depends, if little, on the settings.
    start = grip_start(posture, setting.config.world.sleeve)
    path, dt = path_of(kind, posture, start, posture_seed(seed, posture))
    outcome = follow(dressing, path, dt).outcome
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


def write_trials(folder: Path, trials: Sequence[Trial]) -> None:
    """Write ``episodes.jsonl``, a line a trial."""
    lines = (
        json.dumps(
            {
                "setting": t.setting,
                "path": t.path,
                "posture": t.posture,
                **t.outcome.to_dict(),
                "seconds": t.seconds,
            }
        )
        for t in trials
    )
    write_text(folder / "episodes.jsonl", "".join(line + "\n" for line in lines))
