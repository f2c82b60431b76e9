"""Small plots side by side, one for each row of a table, with titles and shared axes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes

from dressing_sim.benchmark.report import plots

#: Letters in a line of a title; height of what stands below all panels, and of a legend [inch].
_TITLE, _BELOW, _LEGEND = 34, 0.45, 0.25


def in_panels(
    titles: Sequence[str],
    draw: Callable[[Axes, int], None],
    columns: int,
    height: float,
    labels: tuple[str, str],
    legend: Sequence[Any] = (),
) -> str:
    """Panels as SVG.

    Args:
        titles: Of the panels, row by row.
        draw: Called with the axes of each panel and its place among the titles.
        columns: Of panels.
        height: Of a panel [inch].
        labels: What all x axes and all y axes are.
        legend: Handles with labels, explained above the panels.
    """
    above = _LEGEND if legend else 0.0
    with plots.figure(_BELOW + above + height * -(-len(titles) // columns)) as drawn:
        grid = plots.panels(drawn, len(titles), columns, sharex=True, sharey=True)
        for place, (axes, title) in enumerate(zip(grid, titles, strict=True)):
            axes.set_title(plots.wrapped(title, _TITLE), pad=9.0)
            draw(axes, place)
        if legend:
            plots.legend_above(drawn, legend, 5)
        drawn.supxlabel(labels[0], fontsize=7.5, color=plots.QUIET)
        drawn.supylabel(labels[1], fontsize=7.5, color=plots.QUIET)
        return plots.svg_of(drawn)
