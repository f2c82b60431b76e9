"""The report of protocol ``paper-cost``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import (
    Cells,
    Document,
    Paragraph,
    Plot,
    Section,
    Table,
    config_section,
)
from dressing_sim.benchmark.studies.columns import Column, table_of

NOTES = (
    "Cost: mean DTW distance (symmetric2, normalised) of the reproductions to the expert "
    "demonstrations [m]. Intervals: 95 %, percentile bootstrap over runs.",
    "Cost and discarded candidates are means over the runs that accepted an n-th demonstration "
    "within the allowed candidates; their number stands behind. The last column is the mean over "
    "all runs, each with the best cost that it had with at most n.",
    "The paper does not say of which case and method its table is; its figure shows both cases "
    "with RF and RF+noise.",
)

_STYLES = dict(zip(("tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise"), plots.STYLES, strict=False))


def cost_document(summary: Mapping[str, Any], command: str) -> Document:
    """The report; the summary is as from `dressing_sim.benchmark.studies.cost.Cost.summarise`."""
    return Document(
        "Protocol paper-cost: reproduction cost after each accepted demonstration",
        command,
        (Table(cost_table(summary)),),
        (
            Section("What the numbers are", (*map(Paragraph, NOTES), cost_plot(summary))),
            Section("How long a run takes", (Table(seconds_table(summary)),)),
            config_section(summary),
        ),
    )


def cost_table(summary: Mapping[str, Any]) -> Cells:
    """Cost and discarded candidates of each row, after each accepted demonstration."""
    columns: dict[str, Column] = {
        "policy": "{policy}",
        "shown": "{demonstrations}",
        "n": "{n_demonstrations} + {n}",
        "reached": "{n_reached} / {n_runs}",
        "cost": _mean("cost", ".4f"),
        "discarded": _mean("discarded", ".1f"),
        "cost of all runs": _mean("cost_of_all", ".4f"),
        "paper": lambda step: _printed(summary["paper"], step["n"]),
    }
    return table_of(columns, (row | step for row in summary["rows"] for step in row["steps"]))


def _mean(name: str, form: str) -> str:
    """The format of a mean with its interval."""
    return f"{{{name}:{form}}} ({{{name}_ci95[0]:{form}}} - {{{name}_ci95[1]:{form}}})"


def _printed(paper: Mapping[str, Any], n: int) -> str:
    if n >= len(paper["cost"]):
        return "-"
    return f"{paper['cost'][n]:.3f} ({paper['discarded'][n]:g} discarded)"


def seconds_table(summary: Mapping[str, Any]) -> Cells:
    """How long a run takes."""
    columns = {
        "policy": "{policy}",
        "shown": "{demonstrations}",
        "runs": "{n_runs}",
        "seconds a run, median": "{seconds_median:.2f}",
        "paper": "about 20",
    }
    return table_of(columns, summary["rows"])


def cost_plot(summary: Mapping[str, Any]) -> Plot:
    """The cost reduction: a column for each set of demonstrations.

    Above the cost, below per cent of what it was without synthetic demonstrations.
    """
    names = list(dict.fromkeys(row["demonstrations"] for row in summary["rows"]))
    paper = np.array(summary["paper"]["cost"])
    with plots.figure(4.6) as drawn:
        grid = drawn.subplots(2, len(names), sharex=True, sharey="row", squeeze=False)
        for column, name in zip(grid.T, names, strict=True):
            rows = [row for row in summary["rows"] if row["demonstrations"] == name]
            for axes, relative in zip(column, (False, True), strict=True):
                for row in rows:
                    _draw(axes, row, relative)
                scale = 100.0 / paper[0] if relative else 1.0
                axes.plot(
                    paper * scale, color=plots.QUIET, ls="--", marker="s", ms=3, label="paper"
                )
                axes.xaxis.set_major_locator(MaxNLocator(integer=True))
                axes.set_ylim(bottom=0.0)
            column[0].set_title(name)
            column[1].set_xlabel("accepted synthetic demonstrations")
        grid[0, 0].set_ylabel("cost [m]")
        grid[1, 0].set_ylabel("% of the first cost")
        plots.legend_above(drawn, grid[0, 0].get_legend_handles_labels()[0], 4)
        svg = plots.svg_of(drawn)
    ends = [
        f"{row['policy']} on {row['demonstrations']}: {row['steps'][0]['cost_of_all']:.4f} m, "
        f"after {row['steps'][-1]['n']} more {row['steps'][-1]['cost_of_all']:.4f} m"
        for row in summary["rows"]
    ]
    alt = f"Cost against accepted demonstrations. {'. '.join(ends)}"
    caption = "Means over all runs, with bootstrap intervals; grey is the paper's table."
    return Plot("cost", svg, alt, caption, file=True)


def _draw(axes: Axes, row: Mapping[str, Any], relative: bool) -> None:
    steps = row["steps"]
    scale = 100.0 / steps[0]["cost_of_all"] if relative else 1.0
    curve = plots.Curve(
        row["policy"],
        [step["n"] for step in steps],
        [scale * step["cost_of_all"] for step in steps],
        [scale * step["cost_of_all_ci95"][0] for step in steps],
        [scale * step["cost_of_all_ci95"][1] for step in steps],
    )
    plots.draw_curve(axes, curve, _STYLES[row["policy"]])
