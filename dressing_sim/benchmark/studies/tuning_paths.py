"""Paths of policies next to the operator's on the same posture, without any physics."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.arm import UP, Posture, Vector
from dressing_sim.episode.operator import Operator, OperatorConfig
from dressing_sim.errors import DressingSimError
from dressing_sim.inputs import FRAMES_OF, asked_with, fit
from dressing_sim.learning import SyntheticDemonstration
from dressing_sim.path import checked_path
from dressing_sim.policies.registry import make_policy
from dressing_sim.world.scene import WorldConfig, grip_start

ENDS_WITHIN = 0.08  # [m] of the operator's end
CLEARANCE = 0.02  # [m] between the gripper and the arm's surface, once it has started
FOLLOWS_WITHIN = 0.10  # [m] of all of the operator's path
LAGS_WITHIN = 0.07  # [m] less far outside the elbow than the operator


@dataclass(frozen=True, slots=True)
class PathMetrics:
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
    def lag(self) -> float:
        """How much less far outside the elbow than the operator's path [m]."""
        return self.outside_expert - self.outside

    @property
    def margins(self) -> tuple[float, float, float, float]:
        """What is left of each limit, as a share of it, below zero beyond it: of the end, of the
        distance from the arm, of that from the operator's path, and of the lag."""
        return (
            1.0 - self.end_gap / ENDS_WITHIN,
            self.clearance / CLEARANCE - 1.0,
            1.0 - self.largest_gap / FOLLOWS_WITHIN,
            1.0 - self.lag / LAGS_WITHIN,
        )

    @property
    def dresses(self) -> bool:
        """Whether it ends there, keeps clear of the arm and goes round it as the operator does."""
        return min(self.margins) > 0.0

    @property
    def score(self) -> float:
        """How good it is, 0 to 1: half for that it dresses, half for its smallest margin."""
        margin = float(np.clip(min(self.margins), -1.0, 1.0))
        return 0.5 * self.dresses + 0.25 * (1.0 + margin)


def path_metrics(path: Vector, expert: Vector, posture: Posture) -> PathMetrics:
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
    return PathMetrics(
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


def operator_demonstrations(postures: Sequence[Posture], seed: int) -> list[SyntheticDemonstration]:
    """What the operator would demonstrate on postures, as if followed exactly, in all frames."""
    operator = Operator()
    return [
        SyntheticDemonstration(
            operator.path(posture, _start(posture), np.random.default_rng([seed, number])),
            operator.config.dt,
            posture.frames(*FRAMES_OF["elbow"]),
        )
        for number, posture in enumerate(postures)
    ]


def tried(
    name: str, demonstrated: Sequence[Posture], tested: Sequence[Posture], seed: int
) -> Iterator[tuple[Posture, Vector, Vector, PathMetrics]]:
    """Let a policy learn from the operator and draw its paths, each asked as its class allows.

    Args:
        name: The policy.
        demonstrated: Postures that the operator demonstrates.
        tested: Postures to ask for paths on.
        seed: Of the operator's variability and of the policy's own randomness.

    Yields:
        For each posture it, the policy's path (T, 3) and the operator's (N, 3) [m], and how they
        compare. A policy that has no answer stays where it is.
    """
    policy = fit(make_policy(name, seed), operator_demonstrations(demonstrated, seed))
    for posture in tested:
        expert = steady_path(posture)
        try:
            answer = policy.generate(asked_with(policy, posture), expert[0])
            path = checked_path(answer, name).positions
        except DressingSimError:
            path = expert[:1]
        yield posture, path, expert, path_metrics(path, expert, posture)


def steady_path(posture: Posture) -> Vector:
    """The operator's path (N, 3) on a posture without its variability [m]."""
    variability = ("speed", "height", "waypoint")
    steady = OperatorConfig(**{f"{name}_variation": 0.0 for name in variability}, sway=0, tremor=0)
    return Operator(steady).path(posture, _start(posture), np.random.default_rng(0))


def _start(posture: Posture) -> Vector:
    return grip_start(posture, WorldConfig().sleeve)
