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
        finished: Whether the commands end before the time limit.
        broke: Why the simulation could not be trusted beyond the trace's last row, or None; then
            the outcome is invalid, unless the robot had stopped before.
    """

    outcome: Outcome
    trace: Trace | None
    trajectory: JointTrajectory | None
    positions: NDArray[np.float64]
    finished: bool = False
    broke: str | None = None
