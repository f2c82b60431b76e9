"""A TP-GMM over time that takes demonstrations one after the other and keeps none of them.

From a mixture of n demonstrations and a new one comes a mixture of n + 1, by one of three updates:

* ``generative``: the mixture plays the n situations, and a new one is learned from these paths and
  the demonstration;
* ``addition``: the demonstration's own mixture is put beside it with weights n and 1, and the two
  components nearest to each other are joined, keeping their moments, until K are left;
* ``direct``: expectation-maximisation in which the mixture stands for its n N samples,

      m_k = (n N pi_k m_k0 + sum_j g_kj x_j) / (n N pi_k + sum_j g_kj),   likewise S_k.

Source: Hoyos, Prieto, Alenya and Torras (2016), "Incremental learning of skills in a
task-parameterized Gaussian mixture model", Journal of Intelligent and Robotic Systems 82,
doi:10.1007/s10846-015-0290-3; the direct update: Calinon and Billard (2007), "Incremental learning
of gestures by imitation in a humanoid robot", HRI, doi:10.1145/1228716.1228751.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Literal

import numpy as np

from dressing_sim.learning.em import Mixture, covariance_floor, responsibilities
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.fusion import over_time, time_mixture
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.tpgmm import TPGMM


@dataclass(frozen=True, slots=True)
class Incremental(Method):
    """Incremental TP-GMM, see the module: the first demonstration alone, then one after another."""

    may_be_zero: ClassVar[frozenset[str]] = frozenset({"steps"})

    update: Literal["generative", "addition", "direct"] = "generative"
    components: int = 6
    """K."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""
    steps: int = 20
    """Of the direct update."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The mixture after the last demonstration."""
        mixture = time_mixture(shown.only([0]), self.components, self.floor)
        for n in range(1, len(shown.points)):
            seen, new = shown.only(range(n)), shown.only([n])
            if self.update == "generative":
                mixture = self._generative(mixture, seen.situations, new)
            elif self.update == "addition":
                own = time_mixture(new, self.components, self.floor)
                mixture = reduced(beside(mixture, own, n), self.components)
            else:
                mixture = self._direct(mixture, n, new)
        bands = over_time(mixture, shown.phase)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            return bands.in_world(frames).fused().means

        return skill

    def _generative(
        self, mixture: Mixture, situations: tuple[tuple[Frame, ...], ...], new: Shown
    ) -> Mixture:
        bands = over_time(mixture, new.phase)
        played = [bands.in_world(frames).fused().means for frames in situations]
        points = np.concatenate([played, new.points])
        told = Shown(points, (*situations, *new.situations), new.duration)
        return time_mixture(told, self.components, self.floor)

    def _direct(self, mixture: Mixture, n: int, new: Shown) -> Mixture:
        model = TPGMM(self.components, encoding="time")
        data, _ = model.samples(new.demonstrations())
        floors = covariance_floor(data, (1, data.shape[1] - 1), (self.floor, self.floor), True)
        found = mixture
        for _ in range(self.steps):
            found = updated(mixture, n, data, responsibilities(data, found)[0], floors)
        return found


def updated(
    mixture: Mixture, n: int, data: FloatArray, shares: FloatArray, floors: FloatArray
) -> Mixture:
    """The moments of a mixture of n demonstrations together with those of new samples.

    Args:
        mixture: Before, of n times as many samples.
        n: See above.
        data: (P, D, N).
        shares: (K, N).
        floors: (P, D, D), added to the new samples' covariances.
    """
    old, new = n * data.shape[2] * mixture.priors, shares.sum(axis=1)
    mass = np.maximum(old + new, 1e-12)
    sums = old[:, None, None] * mixture.means + np.einsum("kn,pdn->kpd", shares, data)
    means = sums / mass[:, None, None]
    centred = data[None] - means[..., None]
    gap = mixture.means - means
    total = np.einsum("kn,kpdn,kpen->kpde", shares, centred, centred, optimize=True)
    total += new[:, None, None, None] * floors
    total += old[:, None, None, None] * (mixture.covariances + gap[..., None] * gap[..., None, :])
    return Mixture(mass / mass.sum(), means, total / mass[:, None, None, None])


def beside(mixture: Mixture, other: Mixture, n: int) -> Mixture:
    """Two mixtures as one, with weights n and 1."""
    return Mixture(
        np.append(n * mixture.priors, other.priors) / (n + 1),
        np.concatenate([mixture.means, other.means]),
        np.concatenate([mixture.covariances, other.covariances]),
    )


def reduced(mixture: Mixture, count: int) -> Mixture:
    """The mixture with fewer components: the two nearest are joined, again and again.

    Near is a small Kullback-Leibler divergence, of both directions and all frames together.
    """
    while mixture.n_components > count:
        i, j = np.unravel_index(int(np.argmin(_divergences(mixture))), (mixture.n_components,) * 2)
        pair = [int(i), int(j)]
        weights = mixture.priors[pair] / mixture.priors[pair].sum()
        mean = np.einsum("k,kpd->pd", weights, mixture.means[pair])
        gap = mixture.means[pair] - mean
        joint = np.einsum("k,kpde->pde", weights, mixture.covariances[pair])
        joint += np.einsum("k,kpd,kpe->pde", weights, gap, gap)
        kept = [k for k in range(mixture.n_components) if k not in pair]
        mixture = Mixture(
            np.append(mixture.priors[kept], mixture.priors[pair].sum()),
            np.concatenate([mixture.means[kept], mean[None]]),
            np.concatenate([mixture.covariances[kept], joint[None]]),
        )
    return mixture


def _divergences(mixture: Mixture) -> FloatArray:
    """KL(i, j) + KL(j, i), (K, K), infinite on the diagonal."""
    precisions = np.linalg.inv(mixture.covariances)
    gap = mixture.means[:, None] - mixture.means
    traces = np.einsum("ipde,jped->ij", precisions, mixture.covariances)
    squares = np.einsum("ijpd,ipde,ijpe->ij", gap, precisions, gap)
    dims = mixture.n_frames * mixture.n_dims
    both = 0.5 * (traces + traces.T + squares + squares.T) - dims
    return both + np.diag(np.full(len(both), np.inf))
