"""Paths carried from one situation to another along with landmarks.

A situation is known by K landmarks, the same ones in every situation. A map from one situation to
another is a rigid motion and a Gaussian process on what the motion leaves of the displacements:

    x -> y(x) + k(y(x)) (K + s^2 I)^-1 (targets - y(sources)),    y(x) = R x + t,

with R, t from the landmarks by least squares (Kabsch 1976, doi:10.1107/S0567739476001873) and
k(a, b) = exp(-|a - b|^2 / 2 l^2). Where there is no landmark near, the rigid motion remains.

Source of the idea: Franzese, Prakash and Kober, "Generalization of Task Parameterized Dynamical
Systems using Gaussian Process Transportation" (2024), arXiv:2404.13458.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np

from dressing_sim.checks import real_array, real_number
from dressing_sim.learning.frame import FloatArray


def rigid_motion(sources: FloatArray, targets: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The rotation R (p, p) and translation t (p,) with least ``sum |R x + t - y|^2``.

    Args:
        sources: Points x, (K, p).
        targets: Points y, (K, p).

    Returns:
        R, a proper rotation, and t.
    """
    from_centre, to_centre = sources.mean(axis=0), targets.mean(axis=0)
    left, _, right = np.linalg.svd((targets - to_centre).T @ (sources - from_centre))
    signs = np.ones(len(left))
    signs[-1] = np.sign(np.linalg.det(left @ right))
    rotation = (left * signs) @ right
    return rotation, to_centre - rotation @ from_centre


@dataclass(frozen=True, eq=False)
class Transport:
    """A map from one situation to another.

    Attributes:
        rotation: R, (p, p).
        translation: t, (p,), in the unit of the landmarks.
        anchors: The sources after the rigid motion, (K, p).
        weights: (K + s^2 I)^-1 times what the motion leaves, (K, p).
        factor: Lower Cholesky factor of K + s^2 I, (K, K).
        length: l, in the unit of the landmarks.
        amplitude: Standard deviation of a displacement beyond the rigid motion and far from all
            landmarks, each coordinate, in their unit; by maximum likelihood.
    """

    rotation: FloatArray
    translation: FloatArray
    anchors: FloatArray
    weights: FloatArray
    factor: FloatArray
    length: float
    amplitude: float

    @classmethod
    def between(cls, sources: FloatArray, targets: FloatArray, length: float, noise: float) -> Self:
        """The map that takes landmarks to landmarks.

        Args:
            sources: Landmarks of the one situation, (K, p).
            targets: Those of the other, (K, p), in the same order.
            length: l > 0, over which displacements are alike, in the unit of the landmarks.
            noise: s > 0, how far a landmark may be missed, as a fraction of the amplitude.

        Raises:
            InvalidInputError: Another shape, or a number out of its range.
        """
        from scipy.linalg import cho_factor, cho_solve

        a = real_array(sources, ("K", "p"), "landmarks have", fewest=1)
        b = real_array(targets, a.shape, "the other landmarks have")
        real_number(length, "length", 0.0, above=True)
        real_number(noise, "noise", 0.0, above=True)
        rotation, translation = rigid_motion(a, b)
        anchors = a @ rotation.T + translation
        left = b - anchors
        factor = cho_factor(
            _kernel(anchors, anchors, length) + noise**2 * np.eye(len(a)), lower=True
        )
        weights = cho_solve(factor, left)
        amplitude = float(np.sqrt(max(np.sum(left * weights), 0.0) / left.size))
        lower = np.tril(factor[0])
        return cls(rotation, translation, anchors, weights, lower, length, amplitude)

    def __call__(self, points: FloatArray) -> FloatArray:
        """Points (N, p) of the one situation -> where they are in the other."""
        moved = points @ self.rotation.T + self.translation
        return moved + _kernel(moved, self.anchors, self.length) @ self.weights

    def deviation(self, points: FloatArray) -> FloatArray:
        """Posterior standard deviation (N,) of each coordinate of where points (N, p) are."""
        from scipy.linalg import solve_triangular

        moved = points @ self.rotation.T + self.translation
        cross = _kernel(self.anchors, moved, self.length)
        known = np.sum(solve_triangular(self.factor, cross, lower=True) ** 2, axis=0)
        return self.amplitude * np.sqrt(np.maximum(1.0 - known, 0.0))


def _kernel(a: FloatArray, b: FloatArray, length: float) -> FloatArray:
    """Squared exponential between points (N, p) and (K, p): (N, K), one at distance zero."""
    squares = np.sum((a[:, None] - b[None]) ** 2, axis=2)
    return np.exp(-0.5 * squares / length**2)
