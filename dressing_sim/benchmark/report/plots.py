"""The one style of plots: numbers in, SVG out.

The same numbers make the same text, with the same version of matplotlib. What is no datum has one
of the named colours, for which a page can put its own.
"""

from __future__ import annotations

import io
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from textwrap import fill
from typing import Any

import matplotlib
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from dressing_sim.files import assets

_STYLE: dict[Any, Any] = dict(
    matplotlib.rc_params_from_file(
        assets() / "report" / "plots.mplstyle", use_default_template=False
    )
)

#: Behind a plot; text; less of it; lines to read values by.
PAPER, INK, QUIET, GRID = (
    str(_STYLE[f"{name}color"]) for name in ("axes.face", "text.", "axes.edge", "grid.")
)

#: Around marks.
SURFACE = "#fdfdfb"

#: The darkest on bright paper, the brightest on dark. Not quite black, which SVG leaves unsaid.
BLACK = "#010101"

#: What a plot is about, and what it is held against.
ACCENT, CONTRAST = "#0072b1", "#b34700"

#: Width of a plot that fills a page, and of one that fills a telephone [inch].
WIDTH, NARROW = 7.6, 3.75

_ON_DARK, _ON_BRIGHT = "#fefefe", "#111111"
_ROW, _LINE = 0.17, 0.15  # heights of a row of intervals and of a further line of its label [inch]
_LABEL = 46  # letters in a line of a label


@dataclass(frozen=True, slots=True)
class Style:
    """How a curve is drawn."""

    colour: str
    marker: str
    dashes: str | tuple[int, tuple[float, ...]] = "-"

    @property
    def look(self) -> dict[str, Any]:
        """What `Axes.plot` takes."""
        return {"color": self.colour, "marker": self.marker, "ls": self.dashes}


#: Colours of Okabe and Ito's palette, which colour-blind people can tell apart; markers and dashes
#: differ as well.
STYLES = (
    Style(INK, "s"),
    Style("#0072b2", "o"),
    Style("#d55e00", "^", (0, (4.0, 1.0))),
    Style("#009e73", "v", (0, (1.0, 1.0))),
    Style("#cc79a7", "D", (0, (4.0, 1.0, 1.0, 1.0))),
    Style("#56b4e9", "P"),
    Style("#e69f00", "X", (0, (4.0, 1.0))),
)

#: What is drawn apart from what a plot is about: a yardstick.
MUTED = Style(QUIET, "s")


@contextmanager
def figure(height: float, width: float = WIDTH) -> Iterator[Figure]:
    """A figure of this size [inch] in the style, which holds inside the block alone."""
    with matplotlib.rc_context(_STYLE):
        yield Figure(figsize=(width, height), layout="constrained")


def svg_of(drawn: Figure) -> str:
    """A figure as the text of an SVG file."""
    stream = io.StringIO()
    with matplotlib.rc_context(_STYLE):
        layout = drawn.get_layout_engine()
        if layout is not None:  # else matplotlib draws all of it once more to find it
            layout.execute(drawn)
            drawn.set_layout_engine("none")
        drawn.savefig(stream, format="svg", metadata={"Date": None})
    return stream.getvalue()


def panels(drawn: Figure, n: int, columns: int, **shared: Any) -> list[Axes]:
    """Axes of n small plots, row by row; `shared` is what `Figure.subplots` takes."""
    rows = math.ceil(n / columns)
    grid = drawn.subplots(rows, columns, squeeze=False, **shared).ravel()
    for axes in grid[n:]:
        axes.set_axis_off()
    for axes in grid[max(n - columns, 0) : n]:
        axes.xaxis.set_tick_params(labelbottom=True)
    return list(grid[:n])


def legend_above(drawn: Figure, handles: Sequence[Any], columns: int = 1) -> None:
    """A legend over all panels, of handles that have labels."""
    drawn.legend(handles=handles, loc="outside upper left", ncols=columns, handlelength=3.2)


@dataclass(frozen=True, slots=True)
class Curve:
    """Values y over x, each with its interval from low to high."""

    label: str
    x: Sequence[float]
    y: Sequence[float]
    low: Sequence[float]
    high: Sequence[float]


def draw_curve(axes: Axes, curve: Curve, style: Style, bars: bool = False) -> None:
    """Draw a curve with its intervals: as a band or, if there are few, as bars."""
    if not curve.x:
        return
    if bars:
        axes.vlines(curve.x, curve.low, curve.high, color=style.colour, lw=1.0, alpha=0.6)
    else:
        axes.fill_between(curve.x, curve.low, curve.high, color=style.colour, alpha=0.1, lw=0.0)
    axes.plot(curve.x, curve.y, clip_on=False, label=curve.label, ms=3.0, lw=1.0, **style.look)


def draw_points(
    axes: Axes, points: Sequence[tuple[float, float]], label: str, style: Style
) -> None:
    """Draw pairs of numbers, one against the other."""
    x, y = zip(*points, strict=True) if points else ((), ())
    axes.plot(x, y, style.marker, ms=4.0, color=style.colour, label=label, alpha=0.8)


@dataclass(frozen=True, slots=True)
class Interval:
    """A row of a plot of intervals.

    Attributes:
        label: What it is of.
        low: Its lower bound.
        value: The estimate, or None where there is none.
        high: Its upper bound.
        muted: Whether it is a yardstick for the others.
        dots: Single values that the estimate is made of.
        ring: What it is held against.
    """

    label: str
    low: float
    value: float | None
    high: float
    muted: bool = False
    dots: Sequence[float] = ()
    ring: float | None = None


def intervals(
    rows: Sequence[Interval],
    xlabel: str,
    limits: tuple[float, float],
    legend: tuple[str, str, str] = ("", "", ""),
) -> str:
    """Estimates with their intervals, a row each.

    Args:
        rows: From top to bottom.
        xlabel: Quantity and unit.
        limits: Of the quantity.
        legend: What estimates, dots and rings are; those that are empty are left out.
    """
    labels = [wrapped(row.label) for row in rows]
    places = _places(labels)
    with figure(places[-1] + 0.95) as drawn:
        axes = _rows(drawn, labels, places, xlabel, limits)
        if limits[0] < 0.0 < limits[1]:
            axes.axvline(0.0, color=QUIET, lw=0.8)
        for y, row in zip(places, rows, strict=True):
            colour = QUIET if row.muted else ACCENT
            axes.barh(y, row.high - row.low, 0.13, row.low, color=colour, alpha=0.25)
            if row.value is not None:
                axes.vlines(row.value, y - 0.09, y + 0.09, color=colour, lw=2.2)
            axes.plot(row.dots, [y + 0.1] * len(row.dots), ".", color=QUIET, ms=2.5, clip_on=False)
            if row.ring is not None:
                axes.plot(
                    row.ring, y, "o", ms=5.0, mfc=SURFACE, mec=CONTRAST, mew=1.3, clip_on=False
                )
        marks: tuple[dict[str, Any], ...] = (
            {"color": ACCENT, "marker": "|", "ms": 7.0, "mew": 2.2, "lw": 5.0, "alpha": 0.5},
            {"color": QUIET, "marker": ".", "ms": 2.5, "lw": 0.0},
            {"color": CONTRAST, "marker": "o", "ms": 5.0, "mfc": SURFACE, "mew": 1.3, "lw": 0.0},
        )
        explained = [(mark, text) for mark, text in zip(marks, legend, strict=True) if text]
        if explained:
            legend_above(drawn, [Line2D([], [], label=t, **mark) for mark, t in explained], 3)
        return svg_of(drawn)


def stacked(
    rows: Mapping[str, Mapping[str, float]], colours: Mapping[str, str], xlabel: str
) -> str:
    """Shares of kinds [%], a bar a row that is as long as their sum.

    Args:
        rows: The share of each kind that a row has, by its label.
        colours: Of the kinds, in the order in which they are explained.
        xlabel: What is shared.
    """
    colours = {kind: BLACK if c == "#000000" else c for kind, c in colours.items()}
    labels = [wrapped(label) for label in rows]
    places = _places(labels)
    longest = max((sum(shares.values()) for shares in rows.values()), default=0.0)
    reach = next((step for step in (20.0, 40.0, 60.0, 80.0) if longest <= step), 100.0)
    with figure(places[-1] + 1.1) as drawn:
        axes = _rows(drawn, labels, places, xlabel, (0.0, reach))
        for y, shares in zip(places, rows.values(), strict=True):
            start = 0.0
            for kind, share in shares.items():
                axes.barh(y, share, 0.15, start, color=colours[kind], ec=SURFACE, lw=0.6)
                if share >= 0.06 * reach:
                    middle, colour = start + 0.5 * share, _text_on(colours[kind])
                    axes.text(middle, y, f"{share:.3g}", color=colour, ha="center", va="center")
                start += share
        used = {kind for shares in rows.values() for kind in shares}
        handles = [Patch(color=c, label=kind) for kind, c in colours.items() if kind in used]
        if handles:
            legend_above(drawn, handles, 5)
        return svg_of(drawn)


def wrapped(label: str, width: int = _LABEL) -> str:
    """A label in lines of at most so many letters."""
    return "\n".join(fill(line, width, break_on_hyphens=False) for line in label.splitlines())


def _places(labels: Sequence[str]) -> list[float]:
    """Where rows stand [inch], below each other."""
    places, bottom = [], 0.0
    for label in labels:
        height = _ROW + _LINE * label.count("\n")
        places.append(bottom + 0.5 * height + 0.05)
        bottom += height + 0.1
    return places


def _rows(
    drawn: Figure,
    labels: Sequence[str],
    places: Sequence[float],
    xlabel: str,
    limits: tuple[float, float],
) -> Axes:
    """Axes with labelled rows and a scale."""
    axes = drawn.subplots()
    axes.set_yticks(places, labels, color=INK)
    axes.tick_params(axis="y", length=0.0)
    axes.set(xlim=limits, ylim=(places[-1] + 0.2, places[0] - 0.2), xlabel=xlabel)
    axes.grid(axis="x")
    axes.spines["left"].set_visible(False)
    return axes


def _text_on(colour: str) -> str:
    """A colour that can be read on another."""
    if colour == BLACK:
        return SURFACE
    red, green, blue = to_rgb(colour)
    return _ON_DARK if 0.30 * red + 0.59 * green + 0.11 * blue < 0.45 else _ON_BRIGHT
