"""The report of the convergence study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes

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
from dressing_sim.benchmark.studies.convergence_ladders import refinement_table
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

REFINEMENT_NOTE = (
    "Means over the dressings that succeed on all three levels, the finest first. Order: of the "
    "error as the size goes to zero, a dash where values rise and fall or change ever more. Index: "
    "Roache's grid convergence index. Default off: from the extrapolated value, or from the "
    "finest's where there is no order."
)

#: What stands of each setting.
_SETTINGS: Mapping[str, Column] = {
    "setting": "{setting}",
    "what": "{what}",
    "agrees with the finest": "{n_agree} / {n_episodes} ({agreement:.0%})",
    "same reasons": "{same_reasons:.0%}",
    "successes": lambda row: (
        f"{row['n_success']}" + (f", {row['n_void']} void" if row["n_void"] else "")
    ),
    "strain": "{difference_strain:.3f}",
    "pull": "{difference_grip_force:.2f} N",
    "armscye s": "{difference_armscye_s:.3f}",
    "of their limits": "{figure_error:.1%}",
    "solver's error": "{solver_error:.1%}",
    "cost": "{relative_cost:.2f}",
}

#: What stands of each episode that differs from the finest.
_DIFFERING: Mapping[str, Column] = {
    **{name: f"{{{name}}}" for name in ("setting", "path", "posture", "verdict", "finest")},
    "strain": lambda episode: _both(episode, "strain"),
    "pull [N]": lambda episode: _both(episode, "grip_force"),
    "s": lambda episode: _both(episode, "armscye_s"),
}


def convergence_document(
    trials: Sequence[Trial], summary: Mapping[str, Any], command: str
) -> Document:
    """The report; the summary is as from `dressing_sim.benchmark.studies.convergence.compare`."""
    differing = summary["differing"]
    found = Table(differing_table(differing)) if differing else Paragraph("None.")
    return Document(
        "Convergence of the simulation",
        command,
        (Paragraph(headline(summary)), Table(validation_table(summary))),
        (
            Section("What the numbers are", (Paragraph(NOTE), convergence_plot(trials))),
            Section("Episodes whose verdict differs from the finest", (found,)),
            *_refinement(summary),
            *([config_section(summary)] if "config" in summary else []),
        ),
    )


def _refinement(summary: Mapping[str, Any]) -> Sequence[Section]:
    if not summary["refinement"]:
        return ()
    blocks = Paragraph(REFINEMENT_NOTE), Table(refinement_table(summary))
    return (Section("What the metrics tend to", blocks),)


def headline(summary: Mapping[str, Any]) -> str:
    """What the study says of the default settings."""
    agrees = summary["agreement"] >= summary["required"]
    texts = [
        f"The default settings and the finest {'agree' if agrees else 'do NOT agree'}: "
        "{agreement:.1%} of verdicts are the same, {required:.0%} are required.",
        "Their metrics could not be compared: all episodes are void."
        if summary["figure_error"] is None
        else "In the median episode strain and pull differ by up to {figure_error:.1%} of their "
        "limits, {allowed_figure_error:.0%} are allowed.",
        "The default's solver could not be judged: no dressing succeeds with a converged one."
        if summary["solver_error"] is None
        else "The default's solver is {solver_error:.1%} off a converged one, "
        "{allowed_solver_error:.0%} are allowed.",
    ]
    return " ".join(spaced(text, summary) for text in texts)


def validation_table(summary: Mapping[str, Any]) -> Cells:
    """Every setting against the finest."""
    return table_of(_SETTINGS, summary["rows"])


def differing_table(differing: Sequence[Mapping[str, Any]]) -> Cells:
    """Episodes that differ from the finest, with both their metrics."""
    return table_of(_DIFFERING, differing)


def _both(episode: Mapping[str, Any], metric: str) -> str:
    """A metric of an episode, and of the finest's; a dash where it was not measured."""
    margins = (episode[name].get(metric) for name in ("margins", "finest_margins"))
    return " against ".join("-" if value is None else f"{value:.2f}" for value in margins)


def convergence_plot(trials: Sequence[Trial]) -> Plot:
    """Strain and pull of each episode under the default against the finest settings."""
    limits = Thresholds()
    with plots.figure(4.0) as drawn:
        left, right = drawn.subplots(1, 2)
        _draw(left, trials, "strain", "strain of 95 % of the cloth's area", limits.strain)
        _draw(right, trials, "grip_force", "pull of the gripper [N]", limits.grip_force)
        plots.legend_above(drawn, left.get_legend_handles_labels()[0], len(PATHS))
        svg = plots.svg_of(drawn)
    alt = "Pull and strain of each episode, default against finest"
    caption = "Largest strain and pull of each episode; dotted: threshold."
    return Plot("convergence", svg, alt, caption, file=True)


def _draw(axes: Axes, trials: Sequence[Trial], metric: str, label: str, limit: float) -> None:
    for path, style in zip(PATHS, plots.STYLES[1:], strict=False):
        finest, default = (
            [t.outcome.metrics.get(metric) for t in trials if (t.setting, t.path) == (name, path)]
            for name in (FINEST, DEFAULT)
        )
        pairs = zip(finest, default, strict=True)
        points = [(x, y) for x, y in pairs if x is not None and y is not None]
        plots.draw_points(axes, points, path, style)
    top = 1.05 * max(axes.get_xlim()[1], axes.get_ylim()[1], limit)
    axes.plot([0, top], [0, top], color=plots.QUIET, lw=0.8, zorder=0)
    axes.axvline(limit, color=plots.QUIET, ls=":", lw=1)
    axes.axhline(limit, color=plots.QUIET, ls=":", lw=1)
    axes.set(xlim=(0, top), ylim=(0, top), aspect="equal")
    axes.set(xlabel=f"finest: {label}", ylabel="default")
