"""Probabilities from features: a regularised logistic regression, calibrated on held-out scores.

    P(success | x) = 1 / (1 + exp(-(w . (x - m) / s + c)))

with m and s the features' means and standard deviations, and w the most likely weights under a
Gaussian prior. Targets are Platt's (1999): (n1 + 1) / (n1 + 2) for a success among n1, and
1 / (n0 + 2) for a failure among n0, which keeps probabilities off zero and one however few episodes
there are. A fit to few episodes is too sure of itself; its scores on episodes that it was not
fitted to say by how much, see `calibrated`.

J. Platt, *Probabilistic outputs for support vector machines* (1999), in Advances in Large Margin
Classifiers.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import real_array, real_number, shown, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray

#: Of Newton's method, which halves a step until the objective falls.
_STEPS, _HALVINGS, _TOLERANCE = 100, 30, 1e-10

#: Keeps the equations solvable where a feature, or a score, is always the same.
_RIDGE = 1e-6


@dataclass(frozen=True, eq=False)
class Logistic:
    """A fitted model.

    Attributes:
        mean: Of each feature, (D,).
        scale: Standard deviation of each, (D,); 1 where it is always the same.
        weights: Of the standardised features, (D,).
        intercept: The score of mean features.
    """

    mean: FloatArray
    scale: FloatArray
    weights: FloatArray
    intercept: float

    def __post_init__(self) -> None:
        size = real_array(self.mean, ("D",), "means of features have").shape
        if not (real_array(self.scale, size, "scales of features have") > 0.0).all():
            raise InvalidInputError(f"scales of features are {shown(self.scale)}, valid is > 0")
        real_array(self.weights, size, "weights of features have")
        real_number(self.intercept, "an intercept")

    @classmethod
    def fit(cls, features: ArrayLike, successes: ArrayLike, penalty: float = 1.0) -> Logistic:
        """The most likely weights.

        Args:
            features: (N, D).
            successes: (N,), true or false.
            penalty: Precision of the prior of each weight; 1 for a prior in which a feature one
                standard deviation off its mean multiplies odds by e or 1/e, give or take.

        Raises:
            InvalidInputError: Shapes that do not fit, or a penalty below zero.
        """
        found = real_array(features, ("N", "D"), "features have", fewest=1)
        happened = np.asarray(successes, dtype=bool)
        if happened.shape != found.shape[:1]:
            raise InvalidInputError(
                f"successes have shape {happened.shape}, valid is ({len(found)},), one an episode"
            )
        real_number(penalty, "penalty", 0.0)
        mean, spread = found.mean(axis=0), found.std(axis=0)
        # What is the same but for rounding says nothing.
        scale = np.where(spread > 1e-9 * (1.0 + np.abs(mean)), spread, 1.0)
        weights, intercept = _newton((found - mean) / scale, _targets(happened), penalty)
        return cls(mean, scale, weights, intercept)

    def score(self, features: ArrayLike) -> FloatArray:
        """The logarithm of the odds of success, (N,), at features (N, D)."""
        found = real_array(features, ("N", len(self.mean)), "features have")
        return np.asarray((found - self.mean) / self.scale @ self.weights + self.intercept)

    def probability(self, features: ArrayLike) -> FloatArray:
        """The probability of success, (N,), at features (N, D)."""
        return _sigmoid(self.score(features))


def calibrated(
    features: ArrayLike, successes: ArrayLike, penalty: float = 1.0, folds: int = 10
) -> Logistic:
    """A fitted model whose scores are rescaled to what such a model is worth on other episodes.

    Each fold is scored by a model of the other folds, and Platt's sigmoid, a score + b, fitted to
    all these scores: a below one where models are too sure of themselves. Scores that say nothing,
    or the contrary, give the same probability to all. A rescaled model is one of the same form.

    Args:
        features: (N, D).
        successes: (N,), true or false.
        penalty: See `Logistic.fit`.
        folds: Into which episodes are dealt, in turn.
    """
    whole_number(folds, "folds", 2)
    whole = Logistic.fit(features, successes, penalty)
    found, happened = np.asarray(features, dtype=np.float64), np.asarray(successes, dtype=bool)
    number = np.arange(len(found)) % folds
    scores = np.zeros(len(found))
    for fold in range(min(folds, len(found)) if len(found) > 1 else 0):
        held = number == fold
        scores[held] = Logistic.fit(found[~held], happened[~held], penalty).score(found[held])
    (slope,), shift = _newton(scores[:, None], _targets(happened), _RIDGE)
    if slope <= 0.0:  # scores are worth nothing
        slope, shift = 0.0, _newton(np.empty((len(found), 0)), _targets(happened), 0.0)[1]
    return Logistic(
        whole.mean, whole.scale, slope * whole.weights, float(slope * whole.intercept + shift)
    )


def _targets(happened: FloatArray) -> FloatArray:
    """Platt's targets (N,)."""
    n1 = int(happened.sum())
    n0 = len(happened) - n1
    return np.where(happened, (n1 + 1.0) / (n1 + 2.0), 1.0 / (n0 + 2.0))


def _newton(x: FloatArray, targets: FloatArray, penalty: float) -> tuple[FloatArray, float]:
    """Weights (D,) and intercept of the least penalised cross-entropy."""
    design = np.column_stack([x, np.ones(len(x))])
    ridge = np.append(np.full(x.shape[1], penalty + _RIDGE), 0.0)

    def objective(at: FloatArray) -> float:
        scores = design @ at
        losses = np.logaddexp(0.0, scores) - targets * scores
        return float(losses.sum() + 0.5 * ridge @ at**2)

    at = np.zeros(design.shape[1])
    for _ in range(_STEPS):
        p = _sigmoid(design @ at)
        gradient = design.T @ (p - targets) + ridge * at
        curvature = (design * (p * (1.0 - p))[:, None]).T @ design + np.diag(ridge)
        step = np.linalg.solve(curvature, gradient)
        now, share = objective(at), 1.0
        for _ in range(_HALVINGS):
            if objective(at - share * step) <= now:
                break
            share *= 0.5
        at = at - share * step
        if np.abs(step).max() < _TOLERANCE:
            break
    return at[:-1], float(at[-1])


def _sigmoid(scores: FloatArray) -> FloatArray:
    return np.asarray(0.5 * (1.0 + np.tanh(0.5 * scores)))
