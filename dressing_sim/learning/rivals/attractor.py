"""DS-GMR: a spring and a damper drawn by an attractor that a task-parameterized mixture leads.

Each demonstration is the motion of a mass that is pulled to a virtual attractor y:

    x'' = k (y - x) - d x',     so     y = x + (x'' + d x') / k.

Attractors' paths are learned as a mixture over time in all frames; in a new situation the
regression gives y(t), and the mass follows from where it is. A start that nobody demonstrated, or a
push, is forgotten as fast as the spring allows.

Source: Calinon, Li, Alizadeh, Tsagarakis and Caldwell (2012), "Statistical dynamical systems for
skills acquisition in humanoids", IEEE-RAS Humanoids.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.fusion import over_time, time_mixture
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.springs import ALPHA, forces, rollout

#: k over the duration squared; the damping of `springs` is the critical one.
STIFFNESS = 0.25 * ALPHA**2


@dataclass(frozen=True, slots=True)
class VirtualAttractor(Method):
    """DS-GMR with frames, see the module."""

    components: int = 6
    """K."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The attractors' mixture."""
        led = np.stack([attractor(path) for path in shown.points])
        # The last row's has no step to be told by.
        told = replace(shown, points=led[:, :-1])
        bands = over_time(time_mixture(told, self.components, self.floor), shown.phase)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return drawn(bands.in_world(frames).fused().means, start)

        return skill


def attractor(path: FloatArray) -> FloatArray:
    """Where the attractor of a path (N, p) that begins at rest is at each row: (N, p)."""
    origin = np.zeros(path.shape[1])
    return forces(path, origin) / STIFFNESS


def drawn(attractor: FloatArray, start: FloatArray) -> FloatArray:
    """The path (N, p) from rest at a start (p,) that an attractor's path (N, p) draws."""
    return rollout(STIFFNESS * attractor, start, np.zeros_like(start))
