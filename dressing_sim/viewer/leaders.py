"""Who leads the gripper in a dressing of the page: a plan, a row of targets, or a person's hand."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from dressing_sim.control import JointTrajectory
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.rollout import recorded, with_hold

if TYPE_CHECKING:
    from dressing_sim.viewer.live import Live


@dataclass(frozen=True, slots=True, eq=False)
class Order:
    """What the robot was told in one control step, to be told again.

    Attributes:
        target: Gripper (3,) [m]; None to hold.
        command: Joint positions (7,) that are played as they are [rad], or None.
    """

    target: NDArray[np.float64] | None
    command: NDArray[np.float64] | None = None

    def carry_out(self, dressing: Dressing) -> Row:
        """Step once."""
        if self.command is not None:
            return dressing.step_joints(self.command, self.target)
        return dressing.hold() if self.target is None else dressing.step(self.target)


class Leader(Protocol):
    """Who leads the gripper."""

    def order(self, step: int) -> Order | None:
        """What to do in a step, counted from 0; None at the end."""

    def outcome(self, live: Live) -> Outcome:
        """The verdict, once there is nothing more to do."""


class AlongTrajectory:
    """Plays a planned trajectory: to the bit what `dressing_sim.episode.rollout.play` does."""

    def __init__(self, dressing: Dressing, trajectory: JointTrajectory) -> None:
        self._trajectory = trajectory
        self.commands, self.targets, self._time_left = with_hold(dressing, trajectory)

    def order(self, step: int) -> Order | None:
        """The next command."""
        after = step + 1
        if after >= len(self.commands):
            return None
        return Order(self.targets[after], self.commands[after])

    def outcome(self, live: Live) -> Outcome:
        """As of an episode that was played in one go."""
        places = [live.dressing.start, *(moment.row.tcp for moment in live.moments[1:])]
        return recorded(live.dressing, self._trajectory, places, self._time_left).outcome


class AlongTargets:
    """Leads through targets from a moment on, then holds."""

    def __init__(self, targets: NDArray[np.float64], first: int, n_hold: int) -> None:
        self._targets, self._first, self._n_hold = targets, first, n_hold

    def order(self, step: int) -> Order | None:
        """The next target; none while it holds."""
        at = step - self._first
        if at >= len(self._targets) + self._n_hold:
            return None
        return Order(self._targets[at] if at < len(self._targets) else None)

    def outcome(self, live: Live) -> Outcome:
        """The verdict on all that happened."""
        return live.dressing.outcome(live.finished)


class ByHand:
    """Follows whoever leads the gripper. Time stands still while it is where it should be.

    Attributes:
        target: Where the gripper should go in the end, (3,) [m].
    """

    #: Nearer than this the gripper is where it should be [m].
    NEAR = 5e-4

    def __init__(self, target: NDArray[np.float64]) -> None:
        self.target = target
        self._way: deque[NDArray[np.float64]] = deque()
        self._hold_until: int | None = None

    def lead(self, target: NDArray[np.float64]) -> None:
        """Go straight to a place (3,) [m] from now on."""
        self._way = deque()
        self.target = target

    def lead_along(self, way: NDArray[np.float64]) -> None:
        """Go on through places (n, 3) [m], one a step, once those from before are passed."""
        self._way.extend(way)
        self.target = way[-1]

    def waits(self, dressing: Dressing) -> bool:
        """Whether there is nothing to do until the target moves on."""
        there = float(np.linalg.norm(self.target - dressing.target)) < self.NEAR
        return there and not self._way and self._hold_until is None

    def let_go(self, step: int, n_hold: int) -> None:
        """Hold for so many steps from a step on; then it is over."""
        self._hold_until = step + n_hold

    def order(self, step: int) -> Order | None:
        """Towards the next place."""
        if self._hold_until is not None:
            return Order(None) if step < self._hold_until else None
        way = self._way  # a hand may replace it meanwhile
        return Order(way.popleft().copy() if way else self.target.copy())

    def outcome(self, live: Live) -> Outcome:
        """The verdict on all that happened."""
        return live.dressing.outcome(live.finished)
