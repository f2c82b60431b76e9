"""Gaussian mixture regression for a situation, in both orders of fusion.

With inputs I and outputs O of a Gaussian component, the regression is

    m_k(x) = mu_O + S_OI S_II^-1 (x - mu_I),   C_k = S_OO - S_OI S_II^-1 S_IO,
    m(x) = sum_k h_k m_k,   C(x) = sum_k h_k (C_k + (m_k - m)(m_k - m)^T),

so the covariance keeps the spread of the components' means. The frames' views are fused by a
product of Gaussians, S^-1 = sum_p S_p^-1, mu = S sum_p S_p^-1 mu_p, either

* ``"regression-then-product"``: one regression a frame, then the product of the conditionals at
  each query (what the authors' code and pbdlib do), or
* ``"product-then-regression"``: the product component by component, then one regression (what the
  paper's text says).

Source: Zhu, Gienger and Kober (2022), section III; Calinon (2016), see ``em``.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.checks import one_of, real_array
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.em import Mixture
from dressing_sim.learning.frame import FloatArray, Frame, stack_frames

FusionOrder = Literal["regression-then-product", "product-then-regression"]
FUSION_ORDERS: tuple[FusionOrder, ...] = get_args(FusionOrder)


def check_fusion(fusion: str) -> FusionOrder:
    """The fusion order, once it is one of the two that exist."""
    one_of(fusion, "fusion", FUSION_ORDERS)
    return cast(FusionOrder, fusion)


@dataclass(frozen=True, eq=False)
class WorldMixture:
    """Gaussian components in world coordinates: (P, K, D) means and (P, K, D, D) covariances.

    P is the number of views: that of the frames before the product, one after it.
    """

    priors: FloatArray
    means: FloatArray
    covariances: FloatArray


def to_world(mixture: Mixture, bases: FloatArray, origins: FloatArray) -> WorldMixture:
    """Each frame's components moved to world coordinates by (A_hat, b_hat).

    mu_hat = A_hat mu + b_hat, S_hat = A_hat S A_hat^T (paper, equation 4).

    Args:
        mixture: K components in P frames, D dimensions.
        bases: A_hat (P, D, D).
        origins: b_hat (P, D).
    """
    means = np.einsum("pij,kpj->pki", bases, mixture.means) + origins[:, None]
    covariances = np.einsum("pij,kpjl,pml->pkim", bases, mixture.covariances, bases, optimize=_PATH)
    return WorldMixture(mixture.priors, means, _symmetric(covariances))


_PATH = ["einsum_path", (0, 1), (0, 1)]


def _symmetric(matrices: NDArray[np.floating]) -> FloatArray:
    return np.asarray(0.5 * (matrices + np.swapaxes(matrices, -1, -2)), dtype=np.float64)


def product(world: WorldMixture) -> WorldMixture:
    """Product of Gaussians over the views, component by component (paper, equation 5)."""
    precisions = np.linalg.inv(world.covariances)
    weighted = np.einsum("pkij,pkj->ki", precisions, world.means)
    covariances = _symmetric(np.linalg.inv(precisions.sum(axis=0)))
    means = np.einsum("kij,kj->ki", covariances, weighted)
    return WorldMixture(world.priors, means[None], covariances[None])


def lift(frames: Sequence[Frame], n_time: int, n_copies: int) -> tuple[FloatArray, FloatArray]:
    """A_hat (P, D, D) and b_hat (P, D) of a situation for samples [time, position, displacement].

    A_hat = blockdiag(I, A, A), b_hat = [0; b; 0]: time is the same in every frame, and a
    displacement has no origin (paper, equation 14).

    Args:
        frames: P frames of dimension p.
        n_time: 1 with time as the first coordinate, else 0.
        n_copies: 1 for the position alone, 2 for position and displacement.
    """
    bases, origins = stack_frames(frames)
    n_frames, p = origins.shape
    size = n_time + n_copies * p
    lifted = np.zeros((n_frames, size, size))
    lifted[:, :n_time, :n_time] = np.eye(n_time)
    for copy in range(n_copies):
        block = slice(n_time + copy * p, n_time + (copy + 1) * p)
        lifted[:, block, block] = bases
    offsets = np.zeros((n_frames, size))
    offsets[:, n_time : n_time + p] = origins
    return lifted, offsets


def view_ridges(ridge: float | FloatArray, bases: FloatArray) -> FloatArray:
    """Ridges (P, p, p) in world coordinates that are multiples of the identity in their frames.

    Args:
        ridge: of all frames, or (P,) of each.
        bases: A (P, p, p) of each frame.
    """
    if isinstance(ridge, np.ndarray):
        ridge = ridge[:, None, None]
    return np.asarray(ridge * bases @ bases.transpose(0, 2, 1))


def fused_ridge(ridge: float | FloatArray, bases: FloatArray) -> FloatArray:
    """One ridge (1, p, p): a multiple of the identity, or the harmonic mean of the frames' own.

    Args:
        ridge: one number, or (P,) of each frame.
        bases: A (P, p, p) of each frame.
    """
    if not isinstance(ridge, np.ndarray):
        return ridge * np.eye(bases.shape[1])[None]
    if not (ridge > 0.0).all():
        return np.zeros((1, *bases.shape[1:]))
    return _symmetric(np.linalg.inv(np.linalg.inv(view_ridges(ridge, bases)).mean(axis=0)))[None]


class Regression(NamedTuple):
    """A mixture prepared for regression: what does not depend on the query, computed once.

    A tuple, which the compiled loops take as it is.

    Attributes:
        log_weights: log(pi_k) - log(det(2 pi S_II)) / 2, (P, K).
        input_means: (P, K, i). precisions: S_II^-1 (P, K, i, i). output_means: (P, K, o).
        gains: S_OI S_II^-1 (P, K, o, i). residuals: C_k (P, K, o, o).
        ridge: (P, o, o), added to each view's conditional covariance.
        shared: whether the views share their responsibilities (those of the product of their input
            densities) instead of having each its own.
    """

    log_weights: FloatArray
    input_means: FloatArray
    precisions: FloatArray
    output_means: FloatArray
    gains: FloatArray
    residuals: FloatArray
    ridge: FloatArray
    shared: bool

    def __call__(self, queries: ArrayLike) -> tuple[FloatArray, FloatArray]:
        """Conditional means (T, o) and covariances (T, o, o) for queries (T, i).

        Raises:
            InvalidInputError: a conditional covariance is singular.
        """
        from dressing_sim.learning.kernels.regression import regress

        shape = ("T", self.input_means.shape[-1])
        points = np.ascontiguousarray(real_array(queries, shape, "queries have"))
        means, covariances = regress(points, self)
        return check_finite(means), covariances


def check_finite(path: FloatArray) -> FloatArray:
    """The path itself, or an error where a covariance was too near to singular to give one."""
    if not np.isfinite(path).all():
        raise InvalidInputError(
            "the regression is singular: use a larger covariance floor or fewer components"
        )
    return path


def regression(
    world: WorldMixture, n_inputs: int, ridge: FloatArray | None = None, shared: bool = False
) -> Regression:
    """Prepare the regression of the coordinates after the first ``n_inputs`` on those."""
    means, covariances = world.means, world.covariances
    inputs, outputs = slice(None, n_inputs), slice(n_inputs, None)
    precisions = _symmetric(np.linalg.inv(covariances[..., inputs, inputs]))
    _, log_det = np.linalg.slogdet(2.0 * np.pi * covariances[..., inputs, inputs])
    gains = covariances[..., outputs, inputs] @ precisions
    residuals = covariances[..., outputs, outputs] - gains @ covariances[..., inputs, outputs]
    if ridge is None:
        n_outputs = means.shape[-1] - n_inputs
        ridge = np.zeros((len(means), n_outputs, n_outputs))
    with np.errstate(divide="ignore"):  # an empty component weighs exp(-inf) = 0
        log_weights = np.log(world.priors) - 0.5 * log_det
    return Regression(
        log_weights,
        np.ascontiguousarray(means[..., inputs]),
        precisions,
        np.ascontiguousarray(means[..., outputs]),
        gains,
        np.ascontiguousarray(_symmetric(residuals)),
        ridge,
        shared,
    )
