"""The interface that every policy meets, built in or from a third party."""

from collections.abc import Sequence
from typing import Protocol, Self, runtime_checkable

from numpy.typing import ArrayLike

from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray, Frame


@runtime_checkable
class Policy(Protocol):
    """A motion policy learned from demonstrations, asked for a path in a new situation.

    A policy may have an attribute ``dt``, the time between two samples of its path in [s]; without
    it, whoever plays the path chooses the speed.
    """

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from demonstrations and return the policy itself."""

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> FloatArray:
        """A path (T, p) in world coordinates for a situation, from the position ``start`` (p,)."""
