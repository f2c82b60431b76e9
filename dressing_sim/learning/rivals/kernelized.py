"""Kernelized movement primitives in each frame, fused.

In each frame the reference is the regression of a mixture, N(m_n, S_n) at N phases. With K the
kernel matrix k(s_i, s_j) I, S = blockdiag(S_n) and k* the kernel's row at a phase,

    mean(s) = k* (K + l S)^-1 m,   cov(s) = (N / c) (k(s, s) I - k* (K + c S)^-1 k*^T).

A via-point takes the place of the reference nearest in phase, with a small covariance; here it is
the start, as each frame sees it. The frames' predictions are then fused by their product.

Source: Huang, Rozo, Silverio and Caldwell (2019), "Kernelized movement primitives", IJRR 38(7),
doi:10.1177/0278364919846363.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.fusion import Bands, over_time, time_mixture
from dressing_sim.learning.rivals.method import Method, Shown, Skill

#: Variance of a via-point, of the scale squared.
_EXACT = 1e-8


@dataclass(frozen=True, slots=True)
class KernelizedPrimitives(Method):
    """KMP with local frames, see the module. Positions count in units of `Shown.scale`."""

    components: int = 6
    """K of the reference."""
    floor: float = 1e-3
    """Added to variances, as a fraction of the data's."""
    references: int = 40
    """N."""
    kernel: float = 30.0
    """k(s, s') = exp(-kernel (s - s')^2)."""
    trust: float = 1.0
    """l, of the mean."""
    spread: float = 60.0
    """c, of the covariance."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The reference in each frame."""
        mixture = time_mixture(shown, self.components, self.floor)
        at, scale = np.linspace(0.0, 1.0, self.references), shown.scale
        reference = over_time(mixture, at)
        reference = Bands(reference.means / scale, reference.covariances / scale**2)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            via = [frame.to_local(start) / scale for frame in frames]
            local = [
                self.predict(at, Bands(m, s), x, shown.phase)
                for m, s, x in zip(reference.means, reference.covariances, via, strict=True)
            ]
            means = np.stack([one.means for one in local]) * scale
            covariances = np.stack([one.covariances for one in local]) * scale**2
            return Bands(means, covariances).in_world(frames).fused().means

        return skill

    def predict(
        self, at: FloatArray, reference: Bands, start: FloatArray | None, phase: FloatArray
    ) -> Bands:
        """The primitive of one frame at phases (T,): (T, p).

        Args:
            at: Phases (N,) of the reference.
            reference: Means (N, p) and covariances (N, p, p).
            start: Via-point (p,) at phase zero, or None.
            phase: Where it is asked.
        """
        means, covariances = reference.means.copy(), reference.covariances.copy()
        n, p = means.shape
        if start is not None:
            means[0], covariances[0] = start, _EXACT * np.eye(p)
        blocks = np.zeros((n, p, n, p))
        blocks[np.arange(n), :, np.arange(n)] = covariances
        noise = blocks.reshape(n * p, n * p)
        kernel = np.kron(self._kernel(at, at), np.eye(p))
        cross = np.kron(self._kernel(phase, at), np.eye(p))
        mean = cross @ cho_solve(cho_factor(kernel + self.trust * noise), means.ravel())
        known = cho_solve(cho_factor(kernel + self.spread * noise), cross.T)
        rows = cross.reshape(len(phase), p, n * p)
        explained = np.einsum("tik,ktj->tij", rows, known.reshape(n * p, len(phase), p))
        left = np.eye(p) - explained + 1e-9 * np.eye(p)
        return Bands(mean.reshape(len(phase), p), n / self.spread * left)

    def _kernel(self, a: FloatArray, b: FloatArray) -> FloatArray:
        return np.exp(-self.kernel * (a[:, None] - b) ** 2)
