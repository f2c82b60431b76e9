"""The instruments: from a running world to the rows of a trace."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.episode.trace import Limited, Trace
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.panda import joint_limits
from dressing_sim.world.simulation import World
from dressing_sim.world.strain import StrainGauge

#: Rows of which the windings are counted at a time; keeps the arrays small.
_CHUNK = 64


class Meter:
    """Reads a running world, one row of a `Trace` at a time.

    What has no limit is worked out for all rows together, in the end.

    Args:
        world: The world to measure.
        strain_percentile: Which part of the cloth's area the strain is read for [%].
    """

    def __init__(self, world: World, strain_percentile: float) -> None:
        self._world = world
        self._axis = ArmAxis.of(world.posture)
        self._gauge = StrainGauge(world.mesh)
        self._percentile = strain_percentile
        self._rows: list[dict[str, object]] = []
        self._rings: list[NDArray[np.float64]] = []
        limits = joint_limits()
        self._middle = 0.5 * (limits.upper + limits.lower)
        # Of positions, counted from the middle of their range, speeds and torques.
        half = 0.5 * (limits.upper - limits.lower)
        self._limits = np.array([half, limits.velocity, limits.effort])
        self._forget()

    def _forget(self) -> None:
        """What is since the row before begins anew."""
        self._limit_ratio = np.zeros(3)
        self._hit_by = np.full(len(LINKS), -1)
        self._hit_force = np.zeros(len(LINKS))

    def feel(self) -> None:
        """Look at what no physics step may do; to be called after each of them."""
        world = self._world
        used = [world.arm_configuration - self._middle, world.arm_velocity, world.arm_torque]
        ratio = np.abs(np.array(used) / self._limits).max(axis=1)
        self._limit_ratio = np.maximum(self._limit_ratio, ratio)
        for touch in world.touches():
            if self._hit_by[touch.link] < 0 or touch.force > self._hit_force[touch.link]:
                self._hit_by[touch.link] = touch.robot_link
                self._hit_force[touch.link] = touch.force

    def read(self, target: NDArray[np.float64]) -> Limited:
        """Measure now; `target` (3,) is where `World.tcp_position` should be [m]."""
        world, tcp, cloth = self._world, self._world.tcp_position, self._world.cloth
        gauge, percentile = self._gauge, self._percentile
        strain, forces = gauge.principal(cloth), world.cloth_load
        now = Limited(
            strain=gauge.percentile(strain, percentile),
            grip_force=float(np.linalg.norm(world.grip_load)),
            link_force=float(np.linalg.norm(forces.net, axis=1).max()),
            hit=bool((self._hit_by >= 0).any()),
            holding=world.holding,
        )
        self._rows.append(
            {
                "tcp": tcp,
                "tracking_error": np.linalg.norm(tcp - target),
                "joint_position": world.arm_configuration,
                "joint_velocity": world.arm_velocity,
                "torque": world.arm_torque,
                "limit_ratio": self._limit_ratio,
                "strain": now.strain,
                "strain_median": gauge.percentile(strain, 50.0),
                "strain_max": strain.max(),
                "edge_strain": gauge.edge_percentile(cloth, percentile),
                "holding": now.holding,
                "grip_force": now.grip_force,
                "link_force": forces.net,
                "link_normal_force": forces.normal,
                "hit_by": self._hit_by,
                "hit_force": self._hit_force,
            }
        )
        self._rings.append(world.mesh.rings(cloth))
        self._forget()
        return now

    def trace(self, dt: float) -> Trace:
        """All readings so far, `dt` seconds apart."""
        columns: dict[str, NDArray[Any]] = {
            name: np.array([row[name] for row in self._rows]) for name in self._rows[0]
        }
        return Trace(
            dt=dt,
            links=LINKS,
            robot_links=self._world.robot_links,
            clearance=self._world.clearance(columns["tcp"]),
            **columns,
            **self._progress(),
        )

    def _progress(self) -> dict[str, NDArray[Any]]:
        """Where the rings are: the columns that say how far the sleeve is on."""
        axis, rings = self._axis, np.array(self._rings)
        parts = np.array_split(rings, len(rings) // _CHUNK + 1)
        windings = np.concatenate([axis.winding(part) for part in parts])
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
