"""Pictures of what a policy has learned: a TP-GMM frame by frame, a transport with its tube."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import EllipseCollection, LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch
from numpy.typing import NDArray

from dressing_sim.arm import FORWARD, UP
from dressing_sim.benchmark.report import plots
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.learning.density import GaussianMixture
from dressing_sim.policies.explained import (
    Explanation,
    FrameView,
    Learned,
    MixtureExplanation,
    TransportExplanation,
)

FORMATS = (".svg", ".png")

#: Dots an inch of a PNG: two columns of print at full width.
_DPI = 250

#: Ellipses and tubes reach so many standard deviations.
_REACH = 2.0

#: An arm whose wrist is nearer than this to above or below its shoulder has no direction [m].
_UPRIGHT = 0.01

#: Around what is drawn [m].
_MARGIN = 0.12

_FROM = ("from the side", "from above")

#: Height of the plot of standard deviations [inch].
_BELOW = 0.85

#: Discarded candidates can be any number; no more lines are drawn than can be told apart.
_MOST_DISCARDED = 60

_EXPERT, _SYNTHETIC, _ANSWER = "#0072b2", "#d55e00", "#009e73"
_DISCARDED, _ARM = "#bab9b1", "#e3c9b6"
_TUBE, _INNER = "#cfe9df", "#a6d8c6"


@dataclass(frozen=True, slots=True, eq=False)
class _Side:
    """A plane to draw on: its axes (2, 3), seen from the arm's shoulder (3,), and their names."""

    axes: NDArray[np.float64]
    origin: NDArray[np.float64]
    labels: tuple[str, str]

    def points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) on the plane, (n, 2) [m]."""
        return (points - self.origin) @ self.axes.T


def check_picture(path: str | Path) -> None:
    """Raise InvalidInputError unless a picture can be written to a file of this name."""
    if Path(path).suffix.lower() not in FORMATS:
        raise InvalidInputError(
            f"explain {path}: unknown format {Path(path).suffix!r}, valid is {', '.join(FORMATS)}"
        )


def write_explanation(path: str | Path, explanation: Explanation, title: str) -> None:
    """Draw what was learned, and the answer for an arm; the file is whole or not there.

    Lengths are in metres, seen from the arm's shoulder: from the side, at right angles to the line
    from shoulder to wrist, and from above.

    Args:
        path: Where to; its suffix says the format, one of `FORMATS`.
        explanation: As of `dressing_sim.policies.explained.explain`.
        title: Which policy on which arm.

    Raises:
        InvalidInputError: Another format, or the file cannot be written.
    """
    check_picture(path)
    with plots.figure(*_size(explanation)) as drawn:
        if isinstance(explanation, MixtureExplanation):
            _mixtures(drawn, explanation)
        else:
            _transport(drawn, explanation)
        drawn.suptitle(title, x=0.01, ha="left", fontsize=8.5)
        if Path(path).suffix.lower() == ".svg":
            content = plots.svg_of(drawn).encode()
        else:
            file = BytesIO()
            drawn.savefig(file, format="png", dpi=_DPI, metadata={"Software": None})
            content = file.getvalue()
    write_file(path, content)


def _sides(joints: NDArray[np.float64]) -> tuple[_Side, _Side]:
    """From the side, and from above."""
    shoulder, _, wrist = joints
    along = (wrist - shoulder) * (1.0 - UP)
    length = float(np.linalg.norm(along))
    along = along / length if length > _UPRIGHT else FORWARD
    across = np.cross(UP, along)
    towards = "towards the wrist [m]"
    return (
        _Side(np.stack([along, UP]), shoulder, (towards, "up [m]")),
        _Side(np.stack([along, across]), shoulder, (towards, "sideways [m]")),
    )


def _size(explanation: Explanation) -> tuple[float, float]:
    """Height and width that its panels fill [inch]."""
    columns = 3 if isinstance(explanation, MixtureExplanation) else 2
    wide, heights = _extent(explanation)
    panel = (plots.WIDTH - 1.0) / columns
    if isinstance(explanation, MixtureExplanation):
        rows = sum(panel * height / wide for height in heights)
        return rows + 1.6, plots.WIDTH
    return panel * max(heights) / wide + _BELOW + 1.55, plots.WIDTH


def _limits(explanation: Explanation) -> list[NDArray[np.float64]]:
    """Lower and upper corner (2, 2) [m] of each side.

    Around what is of the arm and the experts: ellipses and synthetic demonstrations may cross, as
    Algorithm 1 keeps some that run off by metres.
    """
    found = [explanation.joints, explanation.path]
    if isinstance(explanation, MixtureExplanation):
        experts = [path for view in explanation.views for path in view.experts]
        found += experts or [explanation.fused.final.means]
    else:
        found += list(explanation.carried)
    points = np.concatenate(found)
    corners = []
    for side in _sides(explanation.joints):
        flat = side.points(points)
        corners.append(np.array([flat.min(axis=0) - _MARGIN, flat.max(axis=0) + _MARGIN]))
    if isinstance(explanation, TransportExplanation):  # side by side they are of one height
        highest = max(high[1] - low[1] for low, high in corners)
        for corner in corners:
            corner[:, 1] = corner[:, 1].mean() + 0.5 * highest * np.array([-1.0, 1.0])
    return corners


def _extent(explanation: Explanation) -> tuple[float, list[float]]:
    """How wide both sides are, and how high each is [m]."""
    sizes = [high - low for low, high in _limits(explanation)]
    return float(max(size[0] for size in sizes)), [float(size[1]) for size in sizes]


def _mixtures(drawn: Figure, explanation: MixtureExplanation) -> None:
    """A column a frame, and one of their product; from the side above, from above below."""
    limits = _limits(explanation)
    heights = [corner[1, 1] - corner[0, 1] for corner in limits]
    titles = [f"seen from the {view.name}" for view in explanation.views]
    titles.append("fused for this arm, and its answer")
    drawn.set_layout_engine("compressed")
    grid = drawn.subplots(
        2, len(titles), squeeze=False, sharex="all", sharey="row", height_ratios=heights
    )
    for axes, title in zip(grid[0], titles, strict=True):
        axes.set_title(title)
    sides = _sides(explanation.joints)
    for row, side, corners, seen in zip(grid, sides, limits, _FROM, strict=True):
        row[0].set_ylabel(f"{seen}:\n{side.labels[1]}")
        for axes, view in zip(row, explanation.views, strict=False):
            _arm(axes, side, explanation.joints)
            _seen(axes, side, view)
        _arm(row[-1], side, explanation.joints)
        _ellipses(row[-1], side, explanation.fused)
        _answer(row[-1], side, explanation.path)
        for axes in row:
            _frame(axes, corners)
    for axes in grid[1]:
        axes.set_xlabel(sides[0].labels[0])
    _name_joints(grid[0, -1], sides[0], explanation.joints)
    off = _cut_off(explanation, sides, limits)
    _legend(drawn, _mixture_handles(explanation, off), 4)


def _mixture_handles(explanation: MixtureExplanation, off: int) -> list[Line2D | Patch]:
    """What there is to explain, nothing else; so many that were kept are cut off."""
    view = explanation.views[0]
    handles = [_line("expert demonstration", _EXPERT, 1.3)] if view.experts else []
    if view.synthetic:
        text = f"synthetic, kept ({len(view.synthetic)}{f', {off} cut off' if off else ''})"
        handles.append(_line(text, _SYNTHETIC, 1.1))
    if view.discarded:
        shown = min(len(view.discarded), _MOST_DISCARDED)
        part = "" if shown == len(view.discarded) else f", {shown} drawn"
        text = f"synthetic, discarded ({len(view.discarded)}{part})"
        handles.append(_line(text, _DISCARDED, 0.6))
    handles.append(_line("answer", _ANSWER, 1.8))
    final: list[Line2D | Patch] = [*handles, _line("component, 2 sd", plots.INK, 0.9)]
    if explanation.fused.initial is not None:
        initial = _line("before synthetic demonstrations", plots.QUIET, 0.7)
        initial.set_linestyle((0, (3.0, 2.0)))
        final.append(initial)
    return [*final, Patch(color=_ARM, label="arm")]


def _cut_off(
    explanation: MixtureExplanation,
    sides: Sequence[_Side],
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


def _seen(axes: Axes, side: _Side, view: FrameView) -> None:
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
        (view.experts, _EXPERT, 1.2, 3.5),
    ):
        _paths(axes, side, paths, colour, width, order)
    _ellipses(axes, side, view.learned)


def _paths(
    axes: Axes,
    side: _Side,
    paths: Iterable[NDArray[np.float64]],
    colour: str,
    width: float,
    order: float,
) -> None:
    lines = [side.points(path) for path in paths]
    axes.add_collection(
        LineCollection(lines, colors=colour, linewidths=width, zorder=order), autolim=False
    )


def _ellipses(axes: Axes, side: _Side, learned: Learned) -> None:
    """Components at two standard deviations, as the plane sees them."""
    if learned.initial is not None:
        for ellipse in _projected(side, learned.initial):
            ellipse.set(fill=False, ec=plots.QUIET, lw=0.7, ls=(0, (3.0, 2.0)), zorder=4.0)
            axes.add_patch(ellipse)
    for ellipse in _projected(side, learned.final):
        axes.add_patch(ellipse)
        ellipse.set(fc=(*_grey(0.25), 0.10), ec=plots.INK, lw=0.9, zorder=4.5)
    middle = side.points(learned.final.means)
    axes.plot(*middle.T, "+", color=plots.INK, ms=3.0, mew=0.7, zorder=4.6)


def _grey(level: float) -> tuple[float, float, float]:
    return level, level, level


def _projected(side: _Side, mixture: GaussianMixture) -> list[Ellipse]:
    """Ellipses of the marginals on a plane: mean P m, covariance P S P'."""
    found = []
    for mean, covariance in zip(mixture.means, mixture.covariances, strict=True):
        variances, axes = np.linalg.eigh(side.axes @ covariance @ side.axes.T)
        width, height = 2.0 * _REACH * np.sqrt(np.maximum(variances, 0.0))
        angle = np.rad2deg(np.arctan2(axes[1, 0], axes[0, 0]))
        found.append(Ellipse(side.points(mean[None])[0], width, height, angle=angle))
    return found


def _transport(drawn: Figure, explanation: TransportExplanation) -> None:
    """From the side and from above with the tube, and how wide it is along the path."""
    drawn.set_layout_engine("constrained")
    limits = _limits(explanation)
    height, _ = _size(explanation)
    grid = drawn.add_gridspec(2, 2, height_ratios=[height - _BELOW - 1.55, _BELOW])
    panels: Sequence[Axes] = [drawn.add_subplot(grid[0, place]) for place in range(2)]
    sides = _sides(explanation.joints)
    for axes, side, corners, title in zip(panels, sides, limits, _FROM, strict=True):
        axes.set(title=title, xlabel=side.labels[0], ylabel=side.labels[1])
        _arm(axes, side, explanation.joints)
        _tube(axes, side, explanation, _REACH, _TUBE, 1.5)
        _tube(axes, side, explanation, 1.0, _INNER, 1.6)
        _paths(axes, side, explanation.carried, _EXPERT, 0.9, 3.0)
        _answer(axes, side, explanation.path)
        _frame(axes, corners)
    _name_joints(panels[0], sides[0], explanation.joints)
    below = drawn.add_subplot(grid[1, :])
    share = np.linspace(0.0, 1.0, len(explanation.deviation))
    below.fill_between(share, 1e3 * explanation.deviation, color=_INNER, lw=0.0)
    below.set(xlim=(0.0, 1.0), ylim=(0.0, None), ylabel="standard deviation [mm]")
    below.set_xticks([0.0, 0.5, 1.0], ["start", "passing the elbow", "end"])
    below.grid(axis="y")
    handles: list[Line2D | Patch] = [
        _line(f"demonstrations ({len(explanation.carried)}), transported", _EXPERT, 0.9),
        _line("answer", _ANSWER, 1.8),
        Patch(color=_INNER, label="1 sd"),
        Patch(color=_TUBE, label="2 sd of a demonstration"),
        Patch(color=_ARM, label="arm"),
    ]
    _legend(drawn, handles, 5)


def _tube(
    axes: Axes, side: _Side, explanation: TransportExplanation, reach: float, colour: str, z: float
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


def _arm(axes: Axes, side: _Side, joints: NDArray[np.float64]) -> None:
    """Shoulder, elbow and wrist, with the bones between them."""
    places = side.points(joints)
    axes.plot(*places.T, color=_ARM, lw=7.0, solid_capstyle="round", zorder=1.0)
    axes.plot(*places.T, "o", ms=3.0, mfc=plots.SURFACE, mec=plots.INK, mew=0.7, zorder=1.2)


def _name_joints(axes: Axes, side: _Side, joints: NDArray[np.float64]) -> None:
    for place, name in zip(side.points(joints), ("shoulder", "elbow", "wrist"), strict=True):
        axes.annotate(
            name, place, (0.0, -7.0), textcoords="offset points", ha="center", va="top", zorder=6.0
        )


def _answer(axes: Axes, side: _Side, path: NDArray[np.float64]) -> None:
    """The path, with an arrow head where it ends."""
    flat = side.points(path)
    axes.plot(*flat.T, color=_ANSWER, lw=1.8, solid_capstyle="round", zorder=5.0)
    axes.plot(*flat[:1].T, "o", color=_ANSWER, ms=4.0, zorder=5.1)
    before = max(len(flat) - 1 - max(len(flat) // 20, 1), 0)
    axes.annotate(
        "",
        flat[-1],
        flat[before],
        arrowprops={"arrowstyle": "-|>", "color": _ANSWER, "lw": 1.8, "shrinkA": 0, "shrinkB": 0},
        zorder=5.1,
    )


def _frame(axes: Axes, corners: NDArray[np.float64]) -> None:
    """Equal scales, and limits."""
    axes.set_aspect("equal")
    axes.set(xlim=corners[:, 0], ylim=corners[:, 1])
    axes.locator_params(nbins=5)
    axes.grid()


def _line(label: str, colour: str, width: float) -> Line2D:
    return Line2D([], [], color=colour, lw=width, label=label)


def _legend(drawn: Figure, handles: Sequence[Line2D | Patch], columns: int) -> None:
    drawn.legend(
        handles=handles,
        loc="outside lower left",
        ncols=columns,
        handlelength=2.2,
        columnspacing=1.4,
    )
