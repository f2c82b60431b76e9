"""Draws the README's plot: success rates with intervals, of the tables in docs/results.

python scripts/draw_success.py
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.studies.success_plots import interval
from dressing_sim.files import write_file
from dressing_sim.policies.hyperparameters import TUNED

DOCS = Path(__file__).resolve().parent.parent / "docs"

#: Panels: a title, and the runs whose rows stand in it.
PANELS = {
    "200 arms, elbow bent by 5 to 70 deg": ("transport", "full", "fair", "fair-noise"),
    "50 arms, elbow bent by 60 to 90 deg": ("transport-hard", "hard_elbow", "fair-hard"),
}
SHOWN = {
    "case_a": "two demonstrations, A",
    "case_b": "two demonstrations, B",
    "baseline7": "seven demonstrations",
    None: "sees the elbow",
}

Row = Mapping[str, Any]


def rows_of(runs: tuple[str, ...]) -> dict[str, list[Row]]:
    """Rows of runs by what they are called, those of the first run first: as published, tuned."""
    found: dict[str, list[Row]] = {}
    for run in runs:
        summary = json.loads((DOCS / "results" / f"{run}.json").read_text(encoding="utf-8"))
        for row in sorted(summary["rows"], key=lambda row: row["demonstrations"] is not None):
            name = "operator" if row["demonstrations"] is None else Entry.of(row).untuned.policy
            found.setdefault(f"{name}, {SHOWN[row['demonstrations']]}", []).append(row)
    return found


def draw() -> str:
    """The plot as SVG, a panel a suite, a row a policy and what it was shown."""
    panels = {title: rows_of(runs) for title, runs in PANELS.items()}
    names = list(dict.fromkeys(name for rows in panels.values() for name in rows))
    names.sort(key=lambda name: not name.startswith("operator"))
    with plots.figure(0.75 + 0.17 * len(names)) as drawn:
        grid = plots.panels(drawn, len(panels), len(panels), sharex=True, sharey=True)
        for axes, (title, rows) in zip(grid, panels.items(), strict=True):
            axes.set_title(title)
            for place, name in enumerate(names):
                ours, muted = name.startswith("transport"), name.startswith("operator")
                colour = plots.ACCENT if ours else plots.QUIET if muted else plots.CONTRAST
                for row in rows.get(name, ()):
                    tuned = row["policy"].endswith(TUNED)
                    at = place + (0.22 if tuned else -0.12 if len(rows[name]) > 1 else 0.0)
                    axes.hlines(at, *interval(row), color=colour, lw=3.0, alpha=0.3)
                    filled = {} if tuned or ours or muted else {"mfc": "white"}
                    axes.plot(row["pc_success"], at, "o", color=colour, ms=4.0, **filled)
            axes.set(xlim=(-3.0, 103.0), ylim=(len(names) - 0.4, -0.6))
            axes.set_yticks(range(len(names)), names)
            axes.grid(axis="x")
        drawn.supxlabel("arms dressed [%], 95 % intervals", fontsize=7.5, color=plots.QUIET)
        return plots.svg_of(drawn)


if __name__ == "__main__":
    write_file(DOCS / "success.svg", draw())
