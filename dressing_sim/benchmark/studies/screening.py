"""Kinematic screening of settings: what paths policies draw on postures, without any physics.

    python -m dressing_sim.benchmark.studies.screening --suite val50 --sets 3

Demonstrations are the operator's paths, which the gripper follows to a millimetre. A path is
compared with the operator's own, without its variability. This chooses settings worth simulating;
it does not predict success rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np
import tyro

from dressing_sim.arm import UP, Posture, Vector
from dressing_sim.benchmark.report.markdown import markdown_table
from dressing_sim.episode.operator import Operator, OperatorConfig
from dressing_sim.learning import SyntheticDemonstration
from dressing_sim.path import checked_path
from dressing_sim.policies.paper import POLICIES
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import WorldConfig, grip_start

#: Which policies on which demonstrations: the paper's rows.
ROWS = (
    *((policy, case) for case in ("case_a", "case_b") for policy in POLICIES),
    ("tp-gmm", "baseline7"),
)

#: Settings to compare with the default ones, as they stand after a policy's name.
SETTINGS = (
    "",
    "relative_floor=true&position_floor=0.1&displacement_floor=0.1",
    "relative_floor=true&position_floor=0.03&displacement_floor=0.03",
    "relative_floor=true&position_floor=0.01&displacement_floor=0.01",
    "position_floor=1e-3",
    "position_floor=1e-3&displacement_floor=1e-6",
    "displacement_floor=1e-6",
    "displacement_floor=1e-7",
    "samples=100",
    "samples=50",
    "free_axes=arm-plane",
    "situations=frames",
    "angle_margin_deg=0&translation_margin=0",
    "angle_margin_deg=20",
    "end_radius=0",
    "end_radius=0.1",
    "fusion=product-then-regression",
    "shrinkage=true",
)

ENDS_WITHIN = 0.08  # [m] of the operator's end
CLEARANCE = 0.02  # [m] between the gripper and the arm's surface, once it has started
FOLLOWS_WITHIN = 0.10  # [m] of all of the operator's path
LAGS_WITHIN = 0.07  # [m] less far outside the elbow than the operator


@dataclass(frozen=True, slots=True)
class PathFigures:
    """How a path compares with the operator's on the same posture.

    Attributes:
        end_gap: Between the two ends [m].
        clearance: Least distance from the arm's surface [m]; negative inside the arm.
        largest_gap: Greatest distance of a point of the operator's path from the path [m].
        mean_gap: The mean of these distances [m].
        outside: Farthest sideways from the elbow, towards the outside of its bend [m].
        outside_expert: The same of the operator's path [m].
    """

    end_gap: float
    clearance: float
    largest_gap: float
    mean_gap: float
    outside: float
    outside_expert: float

    @property
    def ends(self) -> bool:
        """Whether it ends where the operator's does."""
        return self.end_gap < ENDS_WITHIN

    @property
    def dresses(self) -> bool:
        """Whether it ends there, keeps clear of the arm and goes round it as the operator does."""
        return (
            self.ends
            and self.clearance > CLEARANCE
            and self.largest_gap < FOLLOWS_WITHIN
            and self.outside_expert - self.outside < LAGS_WITHIN
        )


def path_figures(path: Vector, expert: Vector, posture: Posture) -> PathFigures:
    """Compare a path (T, 3) with the operator's (N, 3) on a posture, both [m]."""
    # The operator's points are about 2 mm apart, so every fifth will do.
    gaps = np.linalg.norm(expert[::5, None] - path[None], axis=2).min(axis=1)
    size = posture.arm_size
    clearance = min(
        _distance(path, posture.wrist, posture.elbow) - size.forearm_radius,
        _distance(path, posture.elbow, posture.shoulder) - size.upper_arm_radius,
    )
    # Sideways: the sleeve hangs, so what counts is the bend as seen from above.
    sideways = np.cross(UP, posture.shoulder - posture.elbow)
    outside = sideways * np.sign(sideways @ (posture.elbow - posture.wrist))
    outside = outside / np.linalg.norm(outside)
    return PathFigures(
        end_gap=float(np.linalg.norm(path[-1] - expert[-1])),
        clearance=clearance,
        largest_gap=float(gaps.max()),
        mean_gap=float(gaps.mean()),
        outside=float(((path - posture.elbow) @ outside).max()),
        outside_expert=float(((expert - posture.elbow) @ outside).max()),
    )


def _distance(path: Vector, start: Vector, end: Vector) -> float:
    """Least distance of a path's points from a line segment [m]."""
    along = end - start
    share = np.clip((path - start) @ along / (along @ along), 0.0, 1.0)
    return float(np.linalg.norm(path - (start + share[:, None] * along), axis=1).min())


def operator_demonstrations(suite: str, seed: int) -> list[SyntheticDemonstration]:
    """What the operator would show on a suite's postures, as if followed exactly."""
    operator = Operator()
    return [
        SyntheticDemonstration(
            operator.path(posture, _start(posture), np.random.default_rng([seed, number])),
            operator.config.dt,
            posture.frames(),
        )
        for number, posture in enumerate(load_suite(suite))
    ]


def steady_path(posture: Posture) -> Vector:
    """The operator's path (N, 3) on a posture without its variability [m]."""
    variability = ("speed", "height", "waypoint")
    steady = OperatorConfig(**{f"{name}_variation": 0.0 for name in variability}, sway=0, tremor=0)
    return Operator(steady).path(posture, _start(posture), np.random.default_rng(0))


def _start(posture: Posture) -> Vector:
    return grip_start(posture, WorldConfig().sleeve)


def screen(
    name: str, demonstrations: str, postures: Sequence[Posture], sets: int
) -> list[PathFigures]:
    """Figures of a policy's paths: all postures of the first demonstration set, then the next.

    Args:
        name: Policy, perhaps with settings.
        demonstrations: Suite it is shown.
        postures: Where it is asked for a path.
        sets: How many times it is shown the suite, each time with another seed.
    """
    experts = [steady_path(posture) for posture in postures]
    figures = []
    for seed in range(sets):
        policy = make_policy(name, seed).fit(operator_demonstrations(demonstrations, seed))
        figures += [
            path_figures(
                checked_path(policy.generate(posture.frames(), expert[0]), name).positions,
                expert,
                posture,
            )
            for posture, expert in zip(postures, experts, strict=True)
        ]
    return figures


def main(
    suite: str = "val50", sets: int = 3, settings: tuple[str, ...] = SETTINGS, full: bool = False
) -> None:
    """Print a table: per cent of paths that would dress, by settings and row.

    Args:
        suite: postures to ask for paths on; never those of a test.
        sets: demonstration sets.
        settings: settings to compare, each as after a policy's name.
        full: print every figure's mean, one table for each setting.
    """
    postures = load_suite(suite)
    heading = [f"{name} {shown}" for name, shown in ROWS]
    cells = [["settings", *heading]]
    for text in settings:
        mark = f"?{text}" if text else ""
        results = [screen(name + mark, shown, postures, sets) for name, shown in ROWS]
        cells.append([text or "default", *(_per_cent(row) for row in results)])
        print(" | ".join(cells[-1]), flush=True)
        if full:
            print(markdown_table(_details(heading, results)), flush=True)
    print("\n" + markdown_table(cells))


def _per_cent(figures: Sequence[PathFigures]) -> str:
    dresses = 100.0 * np.mean([figure.dresses for figure in figures])
    return f"{dresses:.0f} ({100.0 * np.mean([figure.ends for figure in figures]):.0f})"


def _details(heading: Sequence[str], results: Sequence[Sequence[PathFigures]]) -> list[list[str]]:
    names = [field.name for field in fields(PathFigures)]
    return [
        ["policy", *names],
        *(
            [row, *(f"{np.mean([getattr(f, name) for f in figures]):.3f}" for name in names)]
            for row, figures in zip(heading, results, strict=True)
        ),
    ]


if __name__ == "__main__":
    tyro.cli(main)
