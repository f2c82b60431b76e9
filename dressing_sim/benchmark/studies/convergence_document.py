"""The report of the convergence study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

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
from dressing_sim.benchmark.studies.convergence_summary import COMPARED
from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Trial,
)
from dressing_sim.episode.thresholds import Thresholds

NOTE = (
    "Strain, pull and armscye s: median absolute difference to the finest; of their limits: the "
    "larger of strain's and pull's as a share of its threshold. Solver's error: what strain and "
    "pull in nine of ten dressings stay within of those of the same mesh and step with "
    f"{CONVERGED}. Cost: median CPU time an episode, relative to the default's, measured in the "
    "same run."
)


def convergence_document(
    trials: Sequence[Trial], summary: Mapping[str, Any], command: str
) -> Document:
    """The report.

    Args:
        trials: As from `dressing_sim.benchmark.studies.convergence.validate`.
        summary: As from `dressing_sim.benchmark.studies.convergence_summary.compare`.
        command: What was typed to get it.
    """
    differing = summary["differing"]
    found = Table(differing_table(differing)) if differing else Paragraph("None.")
    return Document(
        "Convergence of the simulation",
        command,
        (Paragraph(headline(summary)), Table(validation_table(summary))),
        (
            Section("What the numbers are", (Paragraph(NOTE), convergence_plot(trials))),
            Section("Episodes whose verdict differs from the finest", (found,)),
            *([config_section(summary)] if "config" in summary else []),
        ),
    )


def headline(summary: Mapping[str, Any]) -> str:
    """What the study says of the default settings."""
    verdict = "agree" if summary["agreement"] >= summary["required"] else "do NOT agree"
    return (
        f"The default settings and the finest {verdict}: "
        f"{100 * summary['agreement']:.1f} % of verdicts are the same, "
        f"{100 * summary['required']:.0f} % are required." + _metrics(summary) + _solver(summary)
    )


def validation_table(summary: Mapping[str, Any]) -> Cells:
    """Every setting against the finest."""
    heading = ["setting", "what", "agrees with the finest", "same reasons", "successes"]
    heading += ["strain", "pull", "armscye s", "of their limits", "solver's error", "cost"]
    body = [
        [
            row["setting"],
            row["what"],
            f"{row['n_agree']} / {row['n_episodes']} ({100 * row['agreement']:.0f} %)",
            f"{100 * row['same_reasons']:.0f} %",
            f"{row['n_success']}" + (f", {row['n_void']} void" if row["n_void"] else ""),
            _shown(row["difference_strain"], "{:.3f}"),
            _shown(row["difference_grip_force"], "{:.2f} N"),
            _shown(row["difference_armscye_s"], "{:.3f}"),
            _shown(row["figure_error"], "{:.1%}").replace("%", " %"),
            _shown(row["solver_error"], "{:.1%}").replace("%", " %"),
            f"{row['relative_cost']:.2f}",
        ]
        for row in summary["rows"]
    ]
    return [heading, *body]


def differing_table(differing: Sequence[Mapping[str, Any]]) -> Cells:
    """Episodes that differ from the finest, with both their metrics."""
    names = ["setting", "path", "posture", "verdict", "finest"]
    body = [
        [
            *(episode[name] for name in names),
            *(
                f"{_value(episode['margins'], metric)} against "
                f"{_value(episode['finest_margins'], metric)}"
                for metric in COMPARED
            ),
        ]
        for episode in differing
    ]
    return [[*names, "strain", "pull [N]", "s"], *body]


def _metrics(summary: Mapping[str, Any]) -> str:
    """The sentence on the default's metrics."""
    error, allowed = summary["figure_error"], summary["allowed_figure_error"]
    if error is None:
        return " Their metrics could not be compared: all episodes are void."
    return (
        f" In the median episode strain and pull differ by up to {100 * error:.1f} % of their "
        f"limits, {100 * allowed:.0f} % are allowed."
    )


def _solver(summary: Mapping[str, Any]) -> str:
    """The sentence on the default's solver."""
    error, allowed = summary["solver_error"], summary["allowed_solver_error"]
    if error is None:
        return (
            " The default's solver could not be judged: no dressing succeeds with a converged one."
        )
    return (
        f" The default's solver is {100 * error:.1f} % off a converged one, "
        f"{100 * allowed:.0f} % are allowed."
    )


def _shown(value: float | None, how: str) -> str:
    return "-" if value is None else how.format(value)


def _value(margins: Mapping[str, float], name: str) -> str:
    return f"{margins[name]:.2f}" if name in margins else "-"


def convergence_plot(trials: Sequence[Trial]) -> Plot:
    """Strain and pull of each episode under the default against the finest settings."""
    found = {(t.setting, t.path, t.posture): t.outcome.metrics for t in trials}
    limits = Thresholds()
    shown = (
        ("strain", "strain of 95 % of the cloth's area", limits.strain),
        ("grip_force", "pull of the gripper [N]", limits.grip_force),
    )
    with plots.figure(4.0) as drawn:
        for axes, (name, label, limit) in zip(drawn.subplots(1, 2), shown, strict=True):
            for path, style in zip(PATHS, plots.STYLES[1:], strict=False):
                keys = [(path, t.posture) for t in trials if (t.setting, t.path) == (DEFAULT, path)]
                pairs = [(found[FINEST, *key], found[DEFAULT, *key]) for key in keys]
                points = [(a[name], b[name]) for a, b in pairs if name in a and name in b]
                plots.draw_points(axes, points, path, style)
            top = 1.05 * max(axes.get_xlim()[1], axes.get_ylim()[1], limit)
            axes.plot([0, top], [0, top], color=plots.QUIET, lw=0.8, zorder=0)
            axes.axvline(limit, color=plots.QUIET, ls=":", lw=1)
            axes.axhline(limit, color=plots.QUIET, ls=":", lw=1)
            axes.set(xlim=(0, top), ylim=(0, top), aspect="equal")
            axes.set(xlabel=f"finest: {label}", ylabel="default")
        plots.legend_above(drawn, drawn.axes[0].get_legend_handles_labels()[0], len(PATHS))
        svg = plots.svg_of(drawn)
    alt = "Pull and strain of each episode, default against finest"
    caption = "Largest strain and pull of each episode; dotted: threshold."
    return Plot("convergence", svg, alt, caption, file=True)
