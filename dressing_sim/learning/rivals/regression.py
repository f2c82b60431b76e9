"""Gaussian mixture regression without task parameters: in the world, or in one frame.

Source: Calinon, Guenter and Billard (2007), "On learning, representing and generalizing a task in a
humanoid robot", IEEE Transactions on Systems, Man and Cybernetics B 37(2),
doi:10.1109/TSMCB.2006.886952. The regression is that of `fusion`, with one frame.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.fusion import over_time, time_mixture
from dressing_sim.learning.rivals.method import Equivariance, Method, Shown, Skill


@dataclass(frozen=True, slots=True)
class WorldRegression(Method):
    """GMM and GMR over time in world coordinates: it does not look at the situation."""

    equivariance: ClassVar[Equivariance] = "nothing"

    components: int = 6
    """K."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The mean path."""
        p = shown.points.shape[-1]
        world = ((Frame(np.eye(p), np.zeros(p)),),) * len(shown.points)
        mixture = time_mixture(
            Shown(shown.points, world, shown.duration), self.components, self.floor
        )
        path = over_time(mixture, shown.phase).means[0]

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return path

        return skill


@dataclass(frozen=True, slots=True)
class FrameRegression(Method):
    """GMM and GMR over time in the coordinates of one frame."""

    frame: Literal["first", "last"] = "first"
    """The shoulder's is the first, the wrist's the last."""
    components: int = 6
    """K."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The mean path in the frame."""
        index = 0 if self.frame == "first" else -1
        alone = tuple((frames[index],) for frames in shown.situations)
        mixture = time_mixture(
            Shown(shown.points, alone, shown.duration), self.components, self.floor
        )
        path = over_time(mixture, shown.phase).means[0]

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return frames[index].to_world(path)

        return skill
