"""Time-based TP-GMM whose frames have weights: learned by trial, or read off their covariances.

The regression is that of `fusion`: a product of the frames' Gaussians with weights w_p on their
precisions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import minimize_scalar

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.registration import smoothed
from dressing_sim.learning.rivals.fusion import Bands, over_time, time_mixture
from dressing_sim.learning.rivals.method import Method, Shown, Skill

#: Of inferred weights: the steepest power, and over which share of a path they are smoothed.
_STEEPEST, _SMOOTH = 125.0, 0.03


@dataclass(frozen=True, slots=True)
class LearnedWeights(Method):
    """Frames' weights found by policy search on how well demonstrations are predicted.

    Weights are w = P softmax(theta). Each update of PI2 draws theta_r = theta + e_r, e_r ~ N(0,
    s^2), and moves theta by the mean of e_r with shares exp(-10 (J_r - min J) / (max J - min J)).
    J is the mean distance of a demonstration from what the others, or with one demonstration it
    itself, predict in its situation.

    Source: Huang, Silverio, Rozo and Caldwell (2018), "Generalized task-parameterized skill
    learning", ICRA, doi:10.1109/ICRA.2018.8461079; the updates: Theodorou, Buchli and Schaal
    (2010), "A generalized path integral control approach to reinforcement learning", JMLR 11.
    """

    may_be_zero: ClassVar[frozenset[str]] = frozenset({"updates"})

    components: int = 6
    """K."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""
    updates: int = 20
    """Of the weights; with none all frames weigh alike, the plain TP-GMM over time."""
    rollouts: int = 10
    """Drawn for each update."""
    exploration: float = 0.5
    """s at the first update; it falls to nothing linearly."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The mixture, and the weights."""
        weights = self.weights(shown, rng)
        bands = over_time(time_mixture(shown, self.components, self.floor), shown.phase)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return bands.in_world(frames).fused(weights).means

        return skill

    def weights(self, shown: Shown, rng: np.random.Generator) -> FloatArray:
        """w, (P,), they sum to P."""
        everything = range(len(shown.points))
        predicted = []
        for one in everything:
            others = [other for other in everything if other != one] or [one]
            mixture = time_mixture(shown.only(others), self.components, self.floor)
            predicted.append(over_time(mixture, shown.phase).in_world(shown.situations[one]))

        def cost(theta: FloatArray) -> float:
            w = _weights(theta)
            pairs = zip(predicted, shown.points, strict=True)
            return float(np.mean([_distance(bands.fused(w).means, path) for bands, path in pairs]))

        theta = np.zeros(len(shown.situations[0]))
        for update in range(self.updates):
            spread = self.exploration * (1.0 - update / self.updates)
            steps = spread * rng.standard_normal((self.rollouts, len(theta)))
            costs = np.array([cost(theta + step) for step in steps])
            share = np.exp(-10.0 * (costs - costs.min()) / max(float(np.ptp(costs)), 1e-300))
            theta = theta + share @ steps / share.sum()
        return _weights(theta)


@dataclass(frozen=True, slots=True)
class InferredWeights(Method):
    """Frames' weights at each phase from how much demonstrations differ there.

        w_p(t) = P |C_p(t)|^g / sum_q |C_q(t)|^g,   g <= 0,

    smoothed over t, with C_p(t) the covariance of the demonstrations' points in frame p,
    regularised, |.| its largest eigenvalue, and g the power that reproduces the demonstrations
    best.

    Source: Sena, Michael and Howard (2019), "Improving task-parameterised movement learning
    generalisation with frame-weighted trajectory generation", IROS, arXiv:1903.01240.
    """

    components: int = 6
    """K."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""
    ridge: float = 1e-2
    """Added to the variances C_p(t), over the scale squared."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The mixture, and the weights."""
        bands = over_time(time_mixture(shown, self.components, self.floor), shown.phase)
        weights = self.weights(shown, bands)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return bands.in_world(frames).fused(weights).means

        return skill

    def weights(self, shown: Shown, bands: Bands) -> FloatArray:
        """w_p(t), (P, N), they sum to P at each phase."""
        local = shown.local
        centred = local - local.mean(axis=0)
        covariances = np.einsum("mpni,mpnj->pnij", centred, centred) / max(len(local) - 1, 1)
        covariances += self.ridge * shown.scale**2 * np.eye(local.shape[-1])
        sizes = np.linalg.eigvalsh(covariances)[..., -1]
        seen = [bands.in_world(frames) for frames in shown.situations]

        def cost(power: float) -> float:
            w = relevance(sizes, power)
            pairs = zip(seen, shown.points, strict=True)
            return float(np.mean([_distance(one.fused(w).means, path) for one, path in pairs]))

        found = minimize_scalar(cost, bounds=(-_STEEPEST, 0.0), method="bounded").x
        return relevance(sizes, min(0.0, float(found), key=cost))


def relevance(sizes: FloatArray, power: float) -> FloatArray:
    """P |C_p(t)|^g / sum_q |C_q(t)|^g of sizes |C_p(t)| (P, N), smoothed over phase."""
    log = power * np.log(sizes)
    share = np.exp(log - log.max(axis=0))
    share = len(share) * share / share.sum(axis=0)
    return smoothed(share.T, _SMOOTH).T


def _weights(theta: FloatArray) -> FloatArray:
    share = np.exp(theta - theta.max())
    return len(share) * share / share.sum()


def _distance(path: FloatArray, other: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum((path - other) ** 2, axis=1))))
