"""Draws where rivals fail: each one's path beside an arm and the operator's path, without physics.

python scripts/draw_rivals.py

A path fails by the criteria of the study of tuning. Of the postures on which a policy fails, the
one in the middle is drawn, by how far it is beyond the criterion that it misses the most.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tyro
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.studies import tuning_paths
from dressing_sim.benchmark.studies.tuning_paths import PathMetrics
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import write_file
from dressing_sim.policies.rivals import POLICIES
from dressing_sim.suites.suites import load_suite

DOCS = Path(__file__).resolve().parent.parent / "docs"

COLUMNS, ROW_HEIGHT = 4, 1.6  # [inch]
MARGIN = 0.12  # [m] around arm and operator; what a path does beyond is cut off
GAP = 0.06  # [m] between the two views

Points = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Failure:
    """A policy on a posture.

    Attributes:
        policy: Its name.
        posture: The arm.
        path: The policy's path (T, 3), in the robot's base frame [m].
        expert: The operator's path (N, 3) [m].
        metrics: How they compare.
        n_failed: On how many postures the policy fails; if on none, this is its worst.
        n_postures: Of so many.
    """

    policy: str
    posture: Posture
    path: Points
    expert: Points
    metrics: PathMetrics
    n_failed: int
    n_postures: int


def excesses(metrics: PathMetrics) -> dict[str, float]:
    """By what a path fails, in words, with how far it is beyond the criterion; above 1 it fails."""
    close = metrics.clearance
    words = (
        f"ends {1e2 * metrics.end_gap:.0f} cm off",
        "runs into the arm" if close < 0.0 else f"{1e3 * close:.0f} mm from the arm",
        f"strays {1e2 * metrics.largest_gap:.0f} cm",
        f"cuts the bend by {1e2 * metrics.lag:.0f} cm",
    )
    return {word: 1.0 - left for word, left in zip(words, metrics.margins, strict=True)}


def failure(
    name: str, demonstrated: Sequence[Posture], tested: Sequence[Posture], seed: int = 0
) -> Failure:
    """The policy's failure in the middle, see the module."""
    found = sorted(
        tuning_paths.tried(name, demonstrated, tested, seed),
        key=lambda one: max(excesses(one[3]).values()),
    )
    failed = [one for one in found if not one[3].dresses]
    middle = failed[len(failed) // 2] if failed else found[-1]
    return Failure(name, *middle, len(failed), len(found))


def draw(failures: Sequence[Failure]) -> str:
    """The failures as SVG, a panel a policy: the arm from above, and below it from the side."""
    rows = -(-len(failures) // COLUMNS)
    with plots.figure(0.35 + ROW_HEIGHT * rows) as drawn:
        for axes, one in zip(plots.panels(drawn, len(failures), COLUMNS), failures, strict=True):
            _draw_one(axes, one)
        handles = [
            Line2D([], [], color=plots.ACCENT, label="the policy"),
            Line2D([], [], color=plots.CONTRAST, ls="--", label="the operator"),
            Line2D(
                [],
                [],
                color=plots.GRID,
                lw=6.0,
                marker="s",
                label="the arm; its shoulder",
                markerfacecolor=plots.QUIET,
                markeredgewidth=0.0,
                markersize=4.0,
            ),
        ]
        plots.legend_above(drawn, handles, columns=3)
        return plots.svg_of(drawn)


def _draw_one(axes: Axes, one: Failure) -> None:
    arm = np.stack([one.posture.wrist, one.posture.elbow, one.posture.shoulder])
    known = np.concatenate([arm, one.expert])
    low, high = known.min(axis=0) - MARGIN, known.max(axis=0) + MARGIN
    inside = ((one.path > low) & (one.path < high)).all(axis=1)
    path = np.where(inside[:, None], one.path, np.nan)
    # Arms are held out sideways, so that is the horizontal of both views.
    for upwards, lift in ((0, GAP - low[0]), (2, -high[2])):
        for points, look in (
            (arm, {"color": plots.GRID, "lw": 6.0, "solid_capstyle": "round"}),
            (arm[2:], {"color": plots.QUIET, "marker": "s", "ms": 4.0, "mew": 0.0}),
            (one.expert[::8], {"color": plots.CONTRAST, "ls": "--", "lw": 1.0}),
            (path[:: max(1, len(path) // 100)], {"color": plots.ACCENT, "lw": 1.4}),
        ):
            axes.plot(points[:, 1], points[:, upwards] + lift, **look)
    axes.set_xlim(low[1], high[1])
    axes.set_ylim(low[2] - high[2], high[0] - low[0] + GAP)
    axes.set_aspect("equal")
    axes.set_axis_off()
    measured = excesses(one.metrics)
    why = max(measured, key=lambda words: measured[words])
    told = f"{one.n_failed} of {one.n_postures}: {why}" if one.n_failed else "none; its worst"
    axes.set_title(f"{one.policy}\n{told}", fontsize=6.0)


def main(
    policies: tuple[str, ...] = tuple(POLICIES),
    suite: str = "val50",
    demonstrations: str = "case_a",
    out: Path = DOCS / "rivals.svg",
) -> int:
    """Draw each policy's failure in the middle.

    Args:
        policies: a panel each.
        suite: postures to fail on; never those of a test.
        demonstrations: suite whose postures the operator demonstrates.
        out: SVG file to write.
    """
    try:
        demonstrated, tested = load_suite(demonstrations), load_suite(suite)
        failures = []
        for name in policies:
            one = failure(name, demonstrated, tested)
            failures.append(one)
            told = f"{one.n_failed} of {one.n_postures}, drawn on {one.posture.name}"
            print(f"{name}: {told}", flush=True)
        write_file(out, draw(failures))
    except InvalidInputError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(tyro.cli(main))
