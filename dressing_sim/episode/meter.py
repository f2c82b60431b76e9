"""The instruments: from a running world to the rows of a trace."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.episode.columns import Columns
from dressing_sim.episode.trace import Limited, Trace
from dressing_sim.world.description import joint_limits
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.kernels import longest, near_limits
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.simulation import World
from dressing_sim.world.strain import StrainGauge

#: The column of the vertices' places, which a trace is worked out from but does not hold.
_CLOTH = "cloth"

#: Columns of an arm that moves: its joints, and its coordinates, which no trace holds.
_ARM, _PERSON = "arm", "person"

#: No link of the robot, for each of the mannequin.
_UNTOUCHED = np.full(len(LINKS), -1)


@dataclass(frozen=True, slots=True, eq=False)
class Row:
    """What was measured after one control step.

    Attributes:
        time: Since the robot began to move [s].
        tcp: Gripper (3,), in the robot's base frame [m]; as all that is read off places in the
            world, of one physics step before ``joint_position``.
        tracking_error: Distance between gripper and target at that time [m].
        joint_position: Of the robot's arm, (n,) [rad].
        grip_force: Pull of the gripper on the cloth, as a force sensor reads it [N].
        link_force: Net force of the cloth on each link of `dressing_sim.world.mannequin.LINKS`, as
            a force sensor reads it, (n_links, 3), in the robot's base frame [N].
        hit_force: Normal force with which the robot hit each link since the row before, (n_links,)
            [N].
        hit: Whether it touched one, with a force or without.
        strain: Principal strain at the percentile of the cloth's area that is judged.
        armscye_s: Arm coordinate of the armscye's centre: 0 wrist, 1 elbow, 2 shoulder.
        hem_s: Arm coordinate of the hem's centre.
        holding: Whether the fingers hold the cloth.
    """

    time: float
    tcp: NDArray[np.float64]
    tracking_error: float
    joint_position: NDArray[np.float64]
    grip_force: float
    link_force: NDArray[np.float64]
    hit_force: NDArray[np.float64]
    hit: bool
    strain: float
    armscye_s: float
    hem_s: float
    holding: bool

    def limited(self) -> Limited:
        """What of it has a limit."""
        most = longest(self.link_force)
        return Limited(self.time, self.strain, self.grip_force, most, self.hit, self.holding)


class Meter:
    """Reads a running world, one row of a `Trace` at a time.

    What has no limit and nobody needs at once is worked out for all rows together, in the end.

    Args:
        world: The world to measure.
        dt: Time between two rows [s].
        strain_percentile: Which part of the cloth's area the strain is read for [%].
    """

    def __init__(self, world: World, dt: float, strain_percentile: float) -> None:
        self._world = world
        self._dt = dt
        self._axis = ArmAxis.of(world.posture)
        self._person = world.person
        self._gauge = StrainGauge(world.mesh)
        self._percentile = strain_percentile
        self._ends = [0, world.mesh.along - 1]
        self._columns = Columns()
        self._trace: Trace | None = None
        limits = joint_limits(world.config.robot)
        self._middle = 0.5 * (limits.upper + limits.lower)
        # Of positions, counted from the middle of their range, speeds and torques.
        half = 0.5 * (limits.upper - limits.lower)
        self._limits = np.array([half, limits.velocity, limits.effort])
        self._begin_row()

    def __len__(self) -> int:
        return len(self._columns)

    def _begin_row(self) -> None:
        """What is since the row before begins anew."""
        self._limit_ratio = np.zeros(3)
        self._hit = False
        self._hit_by = _UNTOUCHED.copy()
        self._hit_force = np.zeros(len(LINKS))
        self._penetration = 0.0

    def observe_physics(self) -> None:
        """Look at what no physics step may do; to be called after each of them."""
        world = self._world
        now = world.cloth_load
        near_limits(
            world.arm_configuration,
            world.arm_velocity,
            world.arm_torque,
            self._middle,
            self._limits,
            self._limit_ratio,
        )
        self._penetration = max(self._penetration, now.depth)
        # Asking for touches costs as much as everything else here.
        for touch in world.touches() if now.others else ():
            self._hit = True
            if self._hit_by[touch.link] < 0 or touch.force > self._hit_force[touch.link]:
                self._hit_by[touch.link] = touch.robot_link
                self._hit_force[touch.link] = touch.force

    def read(self, target: NDArray[np.float64]) -> Row:
        """Measure now, and keep it; `target` (3,) is where the gripper should be [m]."""
        row, kept = self._measure(target, len(self) + 1)
        self._columns.append(kept)
        self._trace = None
        self._begin_row()
        return row

    def look(self, target: NDArray[np.float64]) -> Row:
        """Measure now, and keep nothing."""
        return self._measure(target, len(self))[0]

    def _measure(self, target: NDArray[np.float64], number: int) -> tuple[Row, dict[str, Any]]:
        world, tcp, cloth = self._world, self._world.tcp_position, self._world.cloth
        strain, forces = self._gauge.principal(cloth), world.cloth_load
        if self._person is not None:
            self._axis = ArmAxis.of(world.posture, world.arm_joints)
        off, load = tcp - target, world.grip_load
        armscye_s, hem_s = self._axis.ring_coordinate(world.mesh.rings(cloth)[self._ends])
        row = Row(
            time=number * self._dt,
            tcp=tcp,
            tracking_error=sqrt(off.dot(off)),
            joint_position=world.arm_configuration,
            grip_force=sqrt(load.dot(load)),
            link_force=forces.net,
            hit_force=self._hit_force,
            hit=self._hit,
            strain=self._gauge.percentile(strain, self._percentile),
            armscye_s=float(armscye_s),
            hem_s=float(hem_s),
            holding=world.holding,
        )
        kept = {
            "tcp": tcp,
            "tracking_error": row.tracking_error,
            "joint_position": row.joint_position,
            "joint_velocity": world.arm_velocity,
            "torque": world.arm_torque,
            "limit_ratio": self._limit_ratio,
            "strain": row.strain,
            "holding": row.holding,
            "grip_force": row.grip_force,
            "link_force": row.link_force,
            "link_normal_force": forces.normal,
            "penetration": self._penetration,
            "hit_by": self._hit_by,
            "hit_force": self._hit_force,
            _CLOTH: cloth,
        }
        if self._person is not None:
            kept |= {
                _ARM: world.arm_joints,
                _PERSON: world.person,
                "clearance": world.clearance(tcp[None])[0],
            }
        return row, kept

    def person(self, number: int) -> NDArray[np.float64] | None:
        """`World.person` after so many rows; None if it does not move."""
        if self._person is None or number == 0:
            return self._person
        return self._columns.value(_PERSON, number - 1)

    @property
    def persons(self) -> NDArray[np.float64] | None:
        """`World.person` after each row, (n, 7); None if it does not move."""
        return self.columns().get(_PERSON)

    def columns(self) -> dict[str, NDArray[Any]]:
        """All that was kept, an array a column, for `restore`."""
        return self._columns.copies()

    def restore(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """Go on after the rows that `columns` held."""
        self._columns, self._trace = Columns(columns), None
        self._begin_row()

    def trace(self) -> Trace:
        """All rows so far, of which there must be one; the same object until there is another."""
        if self._trace is None:
            self._trace = self._worked_out()
        return self._trace

    def _worked_out(self) -> Trace:
        columns = self.columns()
        cloth, rings = columns.pop(_CLOTH), self._world.mesh.rings
        if self._person is None:
            columns["clearance"] = self._world.clearance(columns["tcp"])
            progress = [_progress(self._axis, rings(cloth))]
        else:
            columns.pop(_PERSON)
            axes = [ArmAxis.of(self._world.posture, joints) for joints in columns[_ARM]]
            rows = zip(axes, rings(cloth)[:, None], strict=True)
            progress = [_progress(axis, row) for axis, row in rows]
        return Trace(
            dt=self._dt,
            links=LINKS,
            robot_links=self._world.robot_links,
            **columns,
            **self._strains(cloth),
            **{name: np.concatenate([one[name] for one in progress]) for name in progress[0]},
        )

    def _strains(self, cloth: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
        """The other strains of a trace, of all vertices' places (n, n_vertices, 3)."""
        gauge = self._gauge
        strains = [gauge.principal(places) for places in cloth]
        return {
            "strain_median": np.array([gauge.percentile(strain, 50.0) for strain in strains]),
            "strain_max": np.array([strain.max() for strain in strains]),
            "edge_strain": np.array(
                [gauge.edge_percentile(places, self._percentile) for places in cloth]
            ),
        }


def _progress(axis: ArmAxis, rings: NDArray[np.float64]) -> dict[str, NDArray[Any]]:
    """Where the rings are on an arm: the columns that say how far the sleeve is on."""
    windings = axis.winding(rings)
    armscye_s = axis.coordinate(rings[:, 0].mean(axis=1))
    triangle_s = axis.through_triangles(rings[:, 0])
    on = np.where(windings[:, 0] == 1, armscye_s, np.nan)
    return {
        "armscye_s": armscye_s,
        "hem_s": axis.coordinate(rings[:, -1].mean(axis=1)),
        "wound": (windings == 1).all(axis=1),
        "dressed_ratio": axis.dressed_ratios(on),
        "line_triangle_on": np.isfinite(triangle_s),
        "line_triangle_ratio": axis.dressed_ratios(triangle_s),
    }
