"""A generated path with what is known of it: why it ended, and how far from the data it went."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from dressing_sim.checks import of_kind, whole_number
from dressing_sim.learning.density import definite_factors
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.gmr import Regression

Ending = Literal["end", "rest", "time", "left"]

#: Paths drawn at once; more are not meant.
MOST_PATHS = 100_000


@dataclass(frozen=True, eq=False)
class Motion:
    """A generated path.

    Attributes:
        positions: (T, p) in world coordinates.
        dt: time between two of them in [s].
        ended: why it ended: ``"end"``, where demonstrations end was reached; ``"rest"``, it came
            to rest; ``"time"``, its time was over; ``"left"``, it is where no demonstration ever
            was, and its time was over there, or it came to rest or was stopped there.
        deviations: how many standard deviations each position is from what was learned (T,).
    """

    positions: FloatArray
    dt: float
    ended: Ending
    deviations: FloatArray


def minimum_jerk(phase: FloatArray) -> FloatArray:
    """From 0 to 1 with rest at both ends (Flash and Hogan 1985), phases clipped to [0, 1]."""
    x = np.clip(phase, 0.0, 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


def drawn_paths(
    regression: Regression,
    start: FloatArray,
    n_samples: int,
    longest_step: float,
    count: int,
    rng: np.random.Generator,
) -> FloatArray:
    """Paths x_{t+1} = x_t + dx, dx drawn from p(dx | x_t) = N(E[dx | x_t], Cov[dx | x_t]).

    Args:
        regression: of displacement on position.
        start: of all of them, (p,).
        n_samples: T of each.
        longest_step: no step is longer.
        count: how many.
        rng: where the randomness comes from.

    Returns:
        Positions (count, T, p).
    """
    check_draw(count, rng)
    paths = np.empty((count, n_samples, len(start)))
    paths[:, 0] = start
    for t in range(n_samples - 1):
        means, covariances = regression(paths[:, t])
        normal = rng.standard_normal(means.shape)
        steps = means + np.einsum("nij,nj->ni", definite_factors(covariances), normal)
        lengths = np.linalg.norm(steps, axis=1, keepdims=True)
        steps *= np.minimum(1.0, longest_step / np.maximum(lengths, 1e-300))
        paths[:, t + 1] = paths[:, t] + steps
    return paths


def check_draw(count: int, rng: np.random.Generator) -> None:
    """Raise InvalidInputError unless so many paths can be drawn with this generator."""
    whole_number(count, "the number of paths", 1, MOST_PATHS)
    of_kind(rng, np.random.Generator, "rng", "a random generator of numpy's")
