"""A line to teach along: where a person who sees the whole arm would lead the gripper."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.control.retiming import retime
from dressing_sim.episode.operator import Operator
from dressing_sim.path import Path
from dressing_sim.viewer.choices import Choices
from dressing_sim.world.scene import grip_start

#: Who points to within this of the line means the line, and of its end the end [m].
_NEAR = 0.05

#: Nobody jumps further along the line at once [m]: where it crosses itself on the screen, the part
#: that is meant is the one where the gripper is.
_FURTHEST = 0.25


@dataclass(frozen=True, eq=False)
class Guide:
    """A line that a hand may lead the gripper along.

    Attributes:
        path: The line.
    """

    path: Path

    @classmethod
    def of(cls, choices: Choices) -> Guide:
        """The scripted operator's way over the chosen arm."""
        start = grip_start(choices.posture, choices.config().world.sleeve)
        return cls(Operator().generate(choices.posture, start))

    def nearest(self, place: NDArray[np.float64]) -> int:
        """Which point of the line is nearest to a place (3,) [m]."""
        return int(np.linalg.norm(self.path.positions - place, axis=1).argmin())

    def left(self, place: NDArray[np.float64]) -> float:
        """Length of the line from the point that is nearest to a place (3,) to its end [m]."""
        ahead = self.path.positions[self.nearest(place) :]
        return float(np.linalg.norm(np.diff(ahead, axis=0), axis=1).sum())

    def pointed_at(
        self, eye: NDArray[np.float64], through: NDArray[np.float64], at: int
    ) -> int | None:
        """Which point of the line somebody means who points from an eye through a place.

        Args:
            eye: Where the ray begins, (3,) [m].
            through: Where it passes, (3,) [m].
            at: The point of the line where the gripper is: the point that is meant is near it.

        Returns:
            The point that is nearest to the ray, or None if that passes the line by. Near the
            line's end it is its last.
        """
        points = self.path.positions
        along = np.concatenate([[0.0], np.linalg.norm(np.diff(points, axis=0), axis=1).cumsum()])
        ray = (through - eye) / np.linalg.norm(through - eye)
        offset = points - eye
        beside = np.linalg.norm(offset - (offset @ ray)[:, None] * ray, axis=1)
        beside[np.abs(along - along[at]) > _FURTHEST] = np.inf
        found = int(beside.argmin())
        if beside[found] >= _NEAR:
            return None
        return len(points) - 1 if along[-1] - along[found] < _NEAR else found

    def way(
        self, begin: NDArray[np.float64], at: int, to: int, dt: float, speed: float
    ) -> NDArray[np.float64]:
        """Places (n, 3), one each `dt` seconds, from a place along the line to one of its points.

        Args:
            begin: Where it begins, (3,) [m].
            at: The point of the line that is nearest to it.
            to: The point where it ends.
            dt: Time between two places [s].
            speed: Largest speed [m/s].
        """
        step = 1 if to >= at else -1
        points = self.path.positions[np.arange(at, to + step, step)]
        return retime(np.vstack([begin, points]), self.path.dt or dt, dt, speed)[1:]
