"""The convergence study's table and picture."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.figure import Figure

from dressing_sim.benchmark.report import markdown_table
from dressing_sim.benchmark.run.store import CONVERGENCE
from dressing_sim.benchmark.studies.convergence import CONVERGED, DEFAULT, FINEST, PATHS, Trial
from dressing_sim.benchmark.studies.convergence_summary import COMPARED
from dressing_sim.episode.rules import Thresholds
from dressing_sim.files import write_text

#: Colour-blind-safe (Okabe and Ito), one a path.
_COLOURS = dict(zip(PATHS, ("#0072B2", "#D55E00", "#009E73", "#CC79A7"), strict=True))


def validation_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """The summary as cells of text, the first row the heading."""
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


def validation_markdown(summary: Mapping[str, Any], command: str) -> str:
    """The report that people read."""
    verdict = "agree" if summary["agreement"] >= summary["required"] else "do NOT agree"
    lines = [
        "# Convergence of the simulation",
        "",
        f"    {command}",
        "",
        f"The default settings and the finest {verdict}: "
        f"{100 * summary['agreement']:.1f} % of verdicts are the same, "
        f"{100 * summary['required']:.0f} % are required." + _figures(summary) + _solver(summary),
        "",
        markdown_table(validation_table(summary)),
        "",
        "Strain, pull and armscye s: median absolute difference to the finest; of their limits: "
        "the larger of strain's and pull's as a share of its threshold. Solver's error: "
        "what strain and pull in nine of ten dressings stay within of those of the same mesh and "
        f"step with {CONVERGED}. Cost: median CPU time an episode, relative to the default's, "
        "measured in the same run.",
        "",
        "![Pull and strain of each episode, default against finest](convergence.svg)",
        "",
        "## Episodes whose verdict differs from the finest",
        "",
    ]
    if summary["differing"]:
        lines.append(markdown_table(differing_table(summary["differing"])))
    else:
        lines.append("None.")
    return "\n".join([*lines, ""])


def differing_table(differing: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """Episodes that differ from the finest, with both their figures, the first row the heading."""
    names = ["setting", "path", "posture", "verdict", "finest"]
    body = [
        [
            *(episode[name] for name in names),
            *(
                f"{_value(episode['margins'], figure)} against "
                f"{_value(episode['finest_margins'], figure)}"
                for figure in COMPARED
            ),
        ]
        for episode in differing
    ]
    return [[*names, "strain", "pull [N]", "s"], *body]


def _figures(summary: Mapping[str, Any]) -> str:
    """The sentence on the default's figures."""
    error, allowed = summary["figure_error"], summary["allowed_figure_error"]
    if error is None:
        return " Their figures could not be compared: all episodes are void."
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


def convergence_figure(trials: Sequence[Trial]) -> str:
    """Strain and pull of each episode under the default against the finest settings, as SVG."""
    found = {(t.setting, t.path, t.posture): t.outcome for t in trials}
    limits = Thresholds()
    panels = (
        ("strain", "strain of 95 % of the cloth's area", limits.strain),
        ("grip_force", "pull of the gripper [N]", limits.grip_force),
    )
    figure = Figure(figsize=(7.0, 3.6), layout="constrained")
    for axes, (name, label, limit) in zip(figure.subplots(1, 2), panels, strict=True):
        for path, colour in _COLOURS.items():
            pairs = [
                (found[FINEST, path, t.posture].metrics, t.outcome.metrics)
                for t in trials
                if (t.setting, t.path) == (DEFAULT, path)
            ]
            points = [(a[name], b[name]) for a, b in pairs if name in a and name in b]
            if points:
                axes.plot(
                    *zip(*points, strict=True), "o", ms=4, color=colour, label=path, alpha=0.8
                )
        top = 1.05 * max(axes.get_xlim()[1], axes.get_ylim()[1], limit)
        axes.plot([0, top], [0, top], color="0.6", lw=0.8, zorder=0)
        axes.axvline(limit, color="0.4", ls=":", lw=1)
        axes.axhline(limit, color="0.4", ls=":", lw=1)
        axes.set(
            xlim=(0, top),
            ylim=(0, top),
            xlabel=f"finest: {label}",
            ylabel="default",
            aspect="equal",
        )
    figure.axes[0].legend(frameon=False, fontsize=8)
    figure.suptitle("Largest strain and pull of each episode; dotted: threshold", fontsize=10)
    buffer = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": "convergence", "svg.fonttype": "path"}):
        figure.savefig(buffer, format="svg", metadata={"Date": None})
    return buffer.getvalue()


def write_validation(
    folder: Path, trials: Sequence[Trial], summary: Mapping[str, Any], command: str
) -> None:
    """Write ``episodes.jsonl``, ``summary.json``, ``report.md`` and ``convergence.svg``."""
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
    write_text(folder / "summary.json", json.dumps(summary, indent=2) + "\n")
    write_text(folder / CONVERGENCE, convergence_figure(trials))
    write_text(folder / "report.md", validation_markdown(summary, command))
