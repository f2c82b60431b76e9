"""Gaussian mixture regression over time in each frame, and products of Gaussians.

A mixture over [t, x] in every frame gives, frame by frame, the mean and covariance

    m(t) = sum_k h_k m_k(t),   C(t) = sum_k h_k (C_k + m_k m_k^T) - m m^T,

with m_k, C_k the conditionals of component k and h_k its share at t; in a situation these move to
A m + b and A C A^T, and a weighted product of the frames' Gaussians is

    C^-1 = sum_p w_p C_p^-1,   m = C sum_p w_p C_p^-1 m_p.

Source: Calinon (2016), "A tutorial on task-parameterized movement learning and retrieval",
doi:10.1007/s11370-015-0187-9; without weights it is the time-based TP-GMM.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.learning.em import Mixture
from dressing_sim.learning.frame import FloatArray, Frame, stack_frames
from dressing_sim.learning.rivals.method import Shown
from dressing_sim.learning.tpgmm import TPGMM


@dataclass(frozen=True, eq=False)
class Bands:
    """Gaussians along a path, frame by frame or fused: means (..., N, p), covariances."""

    means: FloatArray
    covariances: FloatArray

    def in_world(self, frames: Sequence[Frame]) -> Bands:
        """Those of P frames, (P, N, p), in world coordinates."""
        bases, origins = stack_frames(frames)
        means = np.einsum("pij,pnj->pni", bases, self.means) + origins[:, None]
        covariances = np.einsum("pij,pnjk,plk->pnil", bases, self.covariances, bases)
        return Bands(means, covariances)

    def fused(self, weights: FloatArray | None = None) -> Bands:
        """The product over the first axis, with weights (P,) or (P, N) of the frames."""
        precisions = np.linalg.inv(self.covariances)
        if weights is not None:
            shape = (*weights.shape, *([1] * (precisions.ndim - weights.ndim)))
            precisions = precisions * weights.reshape(shape)
        covariances = np.linalg.inv(precisions.sum(axis=0))
        pulled = np.einsum("p...ij,p...j->...i", precisions, self.means)
        return Bands(np.einsum("...ij,...j->...i", covariances, pulled), covariances)


def time_mixture(shown: Shown, components: int, floor: float) -> Mixture:
    """A mixture over [phase, x] in all frames, by expectation-maximisation from equal time bins.

    Args:
        shown: The demonstrations.
        components: K.
        floor: Added to every variance, as a fraction of the data's variance in the frame at hand.
    """
    model = TPGMM(components, encoding="time", floor=floor, relative_floor=True)
    return model.fit(shown.demonstrations()).fitted()


def over_time(mixture: Mixture, phase: FloatArray) -> Bands:
    """The regression in each frame's own coordinates, (P, N, p), see the module."""
    means, covariances = mixture.means, mixture.covariances
    variance = covariances[..., 0, 0]
    offset = phase[:, None, None] - means[..., 0]
    with np.errstate(divide="ignore"):  # an empty component weighs nothing
        log = np.log(mixture.priors)[:, None] - 0.5 * (offset**2 / variance + np.log(variance))
    share = np.exp(log - log.max(axis=1, keepdims=True))
    share /= share.sum(axis=1, keepdims=True)  # (N, K, P)
    gains = covariances[..., 1:, 0] / variance[..., None]
    inner = covariances[..., 1:, 1:] - gains[..., :, None] * covariances[..., None, 0, 1:]
    at = means[..., 1:] + gains * offset[..., None]  # (N, K, P, p)
    mean = np.einsum("nkp,nkpi->pni", share, at)
    spread = at.transpose(2, 0, 1, 3) - mean[:, :, None]
    covariance = np.einsum("nkp,kpij->pnij", share, inner)
    covariance += np.einsum("nkp,pnki,pnkj->pnij", share, spread, spread)
    return Bands(mean, covariance)
