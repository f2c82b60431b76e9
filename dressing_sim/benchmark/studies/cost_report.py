"""What protocol ``paper-cost`` leaves behind: summary.json, report.md, report.html, cost.svg."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from dressing_sim.benchmark.report import markdown_table
from dressing_sim.benchmark.run.store import SUMMARY
from dressing_sim.files import write_text

TITLE = "Protocol paper-cost: reproduction cost after each accepted demonstration"

NOTES = (
    "Cost: mean DTW distance (symmetric2, normalised) of the reproductions to the expert "
    "demonstrations [m]. Intervals: 95 %, percentile bootstrap over runs.",
    "Cost and discarded candidates are means over the runs that accepted an n-th demonstration "
    "within the allowed candidates; their number stands behind. The last column is the mean over "
    "all runs, each with the best cost that it had with at most n.",
    "The paper does not say of which case and method its table is; its figure shows both cases "
    "with RF and RF+noise.",
)

_COLOURS = {"tp-gmm-noise": "black", "tp-gmm-rf": "#2a9d3a", "tp-gmm-rf-noise": "#17a5b8"}
_STYLE = "body{font:15px sans-serif;margin:2em}td,th{padding:.2em .8em;text-align:left}"


def cost_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """The summary as cells of text, the first row the heading."""
    return [
        ["policy", "shown", "n", "reached", "cost", "discarded", "cost of all runs", "paper"],
        *(
            [
                row["policy"],
                row["demonstrations"],
                f"{row['n_demonstrations']} + {step['n']}",
                f"{step['n_reached']} / {row['n_runs']}",
                _number(step, "cost", ".4f"),
                _number(step, "discarded", ".1f"),
                _number(step, "cost_of_all", ".4f"),
                _printed(summary["paper"], step["n"]),
            ]
            for row in summary["rows"]
            for step in row["steps"]
        ),
    ]


def seconds_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """How long a run takes, as cells of text, the first row the heading."""
    return [
        ["policy", "shown", "runs", "seconds a run, median", "paper"],
        *(
            [
                row["policy"],
                row["demonstrations"],
                str(row["n_runs"]),
                f"{row['seconds_median']:.2f}",
                "about 20",
            ]
            for row in summary["rows"]
        ),
    ]


def _number(step: Mapping[str, Any], name: str, form: str) -> str:
    if step[name] is None:
        return "-"
    low, high = step[f"{name}_ci95"]
    return f"{step[name]:{form}} ({low:{form}} - {high:{form}})"


def _printed(paper: Mapping[str, Any], n: int) -> str:
    if n >= len(paper["cost"]):
        return "-"
    return f"{paper['cost'][n]:.3f} ({paper['discarded'][n]:g} discarded)"


def cost_figure(summary: Mapping[str, Any]) -> str:
    """The cost reduction as SVG: a column for each set of demonstrations.

    Above the cost, below per cent of what it was without synthetic demonstrations. Curves are means
    over all runs, with bootstrap intervals; grey is the paper's table.
    """
    names = list(dict.fromkeys(row["demonstrations"] for row in summary["rows"]))
    figure = Figure(figsize=(1.0 + 3.4 * len(names), 5.2), layout="constrained")
    panels = figure.subplots(2, len(names), sharex=True, sharey="row", squeeze=False)
    paper = np.array(summary["paper"]["cost"])
    for column, name in enumerate(names):
        rows = [row for row in summary["rows"] if row["demonstrations"] == name]
        for panel, relative in zip(panels[:, column], (False, True), strict=True):
            for row in rows:
                _draw(panel, row, relative)
            scale = 100.0 / paper[0] if relative else 1.0
            panel.plot(paper * scale, color="0.6", ls="--", marker="s", ms=3, label="paper")
            panel.xaxis.set_major_locator(MaxNLocator(integer=True))
            panel.tick_params(labelsize=7)
            panel.set_ylim(bottom=0.0)
        panels[0, column].set_title(name, fontsize=9)
        panels[1, column].set_xlabel("accepted synthetic demonstrations", fontsize=8)
    panels[0, 0].set_ylabel("cost [m]", fontsize=8)
    panels[1, 0].set_ylabel("% of the first cost", fontsize=8)
    panels[0, 0].legend(fontsize=7)
    stream = io.StringIO()
    # Without date and random names, so that the same summary gives the same file.
    with matplotlib.rc_context({"svg.hashsalt": "dressing_sim"}):
        figure.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def _draw(panel: Axes, row: Mapping[str, Any], relative: bool) -> None:
    scale = 100.0 / row["steps"][0]["cost_of_all"] if relative else 1.0
    counts = [step["n"] for step in row["steps"]]
    costs = scale * np.array([step["cost_of_all"] for step in row["steps"]])
    low, high = scale * np.array([step["cost_of_all_ci95"] for step in row["steps"]]).T
    colour = _COLOURS[row["policy"]]
    panel.plot(counts, costs, color=colour, marker="o", ms=3, label=row["policy"])
    panel.fill_between(counts, low, high, color=colour, alpha=0.15, lw=0)


def cost_markdown(summary: Mapping[str, Any], command: str) -> str:
    """The report that people read."""
    return "\n".join(
        [
            f"# {TITLE}",
            "",
            f"    {command}",
            "",
            markdown_table(cost_table(summary)),
            "",
            *(f"{note}\n" for note in NOTES),
            "![cost against accepted demonstrations](cost.svg)",
            "",
            markdown_table(seconds_table(summary)),
            "",
            "## Settings",
            "",
            "```json",
            json.dumps(summary["config"], indent=2),
            "```",
            "",
            _packages(summary),
            "",
        ]
    )


def cost_html(summary: Mapping[str, Any], command: str, picture: str) -> str:
    """The same report as one page that needs no other file."""
    svg = picture[picture.index("<svg") :]
    return "\n".join(
        [
            "<!doctype html>",
            f"<html lang='en'><meta charset='utf-8'><title>{TITLE}</title>",
            f"<style>{_STYLE}</style>",
            f"<h1>{TITLE}</h1><pre>{escape(command)}</pre>",
            svg,
            _html_table(cost_table(summary)),
            *(f"<p>{escape(note)}</p>" for note in NOTES),
            _html_table(seconds_table(summary)),
            f"<h2>Settings</h2><pre>{escape(json.dumps(summary['config'], indent=2))}</pre>",
            f"<p>{escape(_packages(summary))}</p></html>\n",
        ]
    )


def _html_table(cells: Sequence[Sequence[str]]) -> str:
    lines = [
        "<tr>" + "".join(f"<{kind}>{escape(cell)}</{kind}>" for cell in row) + "</tr>"
        for kind, row in zip(["th"] + ["td"] * (len(cells) - 1), cells, strict=True)
    ]
    return "<table>" + "\n".join(lines) + "</table>"


def _packages(summary: Mapping[str, Any]) -> str:
    return ", ".join(f"{name} {number}" for name, number in summary["versions"].items())


def write_cost_report(folder: Path, summary: Mapping[str, Any], command: str) -> None:
    """Write the four files of a run; each is whole or not there."""
    picture = cost_figure(summary)
    write_text(folder / "cost.svg", picture)
    write_text(folder / "report.md", cost_markdown(summary, command))
    write_text(folder / "report.html", cost_html(summary, command, picture))
    # Last, as it tells that the run is finished.
    write_text(folder / SUMMARY, json.dumps(summary, indent=2) + "\n")
