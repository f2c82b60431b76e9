"""How many components: the Bayesian information criterion, and a Dirichlet-process mixture.

Both are what the paper suggests for choosing K (section V).
"""

from collections.abc import Iterable, Sequence
from copy import copy
from dataclasses import dataclass

import numpy as np

from dressing_sim.checks import LARGEST, listed, of_kind, real_number, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import em
from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.tpgmm import MOST_COMPONENTS, TPGMM

NEGLIGIBLE_WEIGHT = 0.01  # a component that explains fewer of the samples does not count


def n_parameters(n_components: int, n_frames: int, n_dims: int, n_shared: int = 0) -> int:
    """Free parameters of a mixture over frames.

    Priors K - 1; for each component the means and the symmetric covariances of all frames, where
    the moments of the first ``n_shared`` coordinates, the same in every frame, count once:

        (K - 1) + K [s + s (s + 1) / 2 + P (q + q s + q (q + 1) / 2)],  q = D - s.

    Args:
        n_components: K.
        n_frames: P.
        n_dims: D.
        n_shared: s, 1 for a time-based model (time), 0 for a trajectory-based one.
    """
    n_components = whole_number(n_components, "n_components", 1)
    n_frames, n_dims = whole_number(n_frames, "n_frames", 1), whole_number(n_dims, "n_dims", 1)
    n_shared = whole_number(n_shared, "n_shared", 0, n_dims)
    own = n_dims - n_shared
    common = n_shared + n_shared * (n_shared + 1) // 2
    per_frame = own + own * n_shared + own * (own + 1) // 2
    return (n_components - 1) + n_components * (common + n_frames * per_frame)


def bic(model: TPGMM, demonstrations: Sequence[DemonstrationLike]) -> float:
    """Bayesian information criterion -2 log L + n_parameters log N; lower is better.

    L is the likelihood the model was fitted to, the product over the frames, and N the number of
    samples (not times the frames: they see the same samples).
    Source: Schwarz (1978), "Estimating the dimension of a model".

    Args:
        model: fitted.
        demonstrations: what it was fitted to.
    """
    of_kind(model, TPGMM, "model", "a TPGMM")
    mixture = model.fitted()
    data, _ = model.samples(demonstrations)
    _, log_likelihood = em.responsibilities(data, mixture)
    shared = 1 if model.encoding == "time" else 0
    count = n_parameters(mixture.n_components, mixture.n_frames, mixture.n_dims, shared)
    return float(-2.0 * log_likelihood + count * np.log(data.shape[2]))


@dataclass(frozen=True)
class BICChoice:
    """The number of components with the lowest criterion.

    Attributes:
        n_components: the choice.
        scores: (K, BIC) of every K that was tried and could be fitted.
    """

    n_components: int
    scores: tuple[tuple[int, float], ...]


def choose_by_bic(
    model: TPGMM, demonstrations: Sequence[DemonstrationLike], candidates: Iterable[int]
) -> BICChoice:
    """Fit ``model`` with each number of components and take the one with the lowest BIC.

    Args:
        model: the settings; it is not changed.
        demonstrations: what is fitted.
        candidates: numbers of components, such as ``range(1, 16)``.

    Raises:
        InvalidInputError: one is below 1, or none of them could be fitted.
    """
    of_kind(model, TPGMM, "model", "a TPGMM")
    scores = []
    fault = "no candidate was given"
    for n_components in listed(candidates, "candidates", "whole numbers"):
        whole_number(n_components, "a candidate", 1, MOST_COMPONENTS)
        trial = copy(model)
        trial.n_components = n_components
        try:
            trial.fit(demonstrations)
        except InvalidInputError as error:
            fault = str(error)
            continue
        scores.append((n_components, bic(trial, demonstrations)))
    if not scores:
        raise InvalidInputError(f"no number of components could be fitted: {fault}")
    best = min(scores, key=lambda score: score[1])
    return BICChoice(best[0], tuple(scores))


@dataclass(frozen=True, eq=False)
class DirichletProcessChoice:
    """The number of components that a Dirichlet-process mixture keeps.

    Attributes:
        n_components: components with more than 1 % of the samples.
        weights: share of the samples in each of the ``max_components``, in descending order.
        n_steps: variational steps taken.
        converged: whether they stopped by the tolerance.
    """

    n_components: int
    weights: FloatArray
    n_steps: int
    converged: bool


def choose_by_dirichlet_process(
    model: TPGMM,
    demonstrations: Sequence[DemonstrationLike],
    *,
    max_components: int = 15,
    concentration: float = 1.0,
    max_steps: int = 500,
    tolerance: float = 1e-4,
) -> DirichletProcessChoice:
    """Variational inference of a truncated stick-breaking mixture with shared responsibilities.

    Each component has a Normal-Wishart prior in each frame: centred on the data, one
    pseudo-sample strong, with D degrees of freedom and, as the expected covariance, the model's
    covariance floor plus a hundredth of the data's own. Components that the data do not need lose
    their samples.

    Source: Blei and Jordan (2006), "Variational inference for Dirichlet process mixtures",
    doi:10.1214/06-BA104; Bishop (2006), "Pattern recognition and machine learning", section 10.2.
    The factor over frames is that of the TP-GMM.

    Args:
        model: the encoding and the covariance floor; it is not changed.
        demonstrations: what is described.
        max_components: where the stick-breaking is cut off.
        concentration: of the Dirichlet process; larger keeps more components.
        max_steps: steps after which it stops in any case.
        tolerance: it stops once no component's weight changes by more in a step.
    """
    of_kind(model, TPGMM, "model", "a TPGMM")
    whole_number(max_components, "max_components", 1, MOST_COMPONENTS)
    real_number(concentration, "the concentration", 0.0, LARGEST, above=True)
    whole_number(max_steps, "max_steps", 0)
    real_number(tolerance, "the tolerance", 0.0)
    data, lengths = model.samples(demonstrations)
    floor = em.covariance_floor(
        data, model.blocks(data.shape[1]), model.floor, model.relative_floor
    )
    initial = em.initialise_by_time(data, lengths, max_components, floor + 1e-9 * _spread(data))
    weights, _ = em.responsibilities(data, initial)
    prior = _WishartPrior.of(data, floor)
    shares = np.sort(weights.mean(axis=1))[::-1]
    converged = False
    step = 0
    while step < max_steps and not converged:
        step += 1
        # Stick-breaking favours early sticks: give them to the components with most samples.
        weights = weights[np.argsort(-weights.sum(axis=1), kind="stable")]
        logs = _expected_log_weights(weights.sum(axis=1), concentration)[:, None]
        logs = logs + prior.expected_log_densities(data, weights)
        weights = np.exp(logs - logs.max(axis=0))
        weights /= weights.sum(axis=0)
        new_shares = np.sort(weights.mean(axis=1))[::-1]
        converged = bool(np.abs(new_shares - shares).max() < tolerance)
        shares = new_shares
    kept = int((shares > NEGLIGIBLE_WEIGHT).sum())
    return DirichletProcessChoice(max(kept, 1), shares, step, converged)


def _spread(data: FloatArray) -> FloatArray:
    """Diagonal covariance (P, D, D) of the data in each frame."""
    return data.var(axis=2)[:, :, None] * np.eye(data.shape[1])


def _expected_log_weights(mass: FloatArray, concentration: float) -> FloatArray:
    """E[log pi_k] of the stick-breaking weights, given the number of samples in each component."""
    from scipy.special import digamma

    a = 1.0 + mass
    b = concentration + mass.sum() - np.cumsum(mass)
    taken, left = digamma(a) - digamma(a + b), digamma(b) - digamma(a + b)
    return taken + np.concatenate([[0.0], np.cumsum(left)[:-1]])


@dataclass(frozen=True, eq=False)
class _WishartPrior:
    """Normal-Wishart prior in each frame: mean (P, D) and expected scatter (P, D, D)."""

    mean: FloatArray
    scatter: FloatArray
    degrees: float
    strength: float

    @classmethod
    def of(cls, data: FloatArray, floor: FloatArray) -> "_WishartPrior":
        degrees = float(data.shape[1])
        return cls(data.mean(axis=2), degrees * (floor + 0.01 * _spread(data)), degrees, 1.0)

    def expected_log_densities(self, data: FloatArray, weights: FloatArray) -> FloatArray:
        """sum_p E[log N(x_p | mu_kp, Lambda_kp^-1)], (K, N), under the posterior of ``weights``."""
        from scipy.special import digamma

        n_dims = data.shape[1]
        result = np.zeros_like(weights)
        for k, weight in enumerate(weights):
            mass = weight.sum()
            strength, degrees = self.strength + mass, self.degrees + mass
            for p, samples in enumerate(data):
                mean = (samples @ weight + self.strength * self.mean[p]) / strength
                centred = samples - mean[:, None]
                offset = self.mean[p] - mean
                scatter = self.scatter[p] + (centred * weight) @ centred.T
                scatter = scatter + self.strength * np.outer(offset, offset)
                lower = np.linalg.cholesky(scatter)
                distances = (np.linalg.solve(lower, centred) ** 2).sum(axis=0)
                log_det = digamma(0.5 * (degrees - np.arange(n_dims))).sum()
                log_det += n_dims * np.log(2.0) - 2.0 * np.log(np.diag(lower)).sum()
                quadratic = n_dims / strength + degrees * distances
                result[k] += 0.5 * (log_det - n_dims * np.log(2.0 * np.pi) - quadratic)
        return result
