"""The rules of success: what may not go wrong in a dressing, and what must be so at its end.

Success, after Zhu, Gienger, Kober (2022), Section VI: the gripper reaches above and around the
shoulder, does not hit the mannequin and does not stretch the cloth. Each condition is a `Rule`;
`RULES` lists them, and nothing else knows how many there are.
"""

from __future__ import annotations

from collections.abc import Sequence, Set

import numpy as np
from numpy.typing import NDArray

from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rule import Evidence, Rule
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.trace import Limited, region

#: A hem that stays within this much of an arm coordinate, some millimetres, does not move.
_STILL = 0.02

#: The margin of a rule that is broken by next to nothing, such as a touch without force.
_TOUCH = 1e-9


class Unreachable(Rule):
    """The robot can follow the path. Broken before anything moves: a trace never breaks it."""

    name, title, colour = "ik_unreachable", "out of the robot's reach", "#000000"
    unit = "m"

    def margin(self, evidence: Evidence) -> float:
        return evidence.reach_left

    def failure(self, evidence: Evidence) -> Failure | None:
        return None

    def before_moving(self, detail: str) -> Failure:
        """The failure of a path that nobody tries to follow."""
        return Failure(self.name, detail)


class Unanswered(Rule):
    """The policy answers with a path. Broken before anything moves, or in closed loop at a step."""

    name, title, colour = "policy_error", "the policy gave no answer", "#2200bb"

    def margin(self, evidence: Evidence) -> float:
        return 0.0

    def failure(self, evidence: Evidence) -> Failure | None:
        return None

    def unanswered(self, detail: str) -> Failure:
        """The failure of a policy that was asked and gave no answer that can be used."""
        return Failure(self.name, detail)


class Timeout(Rule):
    """The path ends before the time limit."""

    name, title, colour = "timeout", "the time limit came first", "#f0e442"
    unit = "s"

    def margin(self, evidence: Evidence) -> float:
        return evidence.time_left

    def failure(self, evidence: Evidence) -> Failure | None:
        if evidence.stop or evidence.finished:
            return None
        detail = "the time limit came before the path's end"
        return evidence.failure(self, evidence.last, detail)


class StoppedShort(Rule):
    """The gripper ends above and around the shoulder."""

    name, title, colour = "stopped_short", "the gripper stopped short", "#56b4e9"
    unit = "m"
    thresholds = ("gripper_distance", "hold_time")

    def margin(self, evidence: Evidence) -> float:
        distance, height = self._gripper(evidence)
        near = evidence.thresholds.gripper_distance - distance[evidence.held]
        return float(np.minimum(near, height[evidence.held]).min())

    def failure(self, evidence: Evidence) -> Failure | None:
        if evidence.stop or self.kept(evidence):
            return None
        distance, height = self._gripper(evidence)
        side = "" if height[-1] > 0.0 else ", below it"
        detail = f"the gripper ended {distance[-1]:.3f} m from the shoulder{side}"
        return evidence.failure(self, evidence.last, detail)

    def kept(self, evidence: Evidence) -> bool:
        """Whether the gripper is where it should be at the end."""
        distance, height = self._gripper(evidence)
        limit, held = evidence.thresholds.gripper_distance, evidence.held
        return bool(np.all(distance[held] <= limit) and np.all(height[held] > 0.0))

    @staticmethod
    def _gripper(evidence: Evidence) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Distance from the shoulder and height above it in each row [m]."""
        tcp, shoulder = evidence.trace.tcp, evidence.trace.shoulder(evidence.shoulder)
        return np.linalg.norm(tcp - shoulder, axis=1), tcp[:, 2] - shoulder[..., 2]


class Stuck(Rule):
    """The armscye arrives at the shoulder, unless the gripper itself stopped short of it.

    Cloth slides along the straight parts of an arm; what holds a sleeve that lies across the elbow
    is the elbow, whichever side of it presses harder. Elsewhere the armscye says where it is. A
    failure is dated to when the hem, which does not stretch with the pull, came to where it stayed.
    """

    name, title, colour = "stuck", "the sleeve was caught", "#d55e00"
    thresholds = ("armscye_s", "hold_time")

    def margin(self, evidence: Evidence) -> float:
        return float(evidence.trace.armscye_s[self._judged(evidence)].min()) - (
            evidence.thresholds.armscye_s
        )

    def failure(self, evidence: Evidence) -> Failure | None:
        trace, last = evidence.trace, evidence.last
        if not self._applies(evidence) or self.margin(evidence) >= 0.0:
            return None
        away = np.flatnonzero(np.abs(trace.hem_s - trace.hem_s[last]) > _STILL)
        begin = int(away[-1]) + 1 if len(away) else 0
        armscye, hem = float(trace.armscye_s[last]), float(trace.hem_s[last])
        where = "elbow" if hem < 1.0 < armscye else region(armscye)
        pressed = int(np.argmax(trace.link_normal_force[last]))
        link = trace.links[pressed].replace("_", " ")
        detail = (
            f"the sleeve was caught at the {where}: it lies from s = {hem:.2f} to {armscye:.2f} "
            f"and presses the {link} with {trace.link_normal_force[last, pressed]:.1f} N"
        )
        return evidence.failure(self, begin, detail, where)

    @staticmethod
    def _judged(evidence: Evidence) -> slice:
        return slice(evidence.last, None) if evidence.stop else evidence.held

    @staticmethod
    def _applies(evidence: Evidence) -> bool:
        if evidence.stop:  # whoever pulls too hard is caught; a hit or a lost grasp tells nothing
            return bool({"over_strain", "over_force"} & set(evidence.stop))
        return StoppedShort().kept(evidence)


class RingOff(Rule):
    """Every ring of the sleeve winds round the arm at the end.

    At first a sleeve hangs from the fingertips, so after a stop it must have been on to have come
    off. A failure is dated to when the sleeve came off for good.
    """

    name, title, colour = "ring_off", "the sleeve was not on the arm", "#0072b2"
    thresholds = ("hold_time",)

    def margin(self, evidence: Evidence) -> float:
        return float(evidence.trace.wound[evidence.held].mean()) - 1.0

    def failure(self, evidence: Evidence) -> Failure | None:
        wound, held = evidence.trace.wound, evidence.held
        if evidence.stop:
            if not wound[: held.start].any() or wound[held].any():
                return None
        elif np.all(wound[held]):
            return None
        off = np.flatnonzero(~wound)
        before = np.flatnonzero(wound[: off[-1]])
        row = int(before[-1]) + 1 if len(before) else 0
        if not len(before):
            where = region(float(evidence.trace.armscye_s[-1]))
            detail = f"the sleeve was never wholly on the arm; its armscye ended at the {where}"
            return evidence.failure(self, row, detail, where)
        where = region(float(evidence.trace.armscye_s[row]))
        return evidence.failure(self, row, f"the sleeve came off the arm at the {where}", where)


class Hit(Rule):
    """The robot does not touch the mannequin.

    The margin is the smallest distance between them, and how deep a touch went.
    """

    name, title, colour = "hit", "the robot hit the mannequin", "#cc79a7"
    ends, unit = True, "m"

    def exceeded(self, now: Limited, thresholds: Thresholds) -> tuple[bool, ...]:
        return (now.hit,)

    def margin(self, evidence: Evidence) -> float:
        known = evidence.robot_clearance
        nearest = 0.0 if known is None else float(known.min())
        touched = bool((evidence.trace.hit_by >= 0).any())
        # A touch between two rows may be over, and the robot off again, when the next is measured.
        return min(nearest, -_TOUCH) if touched else max(nearest, 0.0)

    def failure(self, evidence: Evidence) -> Failure | None:
        if self.name not in evidence.stop:
            return None
        trace, last = evidence.trace, evidence.last
        hit_by = trace.hit_by[last]
        hits = [i for i in np.argsort(-trace.hit_force[last], kind="stable") if hit_by[i] >= 0]
        links = [trace.links[i].replace("_", " ") for i in hits]
        robot, force = trace.robot_links, trace.hit_force[last]
        told = [
            f"{robot[hit_by[i]]} touched the {link} with {force[i]:.1f} N"
            for i, link in zip(hits, links, strict=True)
        ]
        return evidence.failure(self, last, " and ".join(told), links[0])


class GraspLost(Rule):
    """The fingers hold the cloth. The margin is what they could have held beyond the largest pull.

    A pull that is lost ends at once, and the sensor hardly sees more than the fingers can hold.
    """

    name, title, colour = "grasp_lost", "the cloth slipped from the fingers", "#e69f00"
    ends, unit = True, "N"

    def exceeded(self, now: Limited, thresholds: Thresholds) -> tuple[bool, ...]:
        return (not now.holding,)

    def margin(self, evidence: Evidence) -> float:
        left = evidence.grip_strength - float(evidence.trace.grip_force.max())
        return left if evidence.trace.holding.all() else min(left, -_TOUCH)

    def failure(self, evidence: Evidence) -> Failure | None:
        if self.name not in evidence.stop:
            return None
        force = evidence.trace.grip_force[evidence.last]
        where = region(float(evidence.trace.armscye_s[evidence.last]))
        detail = f"the cloth slipped from the fingers at {force:.1f} N"
        return evidence.failure(self, evidence.last, detail, where)


class OverStrain(Rule):
    """The cloth is not stretched too far for longer than a moment."""

    name, title, colour = "over_strain", "the cloth was stretched", "#009e73"
    ends = True
    thresholds = ("strain", "strain_percentile", "moment")

    def exceeded(self, now: Limited, thresholds: Thresholds) -> tuple[bool, ...]:
        return (now.strain > thresholds.strain,)

    def patience(self, thresholds: Thresholds) -> float:
        return thresholds.moment

    def margin(self, evidence: Evidence) -> float:
        return evidence.thresholds.strain - _sustained(evidence.trace.strain, evidence)

    def failure(self, evidence: Evidence) -> Failure | None:
        if self.name not in evidence.stop:
            return None
        begin = len(evidence.trace) - evidence.stop[self.name]
        where = region(float(evidence.trace.armscye_s[begin]))
        strained = 100.0 * evidence.trace.strain[begin:].max()
        detail = f"the cloth was stretched by {strained:.0f} % at the {where}"
        return evidence.failure(self, begin, detail, where)


class OverForce(Rule):
    """Neither the pull on the cloth nor its force on a link is too large for longer than a moment.

    The margin is the pull's, or the links' if that is smaller.
    """

    name, title, colour = "over_force", "the cloth was pulled too hard", "#882255"
    ends, unit = True, "N"
    thresholds = ("grip_force", "link_force", "moment")

    def exceeded(self, now: Limited, thresholds: Thresholds) -> tuple[bool, ...]:
        return now.grip_force > thresholds.grip_force, now.link_force > thresholds.link_force

    def patience(self, thresholds: Thresholds) -> float:
        return thresholds.moment

    def margin(self, evidence: Evidence) -> float:
        limits, trace = evidence.thresholds, evidence.trace
        links = np.linalg.norm(trace.link_force, axis=2).max(axis=1)
        return min(
            limits.grip_force - _sustained(trace.grip_force, evidence),
            limits.link_force - _sustained(links, evidence),
        )

    def failure(self, evidence: Evidence) -> Failure | None:
        if self.name not in evidence.stop:
            return None
        begin = len(evidence.trace) - evidence.stop[self.name]
        where = region(float(evidence.trace.armscye_s[begin]))
        trace, limits = evidence.trace[begin:], evidence.thresholds
        pull, links = trace.grip_force.max(), np.linalg.norm(trace.link_force, axis=2).max(axis=0)
        told = []
        if pull > limits.grip_force:
            told.append(f"the cloth was pulled with {pull:.1f} N at the {where}")
        for i in np.flatnonzero(links > limits.link_force):
            link = trace.links[i].replace("_", " ")
            told.append(f"the cloth pressed the {link} with {links[i]:.1f} N")
        return evidence.failure(self, begin, " and ".join(told), where)


def _sustained(values: NDArray[np.float64], evidence: Evidence) -> float:
    """The most that a column stays at or above for longer than a moment."""
    rows = min(round(evidence.thresholds.moment / evidence.trace.dt) + 1, len(values))
    return float(np.lib.stride_tricks.sliding_window_view(values, rows).min(axis=1).max())


UNANSWERED, UNREACHABLE = Unanswered(), Unreachable()

#: Every rule, in the order in which tables list failures. A new rule is one more entry.
RULES: tuple[Rule, ...] = (
    UNANSWERED,
    UNREACHABLE,
    Timeout(),
    StoppedShort(),
    Stuck(),
    RingOff(),
    Hit(),
    GraspLost(),
    OverStrain(),
    OverForce(),
)


#: Names of all rules, in the order in which tables list failures.
REASONS: tuple[str, ...] = tuple(rule.name for rule in RULES)


def count_reasons(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How many outcomes report each failure, in the rules' order; what does not occur is left out.

    Failures of rules that are not ours come last, by name.
    """
    order = in_order({reason for outcome in outcomes for reason in outcome.reasons})
    return {name: sum(name in outcome.reasons for outcome in outcomes) for name in order}


def in_order(names: Set[str]) -> list[str]:
    """Names of rules in the rules' order; those that are not ours come last, by name."""
    return [name for name in REASONS if name in names] + sorted(names - set(REASONS))


def rule_colour(name: str) -> str:
    """The colour of a rule's failures in plots; that of any rule for one that is not ours."""
    return next((rule.colour for rule in RULES if rule.name == name), Rule.colour)
