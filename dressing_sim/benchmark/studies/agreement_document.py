"""The report of the agreement study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dressing_sim.benchmark.records import EpisodeResult
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
from dressing_sim.benchmark.studies.columns import Column, spaced, table_of
from dressing_sim.episode.thresholds import Thresholds

NOTE = (
    "The same joint commands are played in both worlds. Undecided, and counted apart: the verdict "
    "in the reference changes on a coarser mesh or with twice the step, or a success is nearer to "
    "a threshold than the reference's own error (Richardson's estimates from these). p: McNemar's, "
    "of as many verdicts that differ in one direction as in the other. Cost: CPU time, the "
    "default's by the reference's."
)

NOTE_OF_A_CHANGE = (
    "The same joint commands are played in both worlds; the reference has the change. p: "
    "McNemar's, of as many verdicts that differ in one direction as in the other. Cost: CPU time, "
    "the default's by the reference's."
)

#: What stands of each row.
_ROWS: Mapping[str, Column] = {
    "policy": "{policy}",
    "demonstrations": "{demonstrations}",
    "agree": "{n_agree} / {n_episodes}",
    "dressed": "{n_success}",
    "dressed in the reference": "{n_success_reference}",
    "undecided": "{undecided}",
    "void": "{n_void}",
}

#: What stands of each episode whose verdicts differ.
_DIFFERING: Mapping[str, Column] = {
    "policy": "{policy}",
    "demonstrations": "{demonstrations}",
    "posture": "{posture}",
    "default": lambda episode: _reasons(episode["default"]),
    "reference": lambda episode: _reasons(episode["reference"]),
    "pull [N]": lambda episode: _both(episode["grip_force"], 1),
    "strain": lambda episode: _both(episode["strain"], 2),
    "decided": lambda episode: "yes" if episode["decided"] else "no",
}


def agreement_document(
    results: Sequence[EpisodeResult], summary: Mapping[str, Any], command: str
) -> Document:
    """The report; the summary is as from `dressing_sim.benchmark.studies.agreement`."""
    return _document("Agreement with a finer simulation", NOTE, results, summary, command)


def change_document(
    results: Sequence[EpisodeResult], summary: Mapping[str, Any], command: str
) -> Document:
    """The report; the summary is as from `dressing_sim.benchmark.studies.change`."""
    title = f"Agreement with a simulation that has {summary['change']}"
    return _document(title, NOTE_OF_A_CHANGE, results, summary, command)


def _document(
    title: str,
    note: str,
    results: Sequence[EpisodeResult],
    summary: Mapping[str, Any],
    command: str,
) -> Document:
    found = Table(agreement_differing(summary)) if summary["differing"] else Paragraph("None.")
    return Document(
        title,
        command,
        (Paragraph(headline(summary)), Table(agreement_table(summary))),
        (
            Section("What the numbers are", (Paragraph(note), agreement_plot(results))),
            Section("Episodes whose verdicts differ", (found,)),
            config_section(summary),
        ),
    )


def headline(summary: Mapping[str, Any]) -> str:
    """What the study says of the default world."""
    told = summary["policies"]
    if told["agreement"] is None:
        return "Nothing can be said: every episode is void."
    low, high = told["agreement_ci95"]
    more = summary.get("change")
    other, there = "the reference", "in the reference"
    if more is not None:
        other, there = f"one that has {more}", "with it"
    text = (
        "The default world and {other} agree on {n_agree} of {n_episodes} verdicts "
        "({agreement:.1%}, 95 % interval {low:.1%} to {high:.1%}); {n_only_default} dressed only "
        "in the default, {n_only_reference} only {there} (p = {mcnemar_p:.2f})"
    )
    if told["undecided"]:
        text += "; {undecided} more are undecided (with them {agreement_with_undecided:.1%})"
    text += ". "
    cost = "" if told["cost_ratio"] is None else "The default costs {cost_ratio:.2f} of it."
    return spaced(
        text + cost, {**told, "low": low, "high": high, "other": other, "there": there}
    ).strip()


def agreement_table(summary: Mapping[str, Any]) -> Cells:
    """Every row of policies."""
    return table_of(_ROWS, summary["rows"])


def agreement_differing(summary: Mapping[str, Any]) -> Cells:
    """Every episode whose verdicts differ."""
    return table_of(_DIFFERING, summary["differing"])


def _reasons(reasons: Sequence[str]) -> str:
    return ", ".join(reasons) or "dressed"


def _both(values: Sequence[float | None], digits: int) -> str:
    return " against ".join("-" if v is None else f"{v:.{digits}f}" for v in values)


def agreement_plot(results: Sequence[EpisodeResult]) -> Plot:
    """Largest pull and strain of each episode in both worlds."""
    limits = Thresholds()
    with plots.figure(4.0) as drawn:
        left, right = drawn.subplots(1, 2)
        for axes, metric, label, limit in (
            (left, "strain", "strain of 95 % of the cloth's area", limits.strain),
            (right, "grip_force", "pull of the gripper [N]", limits.grip_force),
        ):
            points = []
            for result in results:
                reference: Any = result.extra["reference"]
                there, here = reference["figures"].get(metric), result.outcome.metrics.get(metric)
                if there is not None and here is not None:
                    points.append((there, here))
            plots.draw_points(axes, points, "episodes", plots.STYLES[1])
            top = 1.05 * max(axes.get_xlim()[1], axes.get_ylim()[1], limit)
            axes.plot([0, top], [0, top], color=plots.QUIET, lw=0.8, zorder=0)
            axes.axvline(limit, color=plots.QUIET, ls=":", lw=1)
            axes.axhline(limit, color=plots.QUIET, ls=":", lw=1)
            axes.set(xlim=(0, top), ylim=(0, top), aspect="equal")
            axes.set(xlabel=f"reference: {label}", ylabel="default")
        svg = plots.svg_of(drawn)
    alt = "Strain and pull of each episode, default against reference"
    caption = "Largest strain and pull of each episode; dotted: threshold."
    return Plot("agreement", svg, alt, caption, file=True)
