"""From what was measured to an outcome: the protective stop, the verdict and the margins.

Everything that went wrong is reported, each failure with when and where it first occurred. The
robot has a protective stop: once a rule that ends the episode is broken it stops, and the verdict
is on what happened until then. What a robot would have torn its way through does not count.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.rule import Evidence, Rule
from dressing_sim.episode.rules import RULES
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.trace import Limited, Trace


class ProtectiveStop:
    """Watches a dressing row by row and says when the robot has to stop.

    Args:
        thresholds: The limits.
        dt: Time between two rows [s].
        rules: Those of them that end an episode are watched.
    """

    def __init__(self, thresholds: Thresholds, dt: float, rules: Sequence[Rule] = RULES) -> None:
        self._thresholds = thresholds
        watched = [rule for rule in rules if rule.ends]
        self._watched = [(rule, round(rule.patience(thresholds) / dt)) for rule in watched]
        self.runs: dict[str, list[int]] = {}
        """For how many rows each limit of a rule has been exceeded in one go."""

    def observe(self, now: Limited) -> dict[str, int]:
        """Look at the next row.

        Returns:
            Names of the rules for which the robot has to stop now, none while it may go on, each
            with the number of rows for which it has been so.
        """
        reasons = {}
        for rule, patience in self._watched:
            exceeded = rule.exceeded(now, self._thresholds)
            runs = [0] * len(exceeded)
            if any(exceeded):
                before = self.runs.get(rule.name, runs)
                runs = [n + 1 if over else 0 for n, over in zip(before, exceeded, strict=True)]
                if max(runs) > patience:
                    reasons[rule.name] = max(runs)
            self.runs[rule.name] = runs
        return reasons


def stopped(
    trace: Trace, thresholds: Thresholds, rules: Sequence[Rule] = RULES
) -> tuple[int, dict[str, int]] | None:
    """The row at which the robot has to stop and `ProtectiveStop`'s reasons, or None."""
    watch = ProtectiveStop(thresholds, trace.dt, rules)
    for row, now in enumerate(trace.limited()):
        reasons = watch.observe(now)
        if reasons:
            return row, reasons
    return None


def judge(
    trace: Trace,
    shoulder: NDArray[np.float64],
    finished: bool,
    thresholds: Thresholds | None = None,
    rules: Sequence[Rule] = RULES,
) -> Outcome:
    """Judge a simulated episode.

    Args:
        trace: What was measured. What comes after the protective stop is not looked at.
        shoulder: Shoulder joint (3,) of a still arm, in the robot's base frame [m].
        finished: Whether the robot came to the end of its path before the time limit; of no
            account after a protective stop.
        thresholds: The numbers that decide.
        rules: What is judged.

    Returns:
        The outcome, with a failure of every rule that is broken, in the rules' order.
    """
    time_left = 0.0 if finished else -trace.dt
    evidence = until_stop(Evidence(trace, shoulder, time_left, thresholds or Thresholds()), rules)
    found = [rule.failure(evidence) for rule in rules]
    failures = tuple(failure for failure in found if failure is not None)
    return Outcome(not failures, failures, evidence.trace.metrics(shoulder))


def margins(evidence: Evidence, rules: Sequence[Rule] = RULES) -> dict[str, float]:
    """Signed margin of each rule by its name; below zero where it is broken, as `judge` has it.

    Unlike verdicts they change gradually with what the robot does, so they can be optimised.

    Args:
        evidence: What was measured, without a stop.
        rules: What is judged.

    Returns:
        Margins in the units of the rules.
    """
    judged = until_stop(evidence, rules)
    return {rule.name: rule.margin(judged) for rule in rules}


def until_stop(evidence: Evidence, rules: Sequence[Rule] = RULES) -> Evidence:
    """The evidence up to the protective stop, which it then names; all of it if there was none."""
    stop = stopped(evidence.trace, evidence.thresholds, rules)
    if stop is None:
        return evidence
    rows, reasons = slice(stop[0] + 1), stop[1]
    known = evidence.robot_clearance
    return replace(
        evidence,
        trace=evidence.trace[rows],
        robot_clearance=None if known is None else known[rows],
        stop=reasons,
    )
