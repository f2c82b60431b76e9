"""Corrections of a path: as clear of an arm's skeleton as the demonstrations were."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Vector
from dressing_sim.learning.registration import smoothed
from dressing_sim.policies.skeleton import Skeleton

#: A path is corrected so many times, each time smoothly, over this fraction of it.
_CORRECTIONS, _CORRECTION_WIDTH = 3, 0.015


def within(
    points: NDArray[np.float64],
    skeleton: Skeleton,
    least: NDArray[np.float64],
    largest: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The path (N, 3) with its distances from the skeleton within bounds, each (N,) [m]."""
    for _ in range(_CORRECTIONS):
        outward = skeleton.outward(points)
        distance = np.linalg.norm(outward, axis=1)
        excess = np.clip(distance, least, largest) - distance
        push = (excess / np.maximum(distance, 1e-9))[:, None] * outward
        points = points + smoothed(push, _CORRECTION_WIDTH)
    return points


def beside(
    points: NDArray[np.float64],
    skeleton: Skeleton,
    hand: Vector,
    least: NDArray[np.float64],
) -> NDArray[np.float64]:
    """The path (N, 3) with the hand, pushed sideways, at least as far from the skeleton [m].

    Its height stays: a sleeve that is led round an elbow too high is caught.
    """
    for _ in range(_CORRECTIONS):
        outward = skeleton.outward(points + hand)
        distance = np.linalg.norm(outward, axis=1)
        lacking = np.maximum(least - distance, 0.0) / np.maximum(distance, 1e-9)
        push = lacking[:, None] * outward * [1.0, 1.0, 0.0]
        points = points + smoothed(push, _CORRECTION_WIDTH)
    return points


@dataclass(frozen=True, eq=False)
class Clearances:
    """How far from the skeleton demonstrations were, phase by phase.

    Attributes:
        distances: Least and largest distance of the fingertips, (2, N) [m].
        hand: From the fingertips to the hand, (3,) [m].
        hand_least: Least distance of the hand, (N,) [m].
    """

    distances: NDArray[np.float64]
    hand: Vector
    hand_least: NDArray[np.float64]

    @classmethod
    def of(
        cls, skeletons: Sequence[Skeleton], points: NDArray[np.float64], hand: Vector
    ) -> Clearances:
        """Those of demonstrations in phase, (M, N, 3), each with its arm's skeleton."""
        pairs = list(zip(skeletons, points, strict=True))
        found = np.stack([np.linalg.norm(s.outward(path), axis=1) for s, path in pairs])
        least = np.min([np.linalg.norm(s.outward(p + hand), axis=1) for s, p in pairs], axis=0)
        return cls(np.stack([found.min(axis=0), found.max(axis=0)]), hand, least)

    def shortfall(self, points: NDArray[np.float64], skeleton: Skeleton) -> tuple[float, float]:
        """By how much a path by phase, (N, 3), is too near to a skeleton at most [m].

        Of the fingertips and of the hand; below zero where it is farther than need be everywhere.
        """
        distance = np.linalg.norm(skeleton.outward(points), axis=1)
        hand = np.linalg.norm(skeleton.outward(points + self.hand), axis=1)
        return float((self.distances[0] - distance).max()), float((self.hand_least - hand).max())

    def kept(self, points: NDArray[np.float64], skeleton: Skeleton) -> NDArray[np.float64]:
        """A path by phase, (N, 3), moved until it is as clear of a skeleton."""
        points = within(points, skeleton, *self.distances)
        return beside(points, skeleton, self.hand, self.hand_least)
