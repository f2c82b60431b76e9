"""Where demonstrations begin and end, as a function of the situation.

The one-component, one-sample case of a TP-GMM: the points seen from each frame have a mean and a
covariance there, and a situation's point is the mean of the product of the frames' Gaussians
(paper, equations 4 and 5). A frame in which the points agree decides.

Two demonstrations say nothing about most directions: their sample covariance has rank one, and what
is left would weigh all frames alike. The covariance is therefore shrunk towards the multiple of the
identity with the same trace, by p / (p + n - 1) for n points (a choice of this library).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    check_demonstrations,
    check_weights,
    in_frames,
)
from dressing_sim.learning.frame import FloatArray, Frame, stack_frames

FLOOR = 1e-3  # of the paths' variance in the frame, added to keep the covariance invertible


@dataclass(frozen=True, eq=False)
class Endpoint:
    """A task-parameterized point.

    Attributes:
        means: (P, p) in each frame's coordinates.
        covariances: (P, p, p) in each frame's coordinates.
    """

    means: FloatArray
    covariances: FloatArray

    @classmethod
    def of(
        cls,
        demonstrations: Sequence[DemonstrationLike],
        index: int,
        weights: ArrayLike | None = None,
    ) -> "Endpoint":
        """The model of sample ``index`` of each demonstration: 0 for the start, -1 for the end.

        Weights (M,) of the demonstrations make shares u_m that sum to one; with them n is
        1 / sum u_m^2, the number of alike ones that would tell as much.
        """
        whole_number(index, "the index of a sample", -1, 0)
        paths = [in_frames(d.positions, d.frames) for d in check_demonstrations(demonstrations)]
        points = np.stack([path[:, index] for path in paths])
        means, covariances, beyond = _moments(points, weights)
        dimension = means.shape[1]
        share = dimension / (dimension + beyond)
        scale = np.trace(covariances, axis1=1, axis2=2) / dimension
        spread = np.mean([path.var(axis=1).mean(axis=1) for path in paths], axis=0)
        isotropic = (share * scale + FLOOR * spread)[:, None, None] * np.eye(dimension)
        return cls(means, (1.0 - share) * covariances + isotropic)

    def predict(self, frames: Sequence[Frame]) -> FloatArray:
        """The point (p,) in world coordinates for a situation."""
        bases, origins = stack_frames(frames)
        if bases.shape != self.covariances.shape:
            raise InvalidInputError(
                f"the situation has frames of shape {bases.shape}, valid is as many, and of the "
                f"same dimension, as learned from: {self.covariances.shape}"
            )
        precisions = np.linalg.inv(bases @ self.covariances @ bases.transpose(0, 2, 1))
        points = np.einsum("pij,pj->pi", bases, self.means) + origins
        weighted = np.einsum("pij,pj->i", precisions, points)
        return np.linalg.solve(precisions.sum(axis=0), weighted)


def _moments(points: FloatArray, weights: ArrayLike | None) -> tuple[FloatArray, FloatArray, float]:
    """Mean (P, p) and covariance (P, p, p) of points (M, P, p), and n - 1 or what stands for it."""
    if weights is None:
        means = points.mean(axis=0)
        centred = points - means
        beyond = max(len(points) - 1, 1)
        return means, np.einsum("mpi,mpj->pij", centred, centred) / beyond, beyond
    values = check_weights(weights, len(points))
    shares = values / values.sum()
    means = np.einsum("m,mpi->pi", shares, points)
    centred = points - means
    squares = float(np.sum(shares**2))
    covariances = np.einsum("m,mpi,mpj->pij", shares, centred, centred)
    if len(points) == 1:
        return means, covariances, 1.0
    return means, covariances / (1.0 - squares), 1.0 / squares - 1.0
