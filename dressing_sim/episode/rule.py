"""What a rule of success is, and what it judges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dressing_sim.episode.outcome import Failure
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.trace import Limited, Trace


@dataclass(frozen=True, slots=True)
class Evidence:
    """What a rule judges.

    Attributes:
        trace: What was measured, up to the protective stop if there was one.
        shoulder: Shoulder joint (3,) of a still arm, in the robot's base frame [m]; where a moving
            one is, the trace knows.
        time_left: What was left of the time when the robot had done all that it wanted to [s];
            below zero where that would have taken longer.
        thresholds: The numbers that decide.
        grip_strength: The pull at which the fingers lose the cloth [N].
        reach_left: How much farther from its targets the commanded gripper might have been [m].
        robot_clearance: Distance between robot and mannequin in each row, (n,), negative inside of
            it [m]; None where it is not known.
        stop: Names of the rules that stopped the robot in the trace's last row, each with the
            number of rows for which it had been so; empty if none did.
    """

    trace: Trace
    shoulder: NDArray[np.float64]
    time_left: float = 0.0
    thresholds: Thresholds = field(default_factory=Thresholds)
    grip_strength: float = np.inf
    reach_left: float = 0.0
    robot_clearance: NDArray[np.float64] | None = None
    stop: Mapping[str, int] = field(default_factory=dict)

    @property
    def finished(self) -> bool:
        """Whether the robot came to the end of its path before the time limit."""
        return self.time_left >= 0.0

    @property
    def last(self) -> int:
        """Index of the last row."""
        return len(self.trace) - 1

    @property
    def held(self) -> slice:
        """The rows at the end in which the sleeve must be on, the last one at least."""
        rows = max(1, round(self.thresholds.hold_time / self.trace.dt))
        return slice(max(0, len(self.trace) - rows), None)

    def failure(self, rule: Rule, row: int, detail: str, where: str | None = None) -> Failure:
        """A failure of a rule that began in a row."""
        s = float(self.trace.armscye_s[row])
        return Failure(rule.name, detail, (row + 1) * self.trace.dt, s, where)


class Rule:
    """One condition of success.

    A rule of one's own overrides `margin` and `failure`; one that ends the episode also overrides
    `exceeded`. It is passed on with the others: ``Dressing(posture, config, (*RULES, MyRule()))``.

    Attributes:
        name: What a failure of it is called in files and tables.
        title: The same in words, for people.
        ends: Whether breaking it stops the robot.
        colour: Of its failures in plots, as ``#rrggbb``; black is white on a dark page.
        unit: Of its margin.
        thresholds: Names of the fields of `Thresholds` that decide it.
    """

    name: str = ""
    title: str = ""
    ends: bool = False
    colour: str = "#999999"
    unit: str = "-"
    thresholds: tuple[str, ...] = ()

    def exceeded(self, now: Limited, thresholds: Thresholds) -> tuple[bool, ...]:
        """Whether each of the rule's limits is exceeded in one row."""
        return ()

    def patience(self, thresholds: Thresholds) -> float:
        """For how long a limit may be exceeded in one go before the robot stops [s]."""
        return 0.0

    def margin(self, evidence: Evidence) -> float:
        """How far the episode is from breaking the rule, in `unit`; below zero it is broken."""
        raise NotImplementedError(f"rule {self.name!r} has no margin")

    def failure(self, evidence: Evidence) -> Failure | None:
        """What went wrong by this rule, or None."""
        raise NotImplementedError(f"rule {self.name!r} does not say what went wrong")
