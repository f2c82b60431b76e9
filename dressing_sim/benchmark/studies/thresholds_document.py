"""The report of the study of thresholds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import cycle
from typing import Any

from matplotlib.axes import Axes

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import (
    Cells,
    Document,
    Paragraph,
    Plot,
    Section,
    Table,
    config_section,
    percent,
)
from dressing_sim.benchmark.studies.columns import Column, table_of
from dressing_sim.benchmark.studies.thresholds_verdicts import TOLERATED

#: Factors of which tables show success rates.
SHOWN = (TOLERATED[0], 1.0, TOLERATED[1])

_COLUMNS = 2
_PANEL_HEIGHT, _LEGEND_LINE, _MARGIN = 1.12, 0.17, 0.45  # [inch]

#: How far apart the rows' marks stand, in factors, so that equal rates do not hide each other.
_DODGE = 0.011

NOTES = (
    "Success rates stand for the threshold times 0.8, times 1 and times 1.2. Of armscye_s what is "
    "multiplied is the distance to the shoulder at s = 2, of strain_percentile the part of the "
    "cloth's area that is not judged. A greater factor is stricter for hold_time, else looser.",
    "Each episode was simulated once, on after limits were exceeded, and judged anew under every "
    "threshold. The demonstrations are the same throughout: those that the thresholds in use let "
    "pass. Void episodes count neither way.",
    "The ranking of two rows turns if the one that is above with the threshold in use is below "
    "with another; beyond their intervals, if the 95 % bootstrap intervals of both differences, "
    "taken posture by posture, exclude zero.",
)

_TURNS = (
    "Differences in percentage points, first less second, with their bootstrap interval and p of "
    "McNemar's exact test, with the threshold in use and multiplied."
)


def thresholds_document(summary: Mapping[str, Any], command: str) -> Document:
    """The report; the summary is as from `dressing_sim.benchmark.studies.thresholds.summarise`."""
    void = summary["n_void"]
    told = headline(summary) + (f" {void} episodes are void." if void else "")
    meanings = table_of(
        {"threshold": "{name}", "meaning and source": "{source}"}, summary["thresholds"]
    )
    sections = [
        Section(
            "How success depends on each threshold",
            (sensitivity_plot(summary), *map(Paragraph, NOTES)),
        ),
        Section("What the thresholds mean", (Table(meanings),)),
    ]
    turned = turned_table(summary)
    if len(turned) > 1:
        sections.append(Section("Rankings that turn", (Table(turned), Paragraph(_TURNS))))
    return Document(
        "Success rates against the thresholds of success",
        command,
        (Paragraph(told), Table(sensitivity_table(summary))),
        (*sections, config_section(summary)),
    )


def sensitivity_table(summary: Mapping[str, Any], sources: bool = False) -> Cells:
    """Success rates under each threshold, and whether their ranking turns.

    Args:
        summary: As from `dressing_sim.benchmark.studies.thresholds.summarise`.
        sources: Whether to say what each threshold means and where it comes from.
    """
    shown = [summary["factors"].index(factor) for factor in SHOWN]

    def rates(number: int) -> Column:
        """Success rates of a row of the protocol."""
        return lambda threshold: (
            " / ".join(
                percent(threshold["rows"][number]["pc_success"][place]).removesuffix(" %")
                for place in shown
            )
            + " %"
        )

    columns: dict[str, Column] = {
        "threshold": "{name}",
        "value": "{value:g}",
        "unit": "{unit}",
        **({"meaning and source": "{source}"} if sources else {}),
        **{label_of(row): rates(n) for n, row in enumerate(summary["thresholds"][0]["rows"])},
        "ranking turned by 20 %": _ranking,
    }
    return table_of(columns, summary["thresholds"])


def _ranking(threshold: Mapping[str, Any]) -> str:
    low, high = TOLERATED
    if not threshold["acceptable"]:
        return "yes"
    inside = any(low <= turn["factor"] <= high for turn in threshold["turned"])
    return "within intervals" if inside else "no"


def headline(summary: Mapping[str, Any]) -> str:
    """The result in a sentence."""
    bad = [t["name"] for t in summary["thresholds"] if not t["acceptable"]]
    if bad:
        return (
            f"Changed by at most 20 %, {' and '.join(bad)} turn the ranking of rows round, beyond "
            "their intervals: not acceptable."
        )
    return (
        "No threshold turns the ranking of two rows round, beyond their intervals, when it is "
        "changed by at most 20 %."
    )


def turned_table(summary: Mapping[str, Any]) -> Cells:
    """Every turn of a ranking; the heading alone where there is none."""
    columns: dict[str, Column] = {
        "threshold": "{name}",
        "factor": "{factor:g}",
        "above": lambda turn: label_of(turn["above"]),
        "below": lambda turn: label_of(turn["below"]),
        "before": lambda turn: _difference(turn["before"]),
        "after": lambda turn: _difference(turn["after"]),
        "beyond intervals": lambda turn: "yes" if turn["beyond_intervals"] else "no",
    }
    return table_of(
        columns, (one | turn for one in summary["thresholds"] for turn in one["turned"])
    )


def _difference(pair: Mapping[str, Any]) -> str:
    low, high = pair["pc_difference_ci95"]
    return f"{pair['pc_difference']:+.3g} ({low:+.0f} to {high:+.0f}), p = {pair['p_mcnemar']:.3f}"


def sensitivity_plot(summary: Mapping[str, Any]) -> Plot:
    """Success rate against the factor of each threshold, a small panel each."""
    thresholds = summary["thresholds"]
    rows = thresholds[0]["rows"]
    height = -(-len(thresholds) // _COLUMNS) * _PANEL_HEIGHT + len(rows) * _LEGEND_LINE + _MARGIN
    with plots.figure(height, plots.NARROW) as drawn:
        grid = plots.panels(drawn, len(thresholds), _COLUMNS, sharex=True, sharey=True)
        for axes, threshold in zip(grid, thresholds, strict=True):
            _draw(axes, threshold, summary["factors"])
        plots.legend_above(drawn, grid[0].get_legend_handles_labels()[0])
        drawn.supxlabel("threshold, as a multiple of the one in use", fontsize=7.5)
        drawn.supylabel("success [%]", fontsize=7.5)
        svg = plots.svg_of(drawn)
    rates = [f"{t['name']}: " + ", ".join(_told(row) for row in t["rows"]) for t in thresholds]
    alt = f"Success rate against each threshold. {'. '.join(rates)}"
    caption = "Bands are 95 % Wilson intervals; grey is where a threshold changes by at most 20 %."
    return Plot("thresholds", svg, alt, caption, file=True)


def _told(row: Mapping[str, Any]) -> str:
    known = [rate for rate in row["pc_success"] if rate is not None]
    if not known:
        return f"{label_of(row)} unknown"
    return f"{label_of(row)} {percent(min(known))} to {percent(max(known))}"


def _draw(axes: Axes, threshold: Mapping[str, Any], factors: Sequence[float]) -> None:
    rows = threshold["rows"]
    axes.axvspan(*TOLERATED, color=plots.GRID, lw=0.0, zorder=0)
    axes.axvline(1.0, color=plots.QUIET, lw=0.6, zorder=0)
    for number, (row, style) in enumerate(zip(rows, cycle(plots.STYLES), strict=False)):
        if row["n_episodes"]:
            low, high = zip(*row["pc_success_ci95"], strict=True)
            places = [factor + (number - 0.5 * (len(rows) - 1)) * _DODGE for factor in factors]
            curve = plots.Curve(label_of(row), places, row["pc_success"], low, high)
            plots.draw_curve(axes, curve, style)
    unit = "" if threshold["unit"] == "-" else f" {threshold['unit']}"
    axes.set_title(f"{threshold['name']} {threshold['value']:g}{unit}", pad=5.0)
    axes.set(ylim=(0.0, 100.0), yticks=(0, 50, 100))
    ticks = (factors[0], 1.0, factors[-1])
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
