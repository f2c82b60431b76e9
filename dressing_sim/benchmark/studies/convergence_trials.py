"""One episode of the study of convergence: its setting of the simulation, its path, its verdict."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.run.plan import posture_seed
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.record import DEFAULT_PATH_DT, record
from dressing_sim.path import Path
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
    iterations than Newton. Where the step changes, a contact heals in as many steps as before.
    """
    base = default or EpisodeConfig()
    solver, edge = base.world.solver, base.world.sleeve.edge
    step, heals = solver.timestep, base.world.sleeve.contact_time
    usual = f"edges {1e3 * edge:g} mm, {1e3 * step:g} ms, {solver.solver}, {solver.tolerance:.0e}"
    cg = {"solver": "CG", "iterations": 500}

    def change(name: str, what: str, solver: Mapping[str, Any], **sleeve: Any) -> Setting:
        world = replace(
            base.world,
            solver=replace(base.world.solver, **solver),
            sleeve=replace(base.world.sleeve, **sleeve),
        )
        return Setting(name, what, replace(base, world=world))

    def stepped(name: str, what: str, factor: float, tolerance: float, edge: float) -> Setting:
        told = f"{what}{1e3 * factor * step:g} ms"
        faster = {"timestep": factor * step, "tolerance": tolerance}
        return change(name, told, faster, contact_time=factor * heals, edge=edge)

    def commanded(name: str, factor: float) -> Setting:
        tracking = replace(base.tracking, dt=factor * base.tracking.dt)
        return Setting(name, f"{1e3 * tracking.dt:g} ms", replace(base, tracking=tracking))

    tolerance = solver.tolerance
    return (
        change(DEFAULT, usual, {}),
        stepped(FINEST, "edges 20 mm, tolerance 1e-12, ", 0.5, 1e-12, 0.020),
        change("fine mesh", "edges 20 mm", {}, edge=0.020),
        change("finer mesh", "edges 24 mm", {}, edge=0.024),
        change("longer edges", "edges 32 mm", {}, edge=0.032),
        change("coarse mesh", "edges 40 mm", {}, edge=0.040),
        stepped("half step", "", 0.5, tolerance, edge),
        stepped("double step", "", 2.0, tolerance, edge),
        stepped("quarter step", "", 0.25, tolerance, edge),
        stepped("coarse mesh and double step", "edges 40 mm, ", 2.0, tolerance, 0.040),
        change("tolerance 1e-7", "of the solver", {"tolerance": 1e-7}),
        change("tolerance 1e-8", "of the solver", {"tolerance": 1e-8}),
        change(CONVERGED, "of the solver", {"tolerance": 1e-12}),
        change("20 iterations", "at most", {"iterations": 20}),
        change("3 iterations", "at most", {"iterations": 3}),
        change("CG", "conjugate gradients, 500 iterations", cg),
        change("CG with 10 iterations", "at most", cg | {"iterations": 10}),
        change("thin layer", "contacts harden over 3 mm", {}, contact_depth=0.003),
        change("thick layer", "contacts harden over 5 mm", {}, contact_depth=0.005),
        change("soft contact", "impedance 0.999", {}, contact_impedance=0.999),
        change("hard contact", "impedance 0.99999", {}, contact_impedance=0.99999),
        change("soft friction", "impratio 10", {"impratio": 10.0}),
        change("hard friction", "impratio 1000", {"impratio": 1000.0}),
        commanded("half control step", 0.5),
        commanded("double control step", 2.0),
        change("bending", "of the cloth", {}, bending=True),
    )


#: Paths of the study, with how far each is lifted off the operator's [m]; the straight one is not.
_LIFTS = {"expert": 0.0, "straight": 0.0, "too low": -0.06, "too high": 0.12}

PATHS = tuple(_LIFTS)


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
    ramp = np.clip(np.linspace(0.0, 4.0, len(path)), 0.0, 1.0)
    return path + _LIFTS[kind] * ramp[:, None] * np.array([0.0, 0.0, 1.0]), operator.config.dt


@dataclass(frozen=True, slots=True)
class Trial:
    """One episode of the study, to be simulated or simulated.

    Attributes:
        index: Its place: by setting, path and posture.
        setting: Name of its setting.
        path: One of `PATHS`.
        posture: Name of the posture.
        outcome: The verdict.
        seconds: What it cost [s of CPU].
    """

    index: int
    setting: str
    path: str
    posture: str
    outcome: Outcome = field(default_factory=lambda: Outcome(False))
    seconds: float = 0.0


def simulate(job: Trial, config: EpisodeConfig, posture: Posture, seed: int) -> Trial:
    """Simulate one episode of the study; `config` is its setting's."""
    begun = time.process_time()
    # Not where the gripper has settled to: that depends, if little, on the setting.
    start = grip_start(posture, config.world.sleeve)
    path, dt = path_of(job.path, posture, start, posture_seed(seed, posture))
    outcome = record(Path(path, dt), posture, 0, config).outcome
    return replace(job, outcome=outcome, seconds=time.process_time() - begun)
