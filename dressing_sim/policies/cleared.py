"""Any policy's paths, kept as clear of the arm as its demonstrations were."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from numpy.typing import ArrayLike

from dressing_sim.learning import DemonstrationLike, Frame, Policy
from dressing_sim.path import Path, checked_path
from dressing_sim.policies.transported import TransportPolicy


class ClearPolicy:
    """A policy whose paths are moved until they are clear, see `TransportPolicy.cleared`.

    What is left of transport regression is phases and distances from the skeleton: its regression
    has no part in it.

    Args:
        policy: The policy; of it alone are the paths.
    """

    def __init__(self, policy: Policy) -> None:
        self.policy = policy
        self._measure = TransportPolicy()

    @property
    def dt(self) -> float | None:
        """Time between the samples of a path in [s], if the policy has one."""
        return getattr(self.policy, "dt", None)

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn, and measure how clear of the arm the demonstrations are.

        Raises:
            InvalidInputError: One does not pass the elbow, or cannot be learned from.
        """
        self._measure.fit(demonstrations)
        self.policy.fit(demonstrations)
        return self

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> Path:
        """The policy's path for the situation of an arm, moved."""
        path = checked_path(self.policy.generate(frames, start), "the policy")
        return Path(self._measure.cleared(frames, path.positions), path.dt)
