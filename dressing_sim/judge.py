"""The rules of success: what was measured in an episode becomes an outcome.

Success, after Zhu, Gienger, Kober (2022), Section V: the gripper reaches above and around the
shoulder, does not hit the mannequin and does not stretch the cloth. Each condition is made
measurable below; each threshold is one field of `Thresholds`. Everything that went wrong is
reported, each reason with when and where it first occurred.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: Every reason an episode can fail for, in the order in which tables list them.
REASONS = (
    "ik_unreachable",
    "timeout",
    "stopped_short",
    "stuck",
    "ring_off",
    "hit",
    "over_strain",
    "over_force",
)

#: Names of the parts of the arm by the arm coordinate at which they begin.
_REGIONS = (
    (-np.inf, "hand"),
    (0.0, "forearm"),
    (0.75, "elbow"),
    (1.35, "upper arm"),
    (1.85, "shoulder"),
)


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
    """Largest net force of cloth on one link of the arm [N]: a third of the 140 to 160 N that
    ISO/TS 15066 allows on hand and arm, quasi-static."""
    moment: float = 0.2
    """Strain and force may exceed their thresholds for no longer than this in one go [s]."""


@dataclass(frozen=True, slots=True)
class Trace:
    """What was measured in an episode, one row each control step.

    Attributes:
        dt: Time between two rows [s].
        links: Names of the mannequin's links, n_links.
        tcp: Gripper, shape (n, 3), in the robot's base frame [m].
        armscye_s: Arm coordinate of the armscye's centre, shape (n,).
        wound: Whether every ring of the sleeve winds once round the arm, shape (n,).
        strain: Strain at the percentile judged, shape (n,).
        strain_max: Strain of the most strained triangle, shape (n,).
        grip_force: Pull of the gripper on the cloth, shape (n,) [N].
        link_force: Net force of the cloth on each link, shape (n, n_links) [N].
        hit: Whether the robot touches each link, shape (n, n_links).
        hit_force: Net force of the robot on each link, shape (n, n_links) [N].
        tracking_error: Distance between gripper and target, shape (n,) [m].
        torque: Servo torques, shape (n, 7) [N m].
    """

    dt: float
    links: tuple[str, ...]
    tcp: NDArray[np.float64]
    armscye_s: NDArray[np.float64]
    wound: NDArray[np.bool_]
    strain: NDArray[np.float64]
    strain_max: NDArray[np.float64]
    grip_force: NDArray[np.float64]
    link_force: NDArray[np.float64]
    hit: NDArray[np.bool_]
    hit_force: NDArray[np.float64]
    tracking_error: NDArray[np.float64]
    torque: NDArray[np.float64]

    def __len__(self) -> int:
        return len(self.tcp)


@dataclass(frozen=True, slots=True)
class Failure:
    """One thing that went wrong.

    Attributes:
        reason: One of `REASONS`.
        detail: What exactly, in words.
        time: When it first occurred, since the robot began to move [s]; None if not in time.
        s: Arm coordinate of the armscye's centre at that moment; None if not known.
    """

    reason: str
    detail: str
    time: float | None = None
    s: float | None = None


@dataclass(frozen=True, slots=True)
class Outcome:
    """The verdict on one episode.

    Attributes:
        success: Whether the arm is dressed and nothing went wrong on the way.
        failures: Everything that went wrong, one entry a reason.
        figures: The measurements behind the verdict, SI units.
        void: Why the simulation cannot be trusted, or None; a void episode is neither a success
            nor a failure of the policy.
    """

    success: bool
    failures: tuple[Failure, ...] = ()
    figures: Mapping[str, float] = field(default_factory=dict)
    void: str | None = None

    @property
    def reasons(self) -> tuple[str, ...]:
        """Names of everything that went wrong."""
        return tuple(failure.reason for failure in self.failures)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a JSON file."""
        return {
            "success": self.success,
            "void": self.void,
            "failures": [
                {"reason": f.reason, "detail": f.detail, "time": f.time, "s": f.s}
                for f in self.failures
            ],
            "figures": dict(self.figures),
        }


def region(s: float) -> str:
    """Part of the arm at an arm coordinate."""
    return [name for start, name in _REGIONS if s >= start][-1]


def first_excess(values: NDArray[np.float64], limit: float, rows: int) -> int | None:
    """Row at which values have exceeded a limit for more than `rows` rows in one go, or None."""
    run = 0
    for row, above in enumerate(values > limit):
        run = run + 1 if above else 0
        if run > rows:
            return row - rows
    return None


def judge(
    trace: Trace,
    shoulder: NDArray[np.float64],
    finished: bool,
    thresholds: Thresholds | None = None,
) -> Outcome:
    """Judge a simulated episode.

    Args:
        trace: What was measured.
        shoulder: Shoulder joint (3,), in the robot's base frame [m].
        finished: Whether the robot came to the end of its path before the time limit.
        thresholds: The rules.

    Returns:
        The outcome, with all reasons.
    """
    rules = thresholds or Thresholds()
    failures: list[Failure] = []

    def add(reason: str, detail: str, row: int) -> None:
        failures.append(Failure(reason, detail, (row + 1) * trace.dt, float(trace.armscye_s[row])))

    last = len(trace) - 1
    held = slice(max(0, len(trace) - round(rules.hold_time / trace.dt)), None)
    gripper = np.linalg.norm(trace.tcp - shoulder, axis=1)
    above = trace.tcp[:, 2] > shoulder[2]
    if not finished:
        add("timeout", "the time limit came before the path's end", last)
    if not (np.all(gripper[held] <= rules.gripper_distance) and np.all(above[held])):
        side = "" if above[last] else ", below it"
        add(
            "stopped_short",
            f"the gripper ended {gripper[last]:.3f} m from the shoulder{side}",
            last,
        )
    elif not np.all(trace.armscye_s[held] >= rules.armscye_s):
        s = float(trace.armscye_s[last])
        add("stuck", f"the armscye stayed at the {region(s)}, s = {s:.2f}", last)
    if not np.all(trace.wound[held]):
        row = _start_of_last_run(~trace.wound)
        s = float(trace.armscye_s[row])
        add("ring_off", f"the sleeve came off the arm at the {region(s)}", row)
    if trace.hit.any():
        row = int(np.argmax(trace.hit.any(axis=1)))
        touched = [trace.links[i] for i in np.flatnonzero(trace.hit.any(axis=0))]
        add("hit", f"the robot touched {', '.join(touched)}", row)
    moment = round(rules.moment / trace.dt)
    row_strain = first_excess(trace.strain, rules.strain, moment)
    if row_strain is not None:
        where = region(float(trace.armscye_s[row_strain]))
        add("over_strain", f"the cloth was stretched too far at the {where}", row_strain)
    links = trace.link_force.max(axis=1)
    row_force = _earliest(
        first_excess(trace.grip_force, rules.grip_force, moment),
        first_excess(links, rules.link_force, moment),
    )
    if row_force is not None:
        where = region(float(trace.armscye_s[row_force]))
        add("over_force", f"the cloth was pulled too hard at the {where}", row_force)
    return Outcome(
        success=not failures,
        failures=tuple(sorted(failures, key=lambda f: REASONS.index(f.reason))),
        figures=_figures(trace, gripper),
    )


def _figures(trace: Trace, gripper: NDArray[np.float64]) -> dict[str, float]:
    return {
        "duration": len(trace) * trace.dt,
        "armscye_s": float(trace.armscye_s[-1]),
        "gripper_distance": float(gripper[-1]),
        "strain": float(trace.strain.max()),
        "strain_max": float(trace.strain_max.max()),
        "grip_force": float(trace.grip_force.max()),
        "link_force": float(trace.link_force.max()),
        "hit_force": float(trace.hit_force.max()),
        "tracking_error": float(trace.tracking_error.max()),
        "torque": float(np.abs(trace.torque).max()),
    }


def _earliest(*rows: int | None) -> int | None:
    return min((row for row in rows if row is not None), default=None)


def _start_of_last_run(flags: NDArray[np.bool_]) -> int:
    """First row of the last uninterrupted run of true flags."""
    last = int(np.flatnonzero(flags)[-1])
    earlier = np.flatnonzero(~flags[:last])
    return int(earlier[-1]) + 1 if len(earlier) else 0


def count_reasons(outcomes: Sequence[Outcome]) -> dict[str, int]:
    """How many outcomes report each reason; reasons that do not occur are left out."""
    counts = {reason: sum(reason in o.reasons for o in outcomes) for reason in REASONS}
    return {reason: n for reason, n in counts.items() if n}
