"""Gaussian-process transportation: a demonstration deformed with the points that frames mark.

The points are the frames' origins and the tips of their axes. A rigid motion takes those of the
demonstrated situation as near as it can to those of the new one, and a Gaussian process the rest of
the way; the same map takes the path (`dressing_sim.learning.transport`). Its length scale is the
one of greatest marginal likelihood.

Source: Franzese, Prakash and Kober (2024), "Generalization of task parameterized dynamical systems
using Gaussian process transportation", arXiv:2404.13458.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.registration import corners
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.references import apart, nearest
from dressing_sim.learning.transport import Transport

#: Length scales that are tried, over the distance between the frames.
_LENGTHS = np.geomspace(0.1, 10.0, 25)


@dataclass(frozen=True, slots=True)
class Transportation(Method):
    """GPT, see the module; the demonstration of the nearest situation is transported."""

    reach: float = 0.5
    """Length of the axes, over the distance between the frames."""
    noise: float = 0.03
    """How far a point may be missed, over how far points are displaced."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """Keep the demonstrations."""
        size = float(np.mean([apart(frames) for frames in shown.situations]))

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            one = nearest(shown, frames)
            sources, targets = (
                corners(marked, self.reach * size) for marked in (shown.situations[one], frames)
            )
            maps = [Transport.between(sources, targets, x * size, self.noise) for x in _LENGTHS]
            best = int(np.argmax([evidence(one) for one in maps]))
            return maps[best](shown.points[one])

        return skill


def evidence(transport: Transport) -> float:
    """Log marginal likelihood of a map at the most likely amplitude, but for a constant."""
    count, p = transport.weights.shape
    if transport.amplitude == 0.0:  # the rigid motion left nothing
        return 0.0
    determinant = 2.0 * np.sum(np.log(np.diag(transport.factor)))
    return float(-0.5 * p * determinant - count * p * np.log(transport.amplitude))
