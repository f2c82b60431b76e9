"""An arm, paths and ellipses on a plane: what all pictures of what was learned are drawn with."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from dressing_sim.arm import FORWARD, UP
from dressing_sim.benchmark.report import plots

#: Ellipses and tubes reach so many standard deviations.
REACH = 2.0

#: An arm whose wrist is nearer than this to above or below its shoulder has no direction [m].
_UPRIGHT = 0.01

#: Around what is drawn [m].
_MARGIN = 0.12

SIDES = ("from the side", "from above")
EXPERT, ANSWER, ARM = "#0072b2", "#009e73", "#e3c9b6"


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """A plane to draw on: its axes (2, 3), seen from the arm's shoulder (3,), and their names."""

    axes: NDArray[np.float64]
    origin: NDArray[np.float64]
    labels: tuple[str, str]

    def points(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) on the plane, (n, 2) [m]."""
        return (points - self.origin) @ self.axes.T


def sides_of(joints: NDArray[np.float64]) -> tuple[Side, Side]:
    """From the side, and from above."""
    shoulder, _, wrist = joints
    along = (wrist - shoulder) * (1.0 - UP)
    length = float(np.linalg.norm(along))
    along = along / length if length > _UPRIGHT else FORWARD
    across = np.cross(UP, along)
    towards = "towards the wrist [m]"
    return (
        Side(np.stack([along, UP]), shoulder, (towards, "up [m]")),
        Side(np.stack([along, across]), shoulder, (towards, "sideways [m]")),
    )


def corners_of(
    points: Sequence[NDArray[np.float64]], joints: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """Lower and upper corner (2, 2) [m] of both sides of an arm, around points (n, 3) [m]."""
    together = np.concatenate(points)
    flat = [side.points(together) for side in sides_of(joints)]
    return [np.array([one.min(axis=0) - _MARGIN, one.max(axis=0) + _MARGIN]) for one in flat]


def extent_of(corners: Sequence[NDArray[np.float64]]) -> tuple[float, list[float]]:
    """How wide both sides are, and how high each is [m]."""
    sizes = [high - low for low, high in corners]
    return float(max(size[0] for size in sizes)), [float(size[1]) for size in sizes]


def limit(axes: Axes, corners: NDArray[np.float64]) -> None:
    """Equal scales, and limits."""
    axes.set_aspect("equal")
    axes.set(xlim=corners[:, 0], ylim=corners[:, 1])
    axes.locator_params(nbins=5)
    axes.grid()


def draw_arm(axes: Axes, side: Side, joints: NDArray[np.float64]) -> None:
    """Shoulder, elbow and wrist, with the bones between them."""
    places = side.points(joints)
    axes.plot(*places.T, color=ARM, lw=7.0, solid_capstyle="round", zorder=1.0)
    axes.plot(*places.T, "o", ms=3.0, mfc=plots.SURFACE, mec=plots.INK, mew=0.7, zorder=1.2)


def name_joints(axes: Axes, side: Side, joints: NDArray[np.float64]) -> None:
    for place, name in zip(side.points(joints), ("shoulder", "elbow", "wrist"), strict=True):
        axes.annotate(
            name, place, (0.0, -7.0), textcoords="offset points", ha="center", va="top", zorder=6.0
        )


def draw_paths(
    axes: Axes,
    side: Side,
    paths: Iterable[NDArray[np.float64]],
    colour: str,
    width: float,
    order: float,
) -> None:
    lines = [side.points(path) for path in paths]
    axes.add_collection(
        LineCollection(lines, colors=colour, linewidths=width, zorder=order), autolim=False
    )


def draw_answer(axes: Axes, side: Side, path: NDArray[np.float64]) -> None:
    """The path, with an arrow head where it ends."""
    flat = side.points(path)
    axes.plot(*flat.T, color=ANSWER, lw=1.8, solid_capstyle="round", zorder=5.0)
    axes.plot(*flat[:1].T, "o", color=ANSWER, ms=4.0, zorder=5.1)
    before = max(len(flat) - 1 - max(len(flat) // 20, 1), 0)
    axes.annotate(
        "",
        flat[-1],
        flat[before],
        arrowprops={"arrowstyle": "-|>", "color": ANSWER, "lw": 1.8, "shrinkA": 0, "shrinkB": 0},
        zorder=5.1,
    )


def line(label: str, colour: str, width: float) -> Line2D:
    return Line2D([], [], color=colour, lw=width, label=label)


def legend(drawn: Figure, handles: Sequence[Line2D | Patch], columns: int) -> None:
    drawn.legend(
        handles=handles,
        loc="outside lower left",
        ncols=columns,
        handlelength=2.2,
        columnspacing=1.4,
    )
