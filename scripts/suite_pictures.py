"""Pictures and tables of suites of postures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import SubFigure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from dressing_sim.arm import ANGLE_LIMITS_DEG, Posture
from dressing_sim.benchmark.report import plots
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.suites.suites import situation_distance

#: The Panda reaches this far from its second joint, which is this high above its base [m] (Franka
#: Emika, Panda data sheet: 855 mm; height from the URDF).
REACH, REACH_HEIGHT = 0.855, 0.333

ANGLES = tuple(ANGLE_LIMITS_DEG)
N_BINS = 12

#: Smaller suites are marks on the axis instead of a histogram.
MIN_HISTOGRAM = 20

#: What is shown of the robot's base frame [m], lowest and highest coordinate.
X_LIMITS, Y_LIMITS, Z_LIMITS = (-0.1, 0.95), (-0.36, 0.36), (-0.08, 0.5)


@dataclass(frozen=True, slots=True)
class Style:
    """How a suite is drawn."""

    colour: str
    marker: str
    size: float
    line: float
    opacity: float


#: For the first, second and third suite: blue, orange and black of Okabe and Ito's palette, which
#: colour-blind people can tell apart; the markers differ as well.
STYLES = (
    Style("#0072b2", "o", 7.0, 0.6, 0.45),
    Style("#e69f00", "^", 14.0, 0.9, 0.85),
    Style(plots.INK, "D", 20.0, 2.0, 1.0),
)


def draw_postures(suites: Mapping[str, Sequence[Posture]], path: str | Path) -> None:
    """Draw the angles of up to three suites against each other, and their arms.

    The same suites make the same file, byte for byte, with the same version of matplotlib.

    Args:
        suites: Postures by the name of the suite, the largest suite first.
        path: SVG file to write.

    Raises:
        InvalidInputError: No suite, more than three, or the file cannot be written.
    """
    if not 1 <= len(suites) <= len(STYLES):
        raise InvalidInputError(f"{len(suites)} suites to draw, valid is 1 to {len(STYLES)}")
    with plots.figure(6.8, 12.0) as drawn:
        halves = drawn.subfigures(1, 2, squeeze=False, width_ratios=(1.45, 1.0))
        _draw_angles(halves[0, 0], suites)
        _draw_arms(halves[0, 1], suites)
        write_file(path, plots.svg_of(drawn))


def _draw_angles(figure: SubFigure, suites: Mapping[str, Sequence[Posture]]) -> None:
    """Histograms of the angles on the diagonal, below it each pair of angles."""
    axes = figure.subplots(4, 4, sharex="col")
    values = {
        name: np.array([[getattr(posture, angle) for angle in ANGLES] for posture in postures])
        for name, postures in suites.items()
    }
    together = np.concatenate(list(values.values()))
    edges = [np.linspace(low, high, N_BINS + 1) for low, high in _limits(together)]
    for row, column in np.ndindex(4, 4):
        panel = axes[row, column]
        if column > row:
            panel.set_axis_off()
            continue
        for angles, style in zip(values.values(), STYLES, strict=False):
            if row != column:
                _scatter(panel, angles[:, column], angles[:, row], style)
            elif len(angles) < MIN_HISTOGRAM:
                _scatter(panel, angles[:, row], np.zeros(len(angles)), style)
            else:
                weights = np.full(len(angles), 100.0 / len(angles))
                panel.hist(
                    angles[:, row], edges[row], weights=weights, histtype="step", color=style.colour
                )
        margin = 0.03 * (edges[column][-1] - edges[column][0])
        panel.set_xlim(edges[column][0] - margin, edges[column][-1] + margin)
        if column == 0 and row > 0:
            panel.set_ylabel(_label(ANGLES[row]))
        if row == column:
            panel.set_ylabel("postures [%]")
        if row == 3:
            panel.set_xlabel(_label(ANGLES[column]))
    handles = [
        Line2D([], [], color=s.colour, marker=s.marker, label=f"{name} ({len(postures)})")
        for (name, postures), s in zip(suites.items(), STYLES, strict=False)
    ]
    axes[0, 2].legend(handles=handles, loc="upper left", frameon=False, fontsize=9)


def _limits(values: np.ndarray) -> list[tuple[float, float]]:
    """Round limits [deg] around each column."""
    low, high = np.floor(values.min(axis=0) / 5.0) * 5.0, np.ceil(values.max(axis=0) / 5.0) * 5.0
    return [(a, max(b, a + 5.0)) for a, b in zip(low.tolist(), high.tolist(), strict=True)]


def _label(angle: str) -> str:
    return f"{angle.removesuffix('_deg')} [deg]"


def _scatter(axes: Axes, x: np.ndarray, y: np.ndarray, style: Style) -> None:
    axes.scatter(
        x,
        y,
        s=style.size,
        c=style.colour,
        marker=style.marker,
        alpha=style.opacity,
        linewidths=0.0,
        clip_on=False,
    )


def _draw_arms(figure: SubFigure, suites: Mapping[str, Sequence[Posture]]) -> None:
    """Arms from wrist over elbow to shoulder, in the robot's base frame, from three sides."""
    widths = [high - low for low, high in (X_LIMITS, Y_LIMITS)]  # one scale for both views
    panels = figure.subplot_mosaic("AA;BC", width_ratios=widths, height_ratios=(1.8, 1.0))
    _draw_view(panels["A"], suites, 0, 1, "from above")
    _draw_view(panels["B"], suites, 0, 2, "from the robot's right")
    _draw_view(panels["C"], suites, 1, 2, "from the front")
    shoulder, wrist = (
        np.mean([getattr(p, joint) for postures in suites.values() for p in postures], axis=0)
        for joint in ("shoulder", "wrist")
    )
    panels["A"].text(shoulder[0] + 0.06, shoulder[1], "shoulders", va="center")
    panels["A"].text(wrist[0], Y_LIMITS[1], "wrists", ha="center", va="top")
    panels["A"].text(0.03, 0.0, "robot's base", va="center")
    panels["A"].text(X_LIMITS[1], 0.0, "reach", ha="right", va="center")


def _draw_view(
    axes: Axes, suites: Mapping[str, Sequence[Posture]], across: int, up: int, title: str
) -> None:
    """One view: which coordinate of the robot's base frame goes across, which up."""
    for postures, style in zip(suites.values(), STYLES, strict=False):
        for posture in postures:
            joints = np.array([posture.wrist, posture.elbow, posture.shoulder])
            axes.plot(
                joints[:, across],
                joints[:, up],
                color=style.colour,
                lw=style.line,
                alpha=style.opacity,
                solid_joinstyle="round",
            )
    centre = np.array([0.0, 0.0, REACH_HEIGHT])[[across, up]]
    axes.add_patch(Circle(tuple(centre), REACH, fill=False, ls="--", lw=0.9, ec=plots.QUIET))
    axes.plot(0.0, 0.0, marker="s", ms=8, color=plots.QUIET)
    limits = (X_LIMITS, Y_LIMITS, Z_LIMITS)
    axes.set(xlim=limits[across], ylim=limits[up], aspect="equal", title=title)
    axes.set(xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]")


def distance_table(suites: Mapping[str, Sequence[Posture]]) -> str:
    """A Markdown table: how far apart the frames of the first two postures of each suite are.

    Raises:
        InvalidInputError: A suite of fewer than two postures.
    """
    lines = [
        "| suite | frame | origins [m] | roll, pitch, yaw [deg] | rotation [deg] |",
        "|---|---|---|---|---|",
    ]
    for name, postures in suites.items():
        if len(postures) < 2:
            raise InvalidInputError(f"suite {name!r}: {len(postures)} postures, valid is 2 or more")
        apart = situation_distance(postures[0].frames(), postures[1].frames())
        for n, frame in enumerate(("shoulder", "wrist")):
            angles = ", ".join(f"{angle + 0.0:.0f}" for angle in np.round(apart.euler_deg[n]))
            lines.append(
                f"| `{name}` | {frame} | {apart.origins[n]:.3f} | {angles} "
                f"| {apart.rotation_deg[n]:.0f} |"
            )
    return "\n".join(lines)
