"""DMP and ProMP of the package ``movement_primitives``, with start, goal and via-points by frames.

Both live in world coordinates. Where demonstrations are at a phase, as a function of the situation,
is `Shown.place`; so the frames enter through points of the path alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.method import Equivariance, Method, Shown, Skill, library
from dressing_sim.learning.rivals.references import nearest

_PACKAGE = "movement_primitives"

#: Steps of integration for one of a path. The package's path runs one step ahead of time.
_FINE = 10

#: A via-point may be missed by this fraction of the scale.
_MISS = 1e-3


@dataclass(frozen=True, slots=True)
class DynamicPrimitive(Method):
    """A dynamic movement primitive whose goal is where the frames say that demonstrations end.

        tau^2 ddy = alpha (beta (g - y) - tau dy) + f(x),   tau dx = -alpha_x x.

    The forcing term f is linear in its weights: their mean over demonstrations is the least-squares
    fit to all. It is not scaled by g - y0: the scale of the motion is that of the demonstrations.

    Source: Ijspeert, Nakanishi, Hoffmann, Pastor and Schaal (2013), "Dynamical movement primitives:
    learning attractor models for motor behaviors", Neural Computation 25(2),
    doi:10.1162/NECO_a_00393.
    """

    equivariance: ClassVar[Equivariance] = "shifts"
    package: ClassVar[str | None] = f"{_PACKAGE}.dmp"
    may_be_zero: ClassVar[frozenset[str]] = frozenset({"ridge"})

    weights: int = 20
    """Basis functions of each coordinate."""
    ridge: float = 1e-6
    """Regularisation of their weights."""
    demonstration: Literal["mean", "nearest"] = "mean"
    """Whose forcing term: that of all, or that of the most alike situation."""
    smooth_scaling: bool = False
    """Whether a changed goal pulls from the start on, or ever more as the motion goes on."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The weights of each demonstration."""
        if self.weights > self.samples:
            raise InvalidInputError(f"weights is {self.weights}, valid is at most {self.samples}")
        p, step = shown.points.shape[2], 1.0 / (_FINE * (self.samples - 1))
        made = library(f"{_PACKAGE}.dmp").DMP(
            p, 1.0, step, self.weights, int_dt=step, smooth_scaling=self.smooth_scaling
        )
        learned = []
        for path in shown.points:
            made.imitate(shown.phase, path, regularization_coefficient=self.ridge)
            learned.append(made.get_weights().copy())  # it is a view
        mean, end = np.mean(learned, axis=0), shown.place(-1)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            alike = self.demonstration == "nearest"
            made.set_weights(learned[nearest(shown, frames)] if alike else mean)
            made.reset()
            made.configure(start_y=start, goal_y=end.predict(frames))
            _, path = made.open_loop()
            return np.asarray(path[::_FINE][: self.samples])

        return skill


@dataclass(frozen=True, slots=True)
class ProbabilisticPrimitive(Method):
    """A probabilistic movement primitive conditioned on where frames say that demonstrations are.

        y(s) = Psi(s)^T w,   w ~ N(mu, S),   mu' = mu + S Psi (Sy + Psi^T S Psi)^-1 (y* - Psi^T mu).

    Source: Paraschos, Daniel, Peters and Neumann (2013), "Probabilistic movement primitives",
    Advances in Neural Information Processing Systems 26, equations 5 and 6.
    """

    equivariance: ClassVar[Equivariance] = "nothing"
    package: ClassVar[str | None] = f"{_PACKAGE}.promp"

    weights: int = 15
    """Basis functions of each coordinate."""
    prior: float = 1e-2
    """Variance of each weight added to what demonstrations say, a fraction of the scale squared;
    few demonstrations span few directions, and outside them no via-point could be met."""
    via_points: int = 3
    """Evenly over the phase, the start and the end among them."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The distribution of the weights: mean and covariance over demonstrations."""
        kind = library(f"{_PACKAGE}.promp").ProMP
        p = shown.points.shape[2]
        made = kind(p, self.weights)
        learned = np.stack([made.weights(shown.phase, path, lmbda=1e-8) for path in shown.points])
        centred = learned - learned.mean(axis=0)
        covariance = centred.T @ centred / max(len(learned) - 1, 1)
        covariance += self.prior * shown.scale**2 * np.eye(len(covariance))
        made.from_weight_distribution(learned.mean(axis=0), covariance)
        rows = np.rint(np.linspace(0, self.samples - 1, max(self.via_points, 2))).astype(int)
        places = [shown.place(int(row)) for row in rows[1:]]
        miss = (_MISS * shown.scale) ** 2 * np.eye(p)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            conditioned = made
            via = [start, *(place.predict(frames) for place in places)]
            for row, point in zip(rows, via, strict=True):
                conditioned = conditioned.condition_position(point, miss, shown.phase[row])
            return np.asarray(conditioned.mean_trajectory(shown.phase))

        return skill
