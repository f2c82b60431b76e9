"""Gaussians over poses: Euclidean coordinates and a rotation, each Gaussian in a tangent space.

A point of R^d x S3 is an array of d + 4 numbers, the last four a unit quaternion; a tangent has
d + 3. With the mean m and the covariance C in the tangent space at m,

    log p(y) = -1/2 (log_m(y)^T C^-1 log_m(y) + log det C + D log 2 pi),    D = d + 3,

and a product of such Gaussians is one at the m for which

    m <- exp_m( (sum_p L_p)^-1 sum_p L_p log_m(m_p) ),   L_p = (T_p C_p T_p^T)^-1,

no longer moves: T_p transports the tangents at m_p to m. Its covariance is ``(sum_p L_p)^-1``.

Source: see `quaternions`. The density is normalised as in the tangent space, as there: for
covariances that are small against half a turn.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import quaternions
from dressing_sim.learning.frame import FloatArray, Frame, stack_frames
from dressing_sim.learning.quaternions import SHORTEST, STEPS


def exp(base: FloatArray, tangents: FloatArray) -> FloatArray:
    """Where tangents (..., d + 3) lead to from points (..., d + 4)."""
    moved = base[..., :-4] + tangents[..., :-3]
    turned = quaternions.exp(base[..., -4:], tangents[..., -3:])
    return np.concatenate([moved, turned], axis=-1)


def log(base: FloatArray, points: FloatArray) -> FloatArray:
    """The tangents (..., d + 3) that lead from points (..., d + 4) to others."""
    moved = points[..., :-4] - base[..., :-4]
    turned = quaternions.log(base[..., -4:], points[..., -4:])
    return np.concatenate([moved, turned], axis=-1)


def transport(tangents: FloatArray) -> FloatArray:
    """Parallel transport along tangents (..., d + 3), as matrices (..., d + 3, d + 3).

    Euclidean coordinates stay; for rotations see `quaternions.transport`.
    """
    size = tangents.shape[-1]
    carried = np.zeros((*tangents.shape, size))
    carried[..., :-3, :-3] = np.eye(size - 3)
    carried[..., -3:, -3:] = quaternions.transport(tangents[..., -3:])
    return carried


def carried(transports: FloatArray, covariances: FloatArray) -> FloatArray:
    """Covariances ``T C T^T`` after transport."""
    return transports @ covariances @ np.swapaxes(transports, -1, -2)


@dataclass(frozen=True, eq=False)
class PoseGaussians:
    """Gaussians over poses, see the module.

    Attributes:
        means: (..., d + 4), the last four a unit quaternion.
        covariances: (..., d + 3, d + 3), rotations [rad] in axes of the body.
    """

    means: FloatArray
    covariances: FloatArray

    def log_density(self, points: FloatArray) -> FloatArray:
        """log p of points (..., d + 4), which broadcast against the means."""
        offsets = log(self.means, points)
        factors = np.linalg.cholesky(self.covariances)
        whitened = np.linalg.solve(factors, offsets[..., None])[..., 0]
        spread = 2.0 * np.log(np.diagonal(factors, axis1=-2, axis2=-1)).sum(axis=-1)
        size = offsets.shape[-1]
        density = -0.5 * ((whitened**2).sum(axis=-1) + spread + size * np.log(2.0 * np.pi))
        return np.asarray(density)

    def in_world(self, frames: Sequence[Frame]) -> PoseGaussians:
        """Gaussians of positions and rotations (P, ..., 7) in P frames -> the same in the world.

        A frame (A, b) takes x to A x + b and q to q_A q. Tangents of positions turn with A; those
        of rotations are in axes of the body and stay as they are.

        Raises:
            InvalidInputError: A frame that is no rotation and shift in space.
        """
        bases, turns, origins = rotations(frames)
        extra = (1,) * (self.means.ndim - 2)
        bases = bases.reshape(len(bases), *extra, 3, 3)
        positions = (bases @ self.means[..., :3, None])[..., 0]
        positions += origins.reshape(len(bases), *extra, 3)
        turned = quaternions.multiply(turns.reshape(len(bases), *extra, 4), self.means[..., 3:])
        lifted = np.zeros((*bases.shape[:-2], 6, 6))
        lifted[..., :3, :3] = bases
        lifted[..., 3:, 3:] = np.eye(3)
        means = np.concatenate([positions, turned], axis=-1)
        return PoseGaussians(means, carried(lifted, self.covariances))

    def uncoupled(self) -> PoseGaussians:
        """The same without covariances between Euclidean coordinates and the rotation."""
        covariances = self.covariances.copy()
        covariances[..., :-3, -3:] = 0.0
        covariances[..., -3:, :-3] = 0.0
        return PoseGaussians(self.means, covariances)

    def product(self) -> PoseGaussians:
        """The product over the first axis, see the module."""
        means, covariances = self.means, self.covariances
        count = np.ones(len(means))
        turned = quaternions.mean(np.moveaxis(means[..., -4:], 0, -2), count)
        found = np.concatenate([means[..., :-4].mean(axis=0), turned], axis=-1)
        for _ in range(STEPS):
            there = log(means, found)
            precisions = np.linalg.inv(carried(transport(there), covariances))
            fused = np.linalg.inv(precisions.sum(axis=0))
            # The way back is the opposite: transport along a geodesic keeps its direction.
            pulled = -(precisions @ there[..., None]).sum(axis=0)
            step = (fused @ pulled)[..., 0]
            found = exp(found, step)
            if np.abs(step).max(initial=0.0) < SHORTEST * max(1.0, np.abs(found).max()):
                break
        return PoseGaussians(found, fused)


def rotations(frames: Sequence[Frame]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bases (P, 3, 3), the same as quaternions (P, 4), and origins (P, 3) of frames.

    Raises:
        InvalidInputError: A frame that is no rotation and shift in space.
    """
    bases, origins = stack_frames(frames)
    if origins.shape[1] != 3:
        raise InvalidInputError(f"frames of poses have dimension {origins.shape[1]}, valid is 3")
    return bases, quaternions.of_matrices(bases, "a frame of poses"), origins


def seen_from(frame: Frame, poses: FloatArray) -> FloatArray:
    """Poses (..., 7), positions and rotations, in the world -> seen from a frame."""
    _, turns, _ = rotations([frame])
    turned = quaternions.multiply(quaternions.inverse(turns[0]), poses[..., 3:])
    return np.concatenate([frame.to_local(poses[..., :3]), turned], axis=-1)
