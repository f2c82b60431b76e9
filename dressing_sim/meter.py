"""The instruments: from a running world to the rows of a trace."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.trace import Limited, Trace
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
        self._forget_hits()

    def _forget_hits(self) -> None:
        self._hit_by = np.full(len(LINKS), -1)
        self._hit_force = np.zeros(len(LINKS))

    def feel(self) -> None:
        """Feel for touches of the robot; to be called after every physics step."""
        for touch in self._world.touches():
            if self._hit_by[touch.link] < 0 or touch.force > self._hit_force[touch.link]:
                self._hit_by[touch.link] = touch.robot_link
                self._hit_force[touch.link] = touch.force

    def read(self, target: NDArray[np.float64]) -> Limited:
        """Measure now; `target` is where the gripper should be, (3,) [m]."""
        world, tcp, cloth = self._world, self._world.tcp_position, self._world.cloth
        strain = self._gauge.principal(cloth)
        forces = world.cloth_forces()
        now = Limited(
            strain=self._gauge.percentile(strain, self._percentile),
            grip_force=float(np.linalg.norm(world.grip_load)),
            link_force=np.linalg.norm(forces.net, axis=1),
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
                "strain": now.strain,
                "strain_max": strain.max(),
                "holding": now.holding,
                "grip_force": now.grip_force,
                "link_force": now.link_force,
                "link_normal_force": forces.normal,
                "hit_by": self._hit_by,
                "hit_force": self._hit_force,
            }
        )
        self._rings.append(world.mesh.rings(cloth))
        self._forget_hits()
        return now

    def trace(self, dt: float) -> Trace:
        """All readings so far, `dt` seconds apart."""
        limits = joint_limits()
        columns: dict[str, NDArray[Any]] = {
            name: np.array([row[name] for row in self._rows]) for name in self._rows[0]
        }
        return Trace(
            dt=dt,
            links=LINKS,
            robot_links=self._world.robot_links,
            torque_limit=limits.effort,
            speed_limit=limits.velocity,
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
