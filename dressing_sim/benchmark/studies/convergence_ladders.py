"""Settings that refine one thing in three levels, and what the metrics of dressings tend to."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.refinement import refine
from dressing_sim.benchmark.report.document import Cells
from dressing_sim.benchmark.studies.columns import Column, table_of
from dressing_sim.benchmark.studies.convergence_trials import DEFAULT, Setting, Trial
from dressing_sim.episode.config import EpisodeConfig

#: Metrics that are extrapolated, with their units.
METRICS: Mapping[str, str] = {"grip_force": "N", "strain": "-", "armscye_s": "-"}


@dataclass(frozen=True, slots=True)
class Ladder:
    """One thing that is refined.

    Attributes:
        what: What it is, and its unit.
        levels: Names of three settings, the finest first.
        size: How coarse a setting is in it; zero is the limit.
    """

    what: str
    levels: tuple[str, str, str]
    size: Callable[[EpisodeConfig], float]


LADDERS = (
    Ladder(
        "edges [m]", ("fine mesh", DEFAULT, "coarse mesh"), lambda config: config.world.sleeve.edge
    ),
    Ladder(
        "physics step [s]",
        ("quarter step", "half step", DEFAULT),
        lambda config: config.world.solver.timestep,
    ),
    Ladder(
        "control step [s]",
        ("half control step", DEFAULT, "double control step"),
        lambda config: config.tracking.dt,
    ),
    Ladder(
        "solver's tolerance",
        (DEFAULT, "tolerance 1e-8", "tolerance 1e-7"),
        lambda config: config.world.solver.tolerance,
    ),
    Ladder(
        "layer of contacts [m]",
        ("thin layer", DEFAULT, "thick layer"),
        lambda config: config.world.sleeve.contact_depth,
    ),
    Ladder(
        "give of contacts",
        ("hard contact", DEFAULT, "soft contact"),
        lambda config: 1.0 - config.world.sleeve.contact_impedance,
    ),
    Ladder(
        "give of friction",
        ("hard friction", DEFAULT, "soft friction"),
        lambda config: 1.0 / config.world.solver.impratio,
    ),
)

_COLUMNS: Mapping[str, Column] = {
    "refined": "{ladder}",
    "metric": lambda row: f"{row['metric']} [{METRICS[row['metric']]}]",
    "dressings": "{n_episodes}",
    "sizes": lambda row: ", ".join(f"{size:.3g}" for size in row["sizes"]),
    "values": lambda row: ", ".join(f"{value:.4g}" for value in row["values"]),
    "order": "{order:.1f}",
    "extrapolated": "{limit:.4g}",
    "index of the finest": "{index:.1%}",
    "default off": "{default_error:.1%}",
}


def refined(trials: Sequence[Trial], chosen: Sequence[Setting]) -> list[dict[str, Any]]:
    """Every ladder whose settings were tried, and every metric.

    Returns:
        ``{"ladder", "metric", "n_episodes", "sizes", "values", "order", "limit", "index",
        "default_error"}``: values are means over the episodes that succeed on all three levels
        (others end at a limit); see `dressing_sim.benchmark.analysis.refinement.Refinement`;
        ``default_error`` is how far the default's is from the limit, as a share. Ladders without
        such episodes are left out.
    """
    configs = {setting.name: setting.config for setting in chosen}
    found = []
    for ladder in LADDERS:
        if not set(ladder.levels) <= set(configs):
            continue
        levels = [[t.outcome for t in trials if t.setting == name] for name in ladder.levels]
        both = [one for one in zip(*levels, strict=True) if all(o.success for o in one)]
        sizes = [ladder.size(configs[name]) for name in ladder.levels]
        for metric in METRICS if both else ():
            values = np.array([[o.metrics[metric] for o in one] for one in both]).mean(axis=0)
            told = refine(sizes, values.tolist())
            default = float(values[ladder.levels.index(DEFAULT)])
            found.append(
                {
                    "ladder": ladder.what,
                    "metric": metric,
                    "n_episodes": len(both),
                    "sizes": sizes,
                    "values": values.tolist(),
                    "order": told.order,
                    "limit": told.limit,
                    "index": told.index,
                    "default_error": abs(default / told.limit - 1.0) if told.limit else None,
                }
            )
    return found


def refinement_table(summary: Mapping[str, Any]) -> Cells:
    """Orders, limits and indices of grid convergence."""
    return table_of(_COLUMNS, summary["refinement"])
