"""Pictures of mixtures: what each frame has seen, its ellipses, and their product for an arm."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch
from numpy.typing import NDArray

from dressing_sim.benchmark.report import plots
from dressing_sim.explain.learned import FrameView, Learned, MixtureExplanation
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
from dressing_sim.learning.density import GaussianMixture

#: Discarded candidates can be any number; no more lines are drawn than can be told apart.
_MOST_DISCARDED = 60

_SYNTHETIC, _DISCARDED = "#d55e00", "#bab9b1"


def mixture_size(explanation: MixtureExplanation) -> tuple[float, float]:
    """Height and width that its panels fill [inch]."""
    wide, heights = extent_of(_corners(explanation))
    panel = (plots.WIDTH - 1.0) / 3
    return sum(panel * height / wide for height in heights) + 1.6, plots.WIDTH


def _corners(explanation: MixtureExplanation) -> list[NDArray[np.float64]]:
    """Around what is of the arm and the experts.

    Ellipses and synthetic demonstrations may cross, as Algorithm 1 keeps some that run off by
    metres.
    """
    experts = [path for view in explanation.views for path in view.experts]
    points = [explanation.joints, explanation.path, *(experts or [explanation.fused.final.means])]
    return corners_of(points, explanation.joints)


def draw_mixtures(drawn: Figure, explanation: MixtureExplanation) -> None:
    """A column a frame, and one of their product; from the side above, from above below."""
    limits = _corners(explanation)
    heights = [corner[1, 1] - corner[0, 1] for corner in limits]
    titles = [f"seen from the {view.name}" for view in explanation.views]
    titles.append("fused for this arm, and its answer")
    drawn.set_layout_engine("compressed")
    grid = drawn.subplots(
        2, len(titles), squeeze=False, sharex="all", sharey="row", height_ratios=heights
    )
    for axes, title in zip(grid[0], titles, strict=True):
        axes.set_title(title)
    sides = sides_of(explanation.joints)
    for row, side, corners, seen in zip(grid, sides, limits, SIDES, strict=True):
        row[0].set_ylabel(f"{seen}:\n{side.labels[1]}")
        for axes, view in zip(row, explanation.views, strict=False):
            draw_arm(axes, side, explanation.joints)
            _seen(axes, side, view)
        draw_arm(row[-1], side, explanation.joints)
        _ellipses(row[-1], side, explanation.fused)
        draw_answer(row[-1], side, explanation.path)
        for axes in row:
            limit(axes, corners)
    for axes in grid[1]:
        axes.set_xlabel(sides[0].labels[0])
    name_joints(grid[0, -1], sides[0], explanation.joints)
    off = _cut_off(explanation, sides, limits)
    legend(drawn, _mixture_handles(explanation, off), 4)


def _mixture_handles(explanation: MixtureExplanation, off: int) -> list[Line2D | Patch]:
    """What there is to explain, nothing else; so many that were kept are cut off."""
    view = explanation.views[0]
    handles = [line("expert demonstration", EXPERT, 1.3)] if view.experts else []
    if view.synthetic:
        text = f"synthetic, kept ({len(view.synthetic)}{f', {off} cut off' if off else ''})"
        handles.append(line(text, _SYNTHETIC, 1.1))
    if view.discarded:
        shown = min(len(view.discarded), _MOST_DISCARDED)
        part = "" if shown == len(view.discarded) else f", {shown} drawn"
        text = f"synthetic, discarded ({len(view.discarded)}{part})"
        handles.append(line(text, _DISCARDED, 0.6))
    handles.append(line("answer", ANSWER, 1.8))
    final: list[Line2D | Patch] = [*handles, line("component, 2 sd", plots.INK, 0.9)]
    if explanation.fused.initial is not None:
        initial = line("before synthetic demonstrations", plots.QUIET, 0.7)
        initial.set_linestyle((0, (3.0, 2.0)))
        final.append(initial)
    return [*final, Patch(color=ARM, label="arm")]


def _cut_off(
    explanation: MixtureExplanation,
    sides: Sequence[Side],
    limits: Sequence[NDArray[np.float64]],
) -> int:
    """How many synthetic demonstrations that were kept leave the picture, on any panel."""

    def leaves(path: NDArray[np.float64]) -> bool:
        panels = [
            (side.points(path), *corners) for side, corners in zip(sides, limits, strict=True)
        ]
        return any(bool(((flat < low) | (flat > high)).any()) for flat, low, high in panels)

    seen = zip(*(view.synthetic for view in explanation.views), strict=True)
    return sum(any(map(leaves, paths)) for paths in seen)


def _seen(axes: Axes, side: Side, view: FrameView) -> None:
    """What a frame has seen, and its mixture."""
    chosen = np.linspace(0, len(view.discarded) - 1, _MOST_DISCARDED).round().astype(int)
    discarded = (
        view.discarded
        if len(view.discarded) <= _MOST_DISCARDED
        else [view.discarded[place] for place in chosen]
    )
    for paths, colour, width, order in (
        (discarded, _DISCARDED, 0.5, 2.0),
        (view.synthetic, _SYNTHETIC, 0.9, 3.0),
        (view.experts, EXPERT, 1.2, 3.5),
    ):
        draw_paths(axes, side, paths, colour, width, order)
    _ellipses(axes, side, view.learned)


def _ellipses(axes: Axes, side: Side, learned: Learned) -> None:
    """Components at two standard deviations, as the plane sees them."""
    if learned.initial is not None:
        for ellipse in projected(side, learned.initial):
            ellipse.set(fill=False, ec=plots.QUIET, lw=0.7, ls=(0, (3.0, 2.0)), zorder=4.0)
            axes.add_patch(ellipse)
    for ellipse in projected(side, learned.final):
        axes.add_patch(ellipse)
        ellipse.set(fc=(*_grey(0.25), 0.10), ec=plots.INK, lw=0.9, zorder=4.5)
    middle = side.points(learned.final.means)
    axes.plot(*middle.T, "+", color=plots.INK, ms=3.0, mew=0.7, zorder=4.6)


def _grey(level: float) -> tuple[float, float, float]:
    return level, level, level


def projected(side: Side, mixture: GaussianMixture) -> list[Ellipse]:
    """Ellipses of the marginals on a plane: mean P m, covariance P S P'."""
    found = []
    for mean, covariance in zip(mixture.means, mixture.covariances, strict=True):
        variances, axes = np.linalg.eigh(side.axes @ covariance @ side.axes.T)
        width, height = 2.0 * REACH * np.sqrt(np.maximum(variances, 0.0))
        angle = np.rad2deg(np.arctan2(axes[1, 0], axes[0, 0]))
        found.append(Ellipse(side.points(mean[None])[0], width, height, angle=angle))
    return found
