"""The report of the study of confidence."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import (
    Block,
    Document,
    Paragraph,
    Plot,
    Section,
    Table,
    config_section,
    percent,
)
from dressing_sim.benchmark.report.panels import in_panels
from dressing_sim.benchmark.studies.columns import Column, table_of

_COLUMNS: Mapping[str, Column] = {
    "row": lambda row: label_of(row),
    "dressed": "{n_success} / {n_episodes}",
    "Brier": "{brier:.3f}",
    "miscalibration": "{miscalibration:.3f}",
    "discrimination": "{discrimination:.3f}",
    "uncertainty": "{uncertainty:.3f}",
    "better than the training rate by": lambda row: _gain(row),
    "surest 90 %": lambda row: _surest(row, 0.9),
    "surest half": lambda row: _surest(row, 0.5),
}

_WEIGHTS = (
    "Weights of features in standard deviations: the change of the logarithm of the odds. What a "
    "policy's paths never differ in has none."
)

_TOLD = (
    "Each row's judge is a logistic regression on what a policy may see, calibrated on the "
    "training run alone and tried on the other. The Brier score is the mean squared error of its "
    "probabilities: miscalibration less discrimination plus uncertainty, which is the score of "
    "the tested episodes' own success rate. The last columns are the success of the episodes that "
    "are tried if the others are left, with their number."
)


def confidence_document(summary: Mapping[str, Any], command: str) -> Document:
    """The report; the summary is as from `dressing_sim.benchmark.studies.confidence`."""
    rows, config = summary["rows"], summary["config"]
    suites = config["suites"]
    told = f"Calibrated on `{suites['training']}`, tried on `{suites['tested']}`. {_TOLD}"
    missing = sum(row["n_unanswered"] for row in rows)
    lead: list[Block] = [Table(table_of(_COLUMNS, rows)), Paragraph(told)]
    if missing:
        lead.append(Paragraph(f"{missing} episodes without a path are left out."))
    lead += [Paragraph(f"Left out: {why}.") for why in summary["left_out"]]
    return Document(
        "Whether policies know when they will fail",
        command,
        tuple(lead),
        (
            Section("Reliability", (reliability_plot(rows),)),
            Section("Success against coverage", (coverage_plot(rows),)),
            Section("Judges", (Table(_weights(rows)), Paragraph(_WEIGHTS)), folded=True),
            config_section(summary),
        ),
    )


def _gain(row: Mapping[str, Any]) -> str:
    low, high = row["gain_ci95"]
    return f"{row['gain']:+.3f} ({low:+.3f} to {high:+.3f})"


def _surest(row: Mapping[str, Any], share: float) -> str:
    found = next(one for one in row["surest"] if one["share"] == share)
    return f"{percent(found['pc_success'])} of {found['n_episodes']}"


def _weights(rows: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    names = list(rows[0]["judge"]["features"])
    body = [
        [label_of(row), *(f"{row['judge']['features'][name]['weight']:+.2f}" for name in names)]
        for row in rows
    ]
    return [["row", *names], *body]


def reliability_plot(rows: Sequence[Mapping[str, Any]]) -> Plot:
    """Success rates in bins of probability, a panel a row; a perfect judge's are on the line."""

    def draw(axes: Axes, row: Mapping[str, Any]) -> None:
        axes.plot((0, 100), (0, 100), color=plots.QUIET, lw=0.8)
        bins = row["bins"]
        x = [100.0 * one["probability"] for one in bins]
        low, high = zip(*(one["pc_success_ci95"] for one in bins), strict=True)
        curve = plots.Curve("", x, [one["pc_success"] for one in bins], low, high)
        plots.draw_curve(axes, curve, plots.Style(plots.ACCENT, "o", ""), bars=True)
        axes.set(xlim=(0, 100), ylim=(0, 100), xticks=(0, 50, 100), yticks=(0, 50, 100))

    words = [
        f"{label_of(row)}: "
        + ", ".join(
            f"{one['n_success']} of {one['n_episodes']} dressed at {one['probability']:.2f}"
            for one in row["bins"]
        )
        for row in rows
    ]
    caption = (
        "Episodes in bins of about equal size by their estimated probability; success rates with "
        "95 % Wilson intervals."
    )
    svg = _panels(rows, draw, "estimated probability of success [%]", "dressed [%]")
    return Plot("confidence-reliability", svg, ". ".join(words), caption, file=True)


def coverage_plot(rows: Sequence[Mapping[str, Any]]) -> Plot:
    """Success of the episodes that are tried, against how many are, a panel a row."""

    def draw(axes: Axes, row: Mapping[str, Any]) -> None:
        covered = row["coverage"]
        x = [one["pc_coverage"] for one in covered]
        low, high = zip(*(one["pc_success_ci95"] for one in covered), strict=True)
        curve = plots.Curve("", x, [one["pc_success"] for one in covered], low, high)
        plots.draw_curve(axes, curve, plots.Style(plots.ACCENT, ""))
        axes.axhline(row["pc_success"], color=plots.QUIET, lw=0.8)
        axes.set(xlim=(0, 100), ylim=(0, 102), xticks=(0, 50, 100), yticks=(0, 50, 100))

    words = [
        f"{label_of(row)}: "
        + ", ".join(
            f"{percent(one['pc_success'])} of the surest {one['pc_coverage']:.0f} %"
            for one in row["surest"]
        )
        for row in rows
    ]
    caption = (
        "Success of the surest episodes, by their share of all, with 95 % Wilson intervals; the "
        "line is the success of all."
    )
    svg = _panels(rows, draw, "episodes that are tried [%]", "of these, dressed [%]")
    return Plot("confidence-coverage", svg, ". ".join(words), caption, file=True)


def _panels(
    rows: Sequence[Mapping[str, Any]],
    draw: Callable[[Axes, Mapping[str, Any]], None],
    xlabel: str,
    ylabel: str,
) -> str:
    def panel(axes: Axes, place: int) -> None:
        draw(axes, rows[place])
        axes.grid(axis="y")

    return in_panels([label_of(row) for row in rows], panel, 3, 1.7, (xlabel, ylabel))
