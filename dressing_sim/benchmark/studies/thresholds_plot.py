"""Success rates against each threshold, a small panel each."""

from __future__ import annotations

import io
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from dressing_sim.benchmark.report.text import pair_label
from dressing_sim.benchmark.studies.thresholds import TOLERATED

#: A figure this wide [inch] is shown 360 pixels wide, and its letters are 9 pixels high.
WIDTH, LETTERS = 3.75, 7.0
_COLUMNS = 2
_PANEL_HEIGHT, _LEGEND_LINE, _MARGIN = 1.12, 0.17, 0.45

#: How far apart the rows' marks stand, in factors, so that equal rates do not hide each other.
_DODGE = 0.011

_SETTINGS: dict[Any, Any] = {
    "svg.hashsalt": "dressing_sim",
    "svg.fonttype": "path",
    "font.family": "DejaVu Sans",
    "font.size": LETTERS,
    "axes.titlesize": LETTERS,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.labelsize": LETTERS,
    "ytick.labelsize": LETTERS,
    "legend.fontsize": LETTERS,
}


@dataclass(frozen=True, slots=True)
class Style:
    """How a row is drawn."""

    colour: str
    marker: str
    dashes: str | tuple[int, tuple[float, ...]]


#: Colours of Okabe and Ito's palette, which colour-blind people can tell apart; markers and dashes
#: differ as well.
STYLES = (
    Style("#000000", "s", "-"),
    Style("#0072B2", "o", "-"),
    Style("#D55E00", "^", (0, (4.0, 1.0))),
    Style("#009E73", "v", (0, (1.0, 1.0))),
    Style("#CC79A7", "D", (0, (4.0, 1.0, 1.0, 1.0))),
    Style("#56B4E9", "P", "-"),
    Style("#E69F00", "X", (0, (4.0, 1.0))),
)


def sensitivity_figure(summary: Mapping[str, Any]) -> str:
    """Success rate against the factor of each threshold, as SVG.

    Bands are 95 % Wilson intervals; the grey strip is the range in which the ranking may not turn.
    The same summary makes the same text, with the same version of matplotlib.

    Args:
        summary: As from `dressing_sim.benchmark.studies.thresholds_summary.summarise`.
    """
    thresholds = summary["thresholds"]
    n_rows = len(thresholds[0]["rows"])
    lines = math.ceil(len(thresholds) / _COLUMNS)
    height = lines * _PANEL_HEIGHT + n_rows * _LEGEND_LINE + _MARGIN
    with matplotlib.rc_context(_SETTINGS):
        figure = Figure(figsize=(WIDTH, height), layout="constrained", facecolor="white")
        panels = figure.subplots(lines, _COLUMNS, sharex=True, sharey=True, squeeze=False).ravel()
        for panel, threshold in zip(panels, thresholds, strict=False):
            _draw(panel, threshold, summary["factors"])
        for panel in panels[len(thresholds) :]:
            panel.set_axis_off()
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", frameon=False, handlelength=3.2)
        figure.supxlabel("threshold, as a multiple of the one in use", fontsize=LETTERS)
        figure.supylabel("success [%]", fontsize=LETTERS)
        stream = io.StringIO()
        # Without date and random names, so that the same summary gives the same file.
        figure.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def _draw(panel: Axes, threshold: Mapping[str, Any], factors: Sequence[float]) -> None:
    rows = threshold["rows"]
    panel.axvspan(*TOLERATED, color="0.92", lw=0.0, zorder=0)
    panel.axvline(1.0, color="0.6", lw=0.6, zorder=0)
    for number, (row, style) in enumerate(zip(rows, cycle(STYLES), strict=False)):
        if not row["n_episodes"]:
            continue
        low, high = zip(*row["pc_success_ci95"], strict=True)
        places = [factor + (number - 0.5 * (len(rows) - 1)) * _DODGE for factor in factors]
        panel.fill_between(places, low, high, color=style.colour, alpha=0.1, lw=0.0)
        panel.plot(
            places,
            row["pc_success"],
            color=style.colour,
            marker=style.marker,
            ms=2.4,
            lw=1.0,
            ls=style.dashes,
            clip_on=False,
            label=pair_label(row),
        )
    unit = "" if threshold["unit"] == "-" else f" {threshold['unit']}"
    panel.set_title(f"{threshold['name']} {threshold['value']:g}{unit}", loc="left", pad=5.0)
    panel.set(ylim=(0.0, 100.0), yticks=(0, 50, 100))
    ticks = (factors[0], 1.0, factors[-1])
    panel.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    panel.tick_params(width=0.6, length=2.5, pad=2.0)
