"""The instruments: from a running world to the rows of a trace."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from dressing_sim.judge import Trace
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.simulation import World
from dressing_sim.world.strain import StrainGauge


class Meter:
    """Reads a running world, one row of a `Trace` at a time.

    Args:
        world: The world to measure.
        strain_percentile: Which part of the cloth's area the strain is read for [%].
    """

    def __init__(self, world: World, strain_percentile: float) -> None:
        self._world = world
        self._axis = ArmAxis.of(world.posture)
        self._gauge = StrainGauge(world.mesh)
        self._percentile = strain_percentile
        self._rows: list[tuple[object, ...]] = []

    def read(self, target: NDArray[np.float64], pull: NDArray[np.float64]) -> None:
        """Measure now; `pull` is the grip's mean force (3,) since the last reading [N]."""
        world = self._world
        cloth, tcp = world.cloth, world.tcp_position
        rings = world.mesh.rings(cloth)
        strain = self._gauge.principal(cloth)
        touched = world.robot_contacts()
        self._rows.append(
            (
                tcp,
                self._axis.coordinate(rings[0].mean(axis=0)[None])[0],
                bool(np.all(self._axis.winding(rings) == 1)),
                self._gauge.percentile(strain, self._percentile),
                strain.max(),
                np.linalg.norm(pull),
                [np.linalg.norm(world.link_force(link)) for link in LINKS],
                [link in touched for link in LINKS],
                [np.linalg.norm(world.link_force(link, "robot")) for link in LINKS],
                np.linalg.norm(tcp - target),
                world.arm_torque,
            )
        )

    def trace(self, dt: float) -> Trace:
        """All readings so far."""
        return Trace(dt, LINKS, *(np.array(column) for column in zip(*self._rows, strict=True)))
