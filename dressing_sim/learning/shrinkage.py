"""Covariances for few demonstrations: how far apart demonstrations are, in every direction.

A frame's weight in the fusion comes from how much the demonstrations differ when seen from it. Two
demonstrations differ along one direction only; in all others every frame looks equally sure, and
the fusion averages frames that it should choose between. With M demonstrations the covariance
*between* them, the part B_k of Sigma_k = W_k + B_k that is the spread of the demonstrations' own
means, is therefore shrunk towards the same amount of spread in every direction of a block of
coordinates (position, displacement):

    Sigma_k' = Sigma_k + lambda (T_k - B_k),   T_k = blockdiag(tr(B_block) / p I),
    lambda = p / (p + M - 1).

This is a choice of this library, in the spirit of Ledoit and Wolf (2004), "A well-conditioned
estimator for large-dimensional covariance matrices"; the paper does not have it.
"""

from collections.abc import Sequence

import numpy as np

from dressing_sim.learning.em import Mixture, responsibilities
from dressing_sim.learning.frame import FloatArray


def shrink_between(
    mixture: Mixture, data: FloatArray, lengths: Sequence[int], blocks: Sequence[int]
) -> Mixture:
    """The mixture with its covariances between demonstrations shrunk, see the module.

    Args:
        mixture: fitted to the samples.
        data: (P, D, N) samples in each frame, one demonstration after the other.
        lengths: number of samples of each of the M demonstrations; they sum to N.
        blocks: sizes of the groups of coordinates that share a unit; they sum to D.
    """
    between = between_covariances(mixture, data, lengths)
    target = np.zeros_like(between)
    begin = 0
    for size in blocks:
        axes = np.arange(begin, begin + size)
        spread = between[..., axes, axes].sum(axis=-1) / size
        target[..., axes, axes] = spread[..., None]
        begin += size
    dimension = blocks[-1]
    share = dimension / (dimension + len(lengths) - 1)
    covariances = mixture.covariances + share * (target - between)
    return Mixture(mixture.priors, mixture.means, covariances)


def between_covariances(mixture: Mixture, data: FloatArray, lengths: Sequence[int]) -> FloatArray:
    """B_k, (K, P, D, D): covariance of the demonstrations' means in each component and frame.

    Each demonstration's mean is weighted by its share of the component's samples.
    """
    weights, _ = responsibilities(data, mixture)
    ends = np.cumsum(lengths)[:-1]
    parts = zip(np.split(weights, ends, axis=1), np.split(data, ends, axis=2), strict=True)
    masses, sums = [], []
    for weight, samples in parts:
        masses.append(weight.sum(axis=1))
        sums.append(np.einsum("kn,pdn->kpd", weight, samples, optimize=True))
    mass = np.array(masses)  # (M, K)
    # A demonstration without samples in a component has no mean there, and no weight.
    offsets = np.array(sums) - mass[:, :, None, None] * mixture.means
    offsets /= np.sqrt(np.maximum(mass, 1e-12))[:, :, None, None]
    total = np.maximum(mass.sum(axis=0), 1e-12)[:, None, None, None]
    return np.asarray(np.einsum("mkpi,mkpj->kpij", offsets, offsets) / total)
