"""An episode as it happened."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.control import JointTrajectory
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.trace import Trace


@dataclass(frozen=True, slots=True)
class Recording:
    """An episode as it happened.

    Attributes:
        outcome: The verdict.
        trace: The measurements, or None if the robot never moved.
        trajectory: The joint commands, or None if there were none.
        positions: The gripper at the start and after each command, shape (n, 3) [m].
        time_left: What was left of the time when the robot had done all that it wanted to [s];
            below zero where that would have taken longer.
        reach_left: How much farther from its targets the commanded gripper might have been [m].
        broke: Why the simulation could not be trusted beyond the trace's last row, or None; then
            the outcome is invalid, unless the robot had stopped before.
    """

    outcome: Outcome
    trace: Trace | None
    trajectory: JointTrajectory | None
    positions: NDArray[np.float64]
    time_left: float = -1.0
    reach_left: float = 0.0
    broke: str | None = None

    @property
    def finished(self) -> bool:
        """Whether the robot came to the end of its path before the time limit."""
        return self.time_left >= 0.0
