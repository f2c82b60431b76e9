"""A Gaussian mixture in one situation: how likely points are there, and points drawn from it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import of_kind, real_array, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray

MOST_DRAWN = 10_000_000  # points drawn at once; more are not meant


@dataclass(frozen=True, eq=False)
class GaussianMixture:
    """sum_k pi_k N(mu_k, S_k) in world coordinates.

    Attributes:
        priors: pi, (K,).
        means: mu, (K, D).
        covariances: S, (K, D, D).
    """

    priors: FloatArray
    means: FloatArray
    covariances: FloatArray

    def marginal(self, n_dims: int) -> Self:
        """The mixture of the first coordinates alone."""
        whole_number(n_dims, "the number of coordinates", 1, self.means.shape[1])
        return type(self)(
            self.priors, self.means[:, :n_dims], self.covariances[:, :n_dims, :n_dims]
        )

    def log_density(self, points: ArrayLike) -> FloatArray:
        """log sum_k pi_k N(x | mu_k, S_k) of points (N, D): (N,)."""
        squares, log_dets = self._whitened(points)
        n_dims = self.means.shape[1]
        with np.errstate(divide="ignore"):  # an empty component weighs exp(-inf) = 0
            weights = np.log(self.priors)[:, None]
        logs = weights - 0.5 * (squares + log_dets[:, None] + n_dims * np.log(2.0 * np.pi))
        largest = logs.max(axis=0)
        return np.asarray(largest + np.log(np.exp(logs - largest).sum(axis=0)))

    def deviations(self, points: ArrayLike) -> FloatArray:
        """How many standard deviations points (N, D) are from the nearest component's mean: (N,).

        min_k ((x - mu_k)^T S_k^-1 (x - mu_k))^(1/2), whatever the unit.
        """
        squares, _ = self._whitened(points)
        return np.sqrt(squares.min(axis=0))

    def sample(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points (count, D) drawn independently of each other."""
        whole_number(count, "the number of points", 0, MOST_DRAWN)
        of_kind(rng, np.random.Generator, "rng", "a random generator of numpy's")
        components = rng.choice(len(self.priors), size=count, p=self.priors / self.priors.sum())
        normal = rng.standard_normal((count, self.means.shape[1]))
        factors = definite_factors(self.covariances)
        return self.means[components] + np.einsum("nij,nj->ni", factors[components], normal)

    def _whitened(self, points: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Squared distances (K, N) from the means in standard deviations, and log det S (K,)."""
        values = real_array(points, ("N", self.means.shape[1]), "points have")
        factors = definite_factors(self.covariances)
        centred = (values[None] - self.means[:, None]).transpose(0, 2, 1)
        squares = (np.linalg.solve(factors, centred) ** 2).sum(axis=1)
        diagonals = np.diagonal(factors, axis1=1, axis2=2)
        return squares, 2.0 * np.log(diagonals).sum(axis=1)


def definite_factors(covariances: FloatArray) -> FloatArray:
    """Lower Cholesky factors (..., D, D) of covariances.

    Raises:
        InvalidInputError: one is singular.
    """
    try:
        return np.asarray(np.linalg.cholesky(covariances))
    except np.linalg.LinAlgError as error:
        raise InvalidInputError(
            "a covariance is singular: use a larger covariance floor or fewer components"
        ) from error
