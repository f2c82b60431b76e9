"""What was measured in a dressing, row by row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

#: Parts of the arm by the arm coordinate (0 wrist, 1 elbow, 2 shoulder) at which they begin.
_REGIONS = (
    (-np.inf, "hand"),
    (0.0, "forearm"),
    (0.75, "elbow"),
    (1.35, "upper arm"),
    (1.85, "shoulder"),
)

#: The gripper is near the arm when it is this close to its surface [m].
NEAR = 0.10

#: Fields of a trace that have no rows.
_CONSTANT = ("dt", "links", "robot_links")


def region(s: float) -> str:
    """Part of the arm at an arm coordinate."""
    return [name for start, name in _REGIONS if s >= start][-1]


class Limited(NamedTuple):
    """What has a limit, in one row of a trace: see there."""

    time: float
    strain: float
    grip_force: float
    link_force: float
    hit: bool
    holding: bool


@dataclass(frozen=True, slots=True)
class Trace:
    """What was measured in an episode, one row each control step; it can be sliced by rows.

    Attributes:
        dt: Time between two rows [s].
        links: Names of the mannequin's links, n_links.
        robot_links: Names of the robot's links.
        tcp: Gripper, shape (n, 3), in the robot's base frame [m]; as all that is read off places
            in the world, of one physics step before the joints' row.
        clearance: Distance from the gripper to the arm's surface, shape (n,) [m].
        tracking_error: Distance between gripper and target at that time, shape (n,) [m].
        joint_position: Of the arm, shape (n, 7) [rad].
        joint_velocity: Of the arm, shape (n, 7) [rad/s].
        torque: Of the arm's joints, gravity compensation included, shape (n, 7) [N m].
        limit_ratio: How near the arm's joints came to the limits of position, speed and torque, in
            any physics step since the row before, shape (n, 3); 1 at the limit, and for positions
            0 in the middle of the range.
        armscye_s: Arm coordinate of the armscye's centre, shape (n,).
        hem_s: Arm coordinate of the hem's centre, shape (n,).
        wound: Whether every ring of the sleeve winds once round the arm, shape (n,).
        dressed_ratio: Shares of the upper arm and of the whole arm that the armscye has passed,
            shape (n, 2); zero while it does not wind round the arm.
        line_triangle_on: Whether the line-triangle test says that the sleeve is on the arm, (n,).
        line_triangle_ratio: The shares dressed by that test, shape (n, 2).
        strain: Principal strain at the percentile of the area that is judged, shape (n,).
        strain_median: The same of half the area, shape (n,).
        strain_max: Strain of the most strained triangle, shape (n,).
        edge_strain: Strain of the mesh's edges at the same percentile of their length, shape (n,).
        holding: Whether the gripper still holds the cloth, shape (n,).
        grip_force: Pull of the gripper on the cloth, as a force sensor reads it, shape (n,) [N].
        link_force: Net force of the cloth on each link, as a force sensor reads it, shape
            (n, n_links, 3), in the robot's base frame [N].
        link_normal_force: Sum of the cloth's normal forces on each link, as a sensor reads it,
            shape (n, n_links) [N].
        penetration: How deep the cloth was in the mannequin since the row before where it was
            deepest, shape (n,) [m].
        hit_by: Index in `robot_links` of the link that hit each link of the mannequin hardest
            since the row before, -1 where none did, shape (n, n_links).
        hit_force: Normal force with which it did, shape (n, n_links) [N].
        arm: Wrist, elbow and shoulder joint, shape (n, 3, 3), in the robot's base frame [m]; None
            of an arm that stays in its posture.
    """

    dt: float
    links: tuple[str, ...]
    robot_links: tuple[str, ...]
    tcp: NDArray[np.float64]
    clearance: NDArray[np.float64]
    tracking_error: NDArray[np.float64]
    joint_position: NDArray[np.float64]
    joint_velocity: NDArray[np.float64]
    torque: NDArray[np.float64]
    limit_ratio: NDArray[np.float64]
    armscye_s: NDArray[np.float64]
    hem_s: NDArray[np.float64]
    wound: NDArray[np.bool_]
    dressed_ratio: NDArray[np.float64]
    line_triangle_on: NDArray[np.bool_]
    line_triangle_ratio: NDArray[np.float64]
    strain: NDArray[np.float64]
    strain_median: NDArray[np.float64]
    strain_max: NDArray[np.float64]
    edge_strain: NDArray[np.float64]
    holding: NDArray[np.bool_]
    grip_force: NDArray[np.float64]
    link_force: NDArray[np.float64]
    link_normal_force: NDArray[np.float64]
    penetration: NDArray[np.float64]
    hit_by: NDArray[np.intp]
    hit_force: NDArray[np.float64]
    arm: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        return len(self.tcp)

    def __getitem__(self, rows: slice) -> Trace:
        names = [f.name for f in fields(self) if f.name not in _CONSTANT]
        columns = {name: getattr(self, name) for name in names}
        return replace(self, **{n: c[rows] for n, c in columns.items() if c is not None})

    def shoulder(self, still: NDArray[np.float64]) -> NDArray[np.float64]:
        """Shoulder joint in each row, (n, 3), or that of a still arm, (3,), as given [m]."""
        return still if self.arm is None else self.arm[:, 2]

    def limited(self) -> Iterator[Limited]:
        """What has a limit, row by row."""
        columns = (
            self.strain,
            self.grip_force,
            np.linalg.norm(self.link_force, axis=2).max(axis=1),
            np.any(self.hit_by >= 0, axis=1),
            self.holding,
        )
        rows = zip(*(column.tolist() for column in columns), strict=True)
        for number, row in enumerate(rows, start=1):
            yield Limited(number * self.dt, *row)

    def metrics(self, shoulder: NDArray[np.float64]) -> dict[str, float]:
        """The measurements at the end and at their extremes, SI units.

        Args:
            shoulder: Shoulder joint (3,) of a still arm, in the robot's base frame [m].
        """
        upper_arm, whole_arm = self.dressed_ratio[-1]
        speed = np.linalg.norm(np.diff(self.tcp, axis=0), axis=1) / self.dt
        near = speed[self.clearance[1:] < NEAR]
        net = np.linalg.norm(self.link_force, axis=2).max(axis=0)
        normal = self.link_normal_force.max(axis=0)
        position_ratio, speed_ratio, torque_ratio = self.limit_ratio.max(axis=0)
        values = {
            "duration": len(self) * self.dt,
            "armscye_s": self.armscye_s[-1],
            "gripper_distance": np.linalg.norm((self.tcp - self.shoulder(shoulder))[-1]),
            "upper_arm_dressed_ratio": upper_arm,
            "whole_arm_dressed_ratio": whole_arm,
            "line_triangle_on": self.line_triangle_on[-1],
            "line_triangle_ratio": self.line_triangle_ratio[-1, 0],
            "strain": self.strain.max(),
            "strain_median": self.strain_median.max(),
            "strain_max": self.strain_max.max(),
            "edge_strain": self.edge_strain.max(),
            "grip_force": self.grip_force.max(),
            "link_force": net.max(),
            "link_normal_force": normal.max(),
            **{f"{link}_force": net[i] for i, link in enumerate(self.links)},
            **{f"{link}_normal_force": normal[i] for i, link in enumerate(self.links)},
            "penetration": self.penetration.max(),
            "hit_force": self.hit_force.max(),
            "tracking_error": self.tracking_error.max(),
            "speed_near_arm": near.max(initial=0.0),
            "torque": np.abs(self.torque).max(),
            "torque_ratio": torque_ratio,
            "joint_speed_ratio": speed_ratio,
            "joint_position_ratio": position_ratio,
        }
        return {name: float(value) for name, value in values.items()}
