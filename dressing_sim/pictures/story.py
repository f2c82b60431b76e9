"""What a film tells: what was recorded at each of its moments, and of the episode as a whole."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.world.simulation import World


@dataclass(frozen=True, slots=True, eq=False)
class Moment:
    """One picture's worth of an episode.

    Attributes:
        time: Since the film began [s].
        qpos: Positions of the whole simulated world.
        cloth: Of the sleeve's vertices, shape (n, 3) [m].
        grip_force: Pull of the gripper, as a force sensor reads it [N].
        link_force: Of the cloth on each link of the person, shape (n_links, 3) [N].
        person: Coordinates (7,) of an arm that moves, see `dressing_sim.world.simulation.World`.
    """

    time: float
    qpos: NDArray[np.float64]
    cloth: NDArray[np.float64]
    grip_force: float
    link_force: NDArray[np.float64]
    person: NDArray[np.float64] | None = None

    @classmethod
    def of(cls, world: World, began: float) -> Moment:
        """What there is now, of a world in which the film began at a time [s]."""
        return cls(
            world.time - began,
            world.data.qpos.copy(),
            world.cloth,
            float(np.linalg.norm(world.grip_load)),
            world.cloth_load.net.copy(),
            world.person,
        )

    def arm(self, posture: Posture) -> Posture:
        """Where an arm is now that was in a posture."""
        return posture.moved(self.person)


@dataclass(frozen=True, slots=True, eq=False)
class Story:
    """What is known of the episode as a whole, for captions and overlays.

    Attributes:
        title: Who dresses whom.
        outcome: The verdict, or None if it is not known.
        path: Where the gripper was to go, shape (n, 3) [m], or None.
        demonstrations: Paths that were learned from, each (n, 3), as they were recorded [m].
        thresholds: What the verdict was found with.
    """

    title: str = ""
    outcome: Outcome | None = None
    path: NDArray[np.float64] | None = None
    demonstrations: tuple[NDArray[np.float64], ...] = ()
    thresholds: Thresholds = field(default_factory=Thresholds)

    def verdict(self, time: float, end: float) -> str:
        """What is known at a time [s] of a film that ends at another; empty if nothing is."""
        if self.outcome is None:
            return ""
        known = [f.reason for f in self.outcome.failures if f.time is not None and f.time <= time]
        if time < end - 0.5:
            return known[0] if known else ""
        failed = bool(self.outcome.failures) and self.outcome.invalid is None
        return f"failure: {self.outcome.verdict}" if failed else self.outcome.verdict
