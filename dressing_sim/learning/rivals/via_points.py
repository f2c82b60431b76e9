"""Via-point movement primitives: an elementary path through via-points, and the demonstrated shape.

    y(s) = h(s) + psi(s)^T w,

h straight lines through the start, the goal and via-points and w the shape, with a Gaussian
distribution over demonstrations; where h passes, psi is made zero. A via-point within what the
shape's distribution knows conditions it, as in a probabilistic primitive; another one is passed by
h: far from the demonstrations their shape is kept.

Source: Zhou, Gao and Asfour (2019), "Learning via-point movement primitives with inter- and
extrapolation capabilities", IROS.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.registration import at_times
from dressing_sim.learning.rivals.method import Equivariance, Method, Shown, Skill

#: Noise of the shape's weights, of the scale squared.
_NOISE = 1e-6


@dataclass(frozen=True, slots=True)
class ViaPointPrimitive(Method):
    """VMP, see the module; start, goal and via-points are where the frames say."""

    equivariance: ClassVar[Equivariance] = "shifts"
    may_be_zero: ClassVar[frozenset[str]] = frozenset({"via_points"})

    basis: int = 20
    """Basis functions of each coordinate."""
    via_points: int = 1
    """Evenly between the start and the goal."""
    known: float = 2.0
    """A via-point within so many standard deviations of the shape conditions it."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The shape's mean and covariance."""
        phase = shown.phase
        ends = np.array([0, self.samples - 1])
        cut = [self._between(phase, ends, path[ends]) for path in shown.points]
        lines, psi = np.stack([line for line, _ in cut]), cut[0][1]
        gram = psi.T @ psi + 1e-8 * np.eye(self.basis)
        shapes = np.linalg.solve(gram, psi.T @ (shown.points - lines))  # (M, basis, p)
        mean = shapes.mean(axis=0)
        centred = (shapes - mean).transpose(1, 0, 2).reshape(self.basis, -1)
        # Coordinates share one covariance of the weights: two demonstrations tell little more.
        spread = centred @ centred.T / max(centred.shape[1] - mean.shape[1], 1)
        spread += _NOISE * shown.scale**2 * np.eye(self.basis)
        rows = np.rint(np.linspace(0, self.samples - 1, self.via_points + 2)).astype(int)
        places = [shown.place(int(row)) for row in rows[1:]]

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            via = np.stack([start, *(place.predict(frames) for place in places)])
            return self.through(phase, rows, via, mean, spread)

        return skill

    def through(
        self,
        phase: FloatArray,
        rows: NDArray[np.int64],
        via: FloatArray,
        shape: FloatArray,
        spread: FloatArray,
    ) -> FloatArray:
        """The path (N, p) through via-points (V, p) at rows (V,), its ends among them.

        Args:
            phase: (N,).
            rows: Of the via-points.
            via: Where they are.
            shape: Mean weights (basis, p).
            spread: Their covariance (basis, basis), the same in each coordinate.
        """
        bent = self._between(phase, rows[[0, -1]], via[[0, -1]])
        missed = via - bent[0][rows] - bent[1][rows] @ shape
        inside = bent[1][rows]
        variance = np.einsum("vi,ij,vj->v", inside, spread, inside)
        known = np.sum(missed**2, axis=1) <= self.known**2 * variance * via.shape[1]
        known[[0, -1]] = False
        line, psi = self._between(phase, rows[~known], via[~known])
        if known.any():
            inside = psi[rows[known]]
            left = via[known] - line[rows[known]] - inside @ shape
            covariance = inside @ spread @ inside.T
            shape = shape + spread @ inside.T @ np.linalg.solve(covariance, left)
        return line + psi @ shape

    def _between(
        self, phase: FloatArray, rows: NDArray[np.int64], via: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Straight lines (N, p) between points at rows, and what the shape adds, zero at them."""
        psi = self._psi(phase)
        line, taken = (at_times(values, phase[rows], phase) for values in (via, psi[rows]))
        return line, psi - taken

    def _psi(self, phase: FloatArray) -> FloatArray:
        """Gaussian functions at phases (N,), also beyond the ends, (N, basis), which sum to one."""
        centres = np.linspace(-0.1, 1.1, self.basis)
        width = 1.2 / max(self.basis - 1, 1)
        values = np.exp(-0.5 * ((phase[:, None] - centres) / width) ** 2)
        return values / values.sum(axis=1, keepdims=True)
