"""The rules of success: what was measured in an episode becomes an outcome.

Success, after Zhu, Gienger, Kober (2022), Section VI: the gripper reaches above and around the
shoulder, does not hit the mannequin and does not stretch the cloth. Each condition is made
measurable below; each threshold is one field of `Thresholds`. Everything that went wrong is
reported, each reason with when and where it first occurred.

The robot has a protective stop: once a limit is passed it stops, and the verdict is on what
happened until then. What a robot would have torn its way through does not count.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.config import check_numbers
from dressing_sim.episode.trace import Limited, Trace, region
from dressing_sim.errors import InvalidInputError

#: Every reason an episode can fail for, in the order in which tables list them.
REASONS = (
    "ik_unreachable",
    "timeout",
    "stopped_short",
    "stuck",
    "ring_off",
    "hit",
    "grasp_lost",
    "over_strain",
    "over_force",
)

#: A hem that stays within this much of an arm coordinate, some millimetres, does not move.
_STILL = 0.02


@dataclass(frozen=True, slots=True)
class Thresholds:
    """When a dressing counts as done and what it may not do on the way."""

    armscye_s: float = 1.85
    """The armscye's centre must end at or past this arm coordinate: within about one arm's radius
    of the shoulder joint. Own choice."""
    gripper_distance: float = 0.16
    """The gripper must end this close to the shoulder joint [m]: own choice, the armscye's radius
    and the shoulder's."""
    hold_time: float = 0.5
    """For how long at the end the sleeve must be on [s]. Own choice."""
    strain: float = 0.30
    """Principal strain that 95 % of the cloth's area may not exceed. Own choice: what knitted
    jersey gives way to in wear; a sleeve that is caught at the elbow goes past it."""
    strain_percentile: float = 95.0
    """Which part of the cloth's area is judged [%]."""
    grip_force: float = 10.0
    """Largest pull on the cloth [N]: Assistive Gym's preferred limit (Erickson et al. 2020)."""
    link_force: float = 50.0
    """Largest net force of cloth on one link of the mannequin [N]: a third of the 140 to 160 N
    that ISO/TS 15066 allows on hand and arm, quasi-static."""
    moment: float = 0.2
    """Strain and force may exceed their thresholds for no longer than this in one go [s]."""

    def __post_init__(self) -> None:
        check_numbers(self, "thresholds", (), ("hold_time", "moment"))
        for name in ("gripper_distance", "strain", "strain_percentile", "grip_force", "link_force"):
            if not getattr(self, name) > 0.0:  # a limit may be infinite, which switches it off
                raise InvalidInputError(
                    f"thresholds: {name} is {getattr(self, name)}, valid is > 0"
                )
        if not np.isfinite(self.armscye_s):
            raise InvalidInputError(
                f"thresholds: armscye_s is {self.armscye_s}, valid is a finite number"
            )
        if self.strain_percentile > 100.0:
            raise InvalidInputError(
                f"thresholds: strain_percentile is {self.strain_percentile}, valid is 0 to 100"
            )


@dataclass(frozen=True, slots=True)
class Failure:
    """One thing that went wrong.

    Attributes:
        reason: One of `REASONS`.
        detail: What exactly, in words.
        time: When it first occurred, since the robot began to move [s]; None if not in time.
        s: Arm coordinate of the armscye's centre at that moment; None if not known.
        where: The part of the arm or of the mannequin that it is about, or None.
    """

    reason: str
    detail: str
    time: float | None = None
    s: float | None = None
    where: str | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """The verdict on one episode.

    Attributes:
        success: Whether the arm is dressed and nothing went wrong on the way.
        failures: Everything that went wrong, one entry a reason.
        metrics: The measurements behind the verdict, SI units; files call them ``figures``.
        invalid: Why the simulation cannot be trusted, or None; an invalid episode is neither a
            success nor a failure of the policy. Files call it ``void``.
    """

    success: bool
    failures: tuple[Failure, ...] = ()
    metrics: Mapping[str, float] = field(default_factory=dict)
    invalid: str | None = None

    @property
    def reasons(self) -> tuple[str, ...]:
        """Names of everything that went wrong."""
        return tuple(failure.reason for failure in self.failures)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a JSON file."""
        return {
            "success": self.success,
            "void": self.invalid,
            "failures": [
                {"reason": f.reason, "detail": f.detail, "time": f.time, "s": f.s, "where": f.where}
                for f in self.failures
            ],
            "figures": dict(self.metrics),
        }


class ProtectiveStop:
    """Watches a dressing row by row and says when the robot has to stop.

    Strain and force must have exceeded their thresholds for longer than a moment in one go; a
    robot that touches the mannequin and a cloth that has slipped from the fingers are reason
    enough at once.

    Args:
        rules: The limits.
        dt: Time between two rows [s].
    """

    def __init__(self, rules: Thresholds, dt: float) -> None:
        self._rules = rules
        self._moment = round(rules.moment / dt)
        self._runs = [0, 0, 0]

    def see(self, now: Limited) -> dict[str, int]:
        """Look at the next row.

        Returns:
            The reasons for which the robot has to stop now, none while it may go on, each with
            the number of rows for which it has been so.
        """
        rules = self._rules
        reasons = {}
        if now.hit:
            reasons["hit"] = 1
        if not now.holding:
            reasons["grasp_lost"] = 1
        limits = (
            ("over_strain", now.strain > rules.strain),
            ("over_force", now.grip_force > rules.grip_force),
            ("over_force", now.link_force > rules.link_force),
        )
        for i, (reason, exceeded) in enumerate(limits):
            self._runs[i] = self._runs[i] + 1 if exceeded else 0
            if self._runs[i] > self._moment:
                reasons[reason] = max(reasons.get(reason, 0), self._runs[i])
        return reasons


def stopped(trace: Trace, rules: Thresholds) -> tuple[int, dict[str, int]] | None:
    """The row at which the robot has to stop and `ProtectiveStop`'s reasons, or None."""
    watch = ProtectiveStop(rules, trace.dt)
    for row, now in enumerate(trace.limited()):
        reasons = watch.see(now)
        if reasons:
            return row, reasons
    return None


def judge(
    trace: Trace,
    shoulder: NDArray[np.float64],
    finished: bool,
    thresholds: Thresholds | None = None,
) -> Outcome:
    """Judge a simulated episode.

    Args:
        trace: What was measured. What comes after the protective stop is not looked at.
        shoulder: Shoulder joint (3,), in the robot's base frame [m].
        finished: Whether the robot came to the end of its path before the time limit; of no
            account after a protective stop.
        thresholds: The rules.

    Returns:
        The outcome, with all reasons.
    """
    rules = thresholds or Thresholds()
    stop = stopped(trace, rules)
    if stop is None:
        failures = list(_at_the_end(trace, shoulder, finished, rules))
    else:
        trace = trace[: stop[0] + 1]
        failures = list(_at_the_stop(trace, stop[1], rules))
    return Outcome(
        success=not failures,
        failures=tuple(sorted(failures, key=lambda f: REASONS.index(f.reason))),
        metrics=trace.metrics(shoulder),
    )


def _at_the_end(
    trace: Trace, shoulder: NDArray[np.float64], finished: bool, rules: Thresholds
) -> Iterator[Failure]:
    """What is wrong with an episode in which no limit was passed."""
    last = len(trace) - 1
    held = _held(trace, rules)
    gripper = np.linalg.norm(trace.tcp - shoulder, axis=1)
    above = trace.tcp[:, 2] > shoulder[2]
    if not finished:
        yield _failure(trace, last, "timeout", "the time limit came before the path's end")
    if not (np.all(gripper[held] <= rules.gripper_distance) and np.all(above[held])):
        side = "" if above[last] else ", below it"
        detail = f"the gripper ended {gripper[last]:.3f} m from the shoulder{side}"
        yield _failure(trace, last, "stopped_short", detail)
    elif not np.all(trace.armscye_s[held] >= rules.armscye_s):
        yield _stuck(trace)
    if not np.all(trace.wound[held]):
        yield _ring_off(trace)


def _at_the_stop(trace: Trace, reasons: Mapping[str, int], rules: Thresholds) -> Iterator[Failure]:
    """What went wrong until the robot stopped, in the trace's last row."""
    last = len(trace) - 1
    caught = "over_strain" in reasons or "over_force" in reasons
    if caught and trace.armscye_s[last] < rules.armscye_s:
        yield _stuck(trace)
    held = _held(trace, rules)
    # At first a sleeve hangs from the fingertips, so it must have been on to have come off.
    if trace.wound[: held.start].any() and not trace.wound[held].any():
        yield _ring_off(trace)
    for reason, rows in reasons.items():
        begin = len(trace) - rows
        where = region(float(trace.armscye_s[begin]))
        if reason == "hit":
            yield _hit(trace)
        elif reason == "grasp_lost":
            detail = f"the cloth slipped from the fingers at {trace.grip_force[last]:.1f} N"
            yield _failure(trace, last, reason, detail, where)
        elif reason == "over_strain":
            strained = 100.0 * trace.strain[begin:].max()
            detail = f"the cloth was stretched by {strained:.0f} % at the {where}"
            yield _failure(trace, begin, reason, detail, where)
        else:
            yield _failure(trace, begin, reason, _force(trace[begin:], where, rules), where)


def _failure(trace: Trace, row: int, reason: str, detail: str, where: str | None = None) -> Failure:
    return Failure(reason, detail, (row + 1) * trace.dt, float(trace.armscye_s[row]), where)


def _force(trace: Trace, where: str, rules: Thresholds) -> str:
    """What was too much force in the rows given."""
    pull, links = trace.grip_force.max(), np.linalg.norm(trace.link_force, axis=2).max(axis=0)
    told = []
    if pull > rules.grip_force:
        told.append(f"the cloth was pulled with {pull:.1f} N at the {where}")
    for i in np.flatnonzero(links > rules.link_force):
        link = trace.links[i].replace("_", " ")
        told.append(f"the cloth pressed the {link} with {links[i]:.1f} N")
    return " and ".join(told)


def _held(trace: Trace, rules: Thresholds) -> slice:
    """The rows at the end of a trace in which the sleeve must be on, the last one at least."""
    return slice(max(0, len(trace) - max(1, round(rules.hold_time / trace.dt))), None)


def _stuck(trace: Trace) -> Failure:
    """A sleeve that has not arrived in the last row, and the part of the arm that holds it.

    Cloth slides along the straight parts of an arm; what holds a sleeve that lies across the elbow
    is the elbow, whichever side of it presses harder. Elsewhere the armscye says where it is. It is
    dated to when the hem, which does not stretch with the pull, came to where it stayed.
    """
    last = len(trace) - 1
    away = np.flatnonzero(np.abs(trace.hem_s - trace.hem_s[last]) > _STILL)
    begin = int(away[-1]) + 1 if len(away) else 0
    armscye, hem = float(trace.armscye_s[last]), float(trace.hem_s[last])
    where = "elbow" if hem < 1.0 < armscye else region(armscye)
    pressed = int(np.argmax(trace.link_normal_force[last]))
    link = trace.links[pressed].replace("_", " ")
    detail = (
        f"the sleeve was caught at the {where}: it lies from s = {hem:.2f} to {armscye:.2f} and "
        f"presses the {link} with {trace.link_normal_force[last, pressed]:.1f} N"
    )
    return _failure(trace, begin, "stuck", detail, where)


def _ring_off(trace: Trace) -> Failure:
    """A sleeve that is off the arm at the end, dated to when it came off for good."""
    off = np.flatnonzero(~trace.wound)
    before = np.flatnonzero(trace.wound[: off[-1]])
    row = int(before[-1]) + 1 if len(before) else 0
    where = region(float(trace.armscye_s[row]))
    return _failure(trace, row, "ring_off", f"the sleeve came off the arm at the {where}", where)


def _hit(trace: Trace) -> Failure:
    """A robot that touches the mannequin in the last row, hardest first."""
    last = len(trace) - 1
    hit_by = trace.hit_by[last]
    hits = [i for i in np.argsort(-trace.hit_force[last], kind="stable") if hit_by[i] >= 0]
    links = [trace.links[i].replace("_", " ") for i in hits]
    told = [
        f"{trace.robot_links[hit_by[i]]} touched the {link} with {trace.hit_force[last, i]:.1f} N"
        for i, link in zip(hits, links, strict=True)
    ]
    return _failure(trace, last, "hit", " and ".join(told), links[0])


def count_reasons(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How many outcomes report each reason; reasons that do not occur are left out."""
    counts = {reason: sum(reason in o.reasons for o in outcomes) for reason in REASONS}
    return {reason: n for reason, n in counts.items() if n}
