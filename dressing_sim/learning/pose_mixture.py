"""A mixture over time and pose in all frames: expectation-maximisation and regression on S3.

Samples are [t, x, q]: R^4 x S3, with tangents of D = 7. As in `em`, a sample is in a component with
one responsibility for all frames, proportional to ``pi_k prod_p N(y_p | m_kp, C_kp)``. The M-step
is a mean by Gauss-Newton and the covariance of the tangents at it,

    m_kp <- exp_m(sum_n g_kn log_m(y_np)),   C_kp = sum_n g_kn log_m(y_np) log_m(y_np)^T + floor.

The pose at a time is found in the same way: with the transports T_k from m_k to y,

    y <- exp_y(sum_k h_k d_k),   d_k = log_y(m_k) + T_k C_xt / C_tt (t - t_k),

until it no longer moves, and its covariance is ``sum_k h_k (T_k C_x|t T_k^T + d_k d_k^T)``.

Source: Zeestraten et al. (2017), sections III and IV, see `quaternions`; frames as in Calinon
(2016), doi:10.1007/s11370-015-0187-9.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp, softmax

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import quaternions
from dressing_sim.learning.em import EMOptions, EMRecord
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.pose_gaussians import PoseGaussians, carried, exp, log, transport
from dressing_sim.learning.quaternions import SHORTEST, STEPS


@dataclass(frozen=True, eq=False)
class PoseMixture:
    """A mixture over [t, x, q] in every frame, with common priors.

    Attributes:
        priors: (K,), sum to one.
        means: (K, P, 8), in each frame's own coordinates.
        covariances: (K, P, 7, 7), in the tangent spaces at the means.
    """

    priors: FloatArray
    means: FloatArray
    covariances: FloatArray

    def over_time(self, times: FloatArray) -> PoseGaussians:
        """The pose at times (N,) in each frame's own coordinates, (P, N), see the module."""
        variance = self.covariances[..., 0, 0]
        offset = times[:, None, None] - self.means[..., 0]  # (N, K, P)
        share = _shares(np.log(self.priors)[:, None] - 0.5 * np.log(variance), offset, variance)
        gains = self.covariances[..., 1:, 0] / variance[..., None]
        inner = self.covariances[..., 1:, 1:] - gains[..., :, None] * self.covariances[..., :1, 1:]
        ahead = (gains * offset[..., None])[..., None]  # (N, K, P, 6, 1)
        poses = self.means[..., 1:]
        likely = share.argmax(axis=1)
        found = poses[likely, np.arange(poses.shape[1])]  # (N, P, 7)
        for _ in range(STEPS):
            there = log(poses, found[:, None])
            along = transport(there)
            deltas = (along @ ahead)[..., 0] - there
            step = np.einsum("nkp,nkpi->npi", share, deltas)
            found = exp(found, step)
            if np.abs(step).max(initial=0.0) < SHORTEST * max(1.0, np.abs(found).max()):
                break
        covariances = np.einsum("nkp,nkpij->pnij", share, carried(along, inner))
        covariances += np.einsum("nkp,nkpi,nkpj->pnij", share, deltas, deltas)
        return PoseGaussians(np.swapaxes(found, 0, 1), covariances)


def _shares(log_weights: FloatArray, offset: FloatArray, variance: FloatArray) -> FloatArray:
    """How much each component counts at a time, (N, K, P)."""
    logs = log_weights - 0.5 * offset**2 / variance
    return np.asarray(softmax(logs, axis=1))


def fit_mixture(
    data: FloatArray, n_components: int, floor: FloatArray, options: EMOptions | None = None
) -> tuple[PoseMixture, EMRecord]:
    """Expectation-maximisation from equal bins of time.

    Args:
        data: (P, N, 8) samples [t, x, q] in each frame; all frames have the same times.
        n_components: K.
        floor: (P, 7, 7), added to every covariance at every step.
        options: When it stops.

    Raises:
        InvalidInputError: A component without samples.
    """
    options = options or EMOptions()
    times = data[0, :, 0]
    ranks = np.argsort(np.argsort(times, kind="stable"), kind="stable")
    bins = ranks * n_components // len(ranks)
    belongs = (bins == np.arange(n_components)[:, None]).astype(np.float64)
    likelihoods: list[float] = []
    while True:
        mixture = _maximised(data, belongs, floor)
        belongs, likelihood = _responsibilities(data, mixture)
        likelihoods.append(likelihood)
        gain = likelihood - likelihoods[-2] if len(likelihoods) > 1 else np.inf
        small = len(likelihoods) >= options.min_steps and gain < options.tolerance
        if small or len(likelihoods) >= options.max_steps:
            objectives = np.array(likelihoods)
            return mixture, EMRecord(objectives, bool(abs(gain) < options.tolerance), objectives)


def _maximised(data: FloatArray, belongs: FloatArray, floor: FloatArray) -> PoseMixture:
    """The mixture of responsibilities (K, N)."""
    counts = belongs.sum(axis=1)
    if counts.min() < 1e-6:
        raise InvalidInputError(
            f"a component has no samples among {data.shape[1]}, valid are fewer components"
        )
    shares = belongs / counts[:, None]
    moved = np.einsum("kn,pni->kpi", shares, data[..., :-4])
    turned = quaternions.mean(data[None, ..., -4:], shares[:, None])
    means = np.concatenate([moved, turned], axis=-1)
    offsets = log(means[:, :, None], data)
    covariances = np.einsum("kn,kpni,kpnj->kpij", shares, offsets, offsets) + floor
    return PoseMixture(counts / counts.sum(), means, covariances)


def _responsibilities(data: FloatArray, mixture: PoseMixture) -> tuple[FloatArray, float]:
    """Of each component for each sample, (K, N), and the mean log-likelihood of a sample."""
    parts = PoseGaussians(mixture.means[:, :, None], mixture.covariances[:, :, None])
    logs = np.log(mixture.priors)[:, None] + parts.log_density(data).sum(axis=1)
    total = logsumexp(logs, axis=0)
    return np.exp(logs - total), float(total.mean())
