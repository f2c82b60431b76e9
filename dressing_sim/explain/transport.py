"""Pictures of a transport: demonstrations carried to an arm, the answer and its uncertainty."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from dressing_sim.benchmark.report import plots
from dressing_sim.explain.learned import TransportExplanation
from dressing_sim.explain.sides import (
    ANSWER,
    ARM,
    EXPERT,
    REACH,
    SIDES,
    Side,
    corners_of,
    draw_answer,
    draw_arm,
    draw_paths,
    extent_of,
    legend,
    limit,
    line,
    name_joints,
    sides_of,
)

#: Height of the plot of standard deviations, and of titles, labels and legend [inch].
_BELOW, _AROUND = 0.85, 1.55

_TUBE, _INNER = "#cfe9df", "#a6d8c6"


def transport_size(explanation: TransportExplanation) -> tuple[float, float]:
    """Height and width that its panels fill [inch]."""
    wide, heights = extent_of(_corners(explanation))
    return (plots.WIDTH - 1.0) / 2 * max(heights) / wide + _BELOW + _AROUND, plots.WIDTH


def _corners(explanation: TransportExplanation) -> list[NDArray[np.float64]]:
    """Around all that is drawn; side by side both are of one height."""
    points = [explanation.joints, explanation.path, *explanation.carried]
    corners = corners_of(points, explanation.joints)
    _, heights = extent_of(corners)
    for corner in corners:
        corner[:, 1] = corner[:, 1].mean() + 0.5 * max(heights) * np.array([-1.0, 1.0])
    return corners


def draw_transport(drawn: Figure, explanation: TransportExplanation) -> None:
    """From the side and from above with the tube, and how wide it is along the path."""
    drawn.set_layout_engine("constrained")
    limits = _corners(explanation)
    height, _ = transport_size(explanation)
    grid = drawn.add_gridspec(2, 2, height_ratios=[height - _BELOW - _AROUND, _BELOW])
    panels: Sequence[Axes] = [drawn.add_subplot(grid[0, place]) for place in range(2)]
    sides = sides_of(explanation.joints)
    for axes, side, corners, title in zip(panels, sides, limits, SIDES, strict=True):
        axes.set(title=title, xlabel=side.labels[0], ylabel=side.labels[1])
        draw_arm(axes, side, explanation.joints)
        _tube(axes, side, explanation, REACH, _TUBE, 1.5)
        _tube(axes, side, explanation, 1.0, _INNER, 1.6)
        draw_paths(axes, side, explanation.carried, EXPERT, 0.9, 3.0)
        draw_answer(axes, side, explanation.path)
        limit(axes, corners)
    name_joints(panels[0], sides[0], explanation.joints)
    below = drawn.add_subplot(grid[1, :])
    share = np.linspace(0.0, 1.0, len(explanation.deviation))
    below.fill_between(share, 1e3 * explanation.deviation, color=_INNER, lw=0.0)
    below.set(xlim=(0.0, 1.0), ylim=(0.0, None), ylabel="standard deviation [mm]")
    below.set_xticks([0.0, 0.5, 1.0], ["start", "passing the elbow", "end"])
    below.grid(axis="y")
    handles: list[Line2D | Patch] = [
        line(f"demonstrations ({len(explanation.carried)}), transported", EXPERT, 0.9),
        line("answer", ANSWER, 1.8),
        Patch(color=_INNER, label="1 sd"),
        Patch(color=_TUBE, label="2 sd of a demonstration"),
        Patch(color=ARM, label="arm"),
    ]
    legend(drawn, handles, 5)


def _tube(
    axes: Axes, side: Side, explanation: TransportExplanation, reach: float, colour: str, z: float
) -> None:
    """All that is within so many standard deviations of the path: balls are circles on a plane."""
    path, radii = explanation.path, reach * explanation.deviation
    # So near each other that their outline is smooth.
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    counts = np.clip(np.ceil(steps / (0.1 * np.maximum(radii[1:], 1e-3))), 1, 50).astype(int)
    rows = np.concatenate(
        [np.linspace(n, n + 1, count, endpoint=False) for n, count in enumerate(counts)]
        + [[len(path) - 1.0]]
    )
    known = np.arange(len(path))
    points = np.stack([np.interp(rows, known, column) for column in path.T], axis=1)
    widths = 2.0 * np.interp(rows, known, radii)
    circles = EllipseCollection(
        widths,
        widths,
        np.zeros(len(widths)),
        units="xy",
        offsets=side.points(points),
        offset_transform=axes.transData,
        facecolors=colour,
        edgecolors="none",
        zorder=z,
    )
    axes.add_collection(circles, autolim=False)
