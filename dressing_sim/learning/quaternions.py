"""Rotations as unit quaternions, points of the sphere S3: maps, transport and means.

A quaternion is x, y, z, w, as scipy has it; q and -q are the same rotation, and every function here
gives the same for both. A tangent at q is a rotation vector v [rad] in the axes of the body that q
has turned, so that a turn of the world, which multiplies from the left, does not change it:

    exp_q(v) = q (sin(|v|/2) v/|v|, cos(|v|/2)),    log_q(r) = v, the shortest with exp_q(v) = +-r.

Lengths are angles of rotation, twice the arcs on the sphere. Beyond half a turn there is a shorter
way round; at half a turn exactly there are two, and `log` takes one of them.

Source: Zeestraten, Havoutis, Silverio, Calinon and Caldwell (2017), "An approach for imitation
learning on Riemannian manifolds", IEEE RA-L, doi:10.1109/LRA.2017.2657001; Calinon (2020),
"Gaussians on Riemannian manifolds", IEEE RAM, doi:10.1109/MRA.2020.2980548. They write tangents in
a basis carried along from one origin; in axes of the body the same tensors have other components.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

from dressing_sim.checks import real_array
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray

#: A quaternion whose length differs more from one, or a matrix from a rotation, is a mistake.
TOLERANCE = 1e-3

#: Steps of Gauss-Newton, and the length [rad] below which one is the last.
STEPS, SHORTEST = 50, 1e-10


def unit(values: ArrayLike, name: str) -> FloatArray:
    """Quaternions (..., 4) of length one, once they nearly are.

    Raises:
        InvalidInputError: Another shape, or no unit quaternions.
    """
    array = real_array(values, ("...", 4), f"{name} has")
    lengths = np.linalg.norm(array, axis=-1, keepdims=True)
    if np.abs(lengths - 1.0).max(initial=0.0) > TOLERANCE:
        raise InvalidInputError(
            f"{name} has a quaternion of length {lengths.flat[np.abs(lengths - 1.0).argmax()]:.4g},"
            " valid is 1: x, y, z, w of a rotation"
        )
    return array / lengths


def multiply(left: FloatArray, right: FloatArray) -> FloatArray:
    """The rotation ``right`` and then ``left``: the product of quaternions (..., 4)."""
    u, a, v, b = left[..., :3], left[..., 3:], right[..., :3], right[..., 3:]
    vector = a * v + b * u + np.cross(u, v)
    return np.concatenate([vector, a * b - (u * v).sum(axis=-1, keepdims=True)], axis=-1)


def inverse(quaternions: FloatArray) -> FloatArray:
    """The rotations back, (..., 4)."""
    return quaternions * np.array([-1.0, -1.0, -1.0, 1.0])


def exp(base: FloatArray, tangents: FloatArray) -> FloatArray:
    """Where tangents (..., 3) [rad] lead to from quaternions (..., 4), see the module."""
    half = 0.5 * np.linalg.norm(tangents, axis=-1, keepdims=True)
    turned = np.concatenate([0.5 * np.sinc(half / np.pi) * tangents, np.cos(half)], axis=-1)
    found = multiply(base, turned)
    return found / np.linalg.norm(found, axis=-1, keepdims=True)


def log(base: FloatArray, quaternions: FloatArray) -> FloatArray:
    """The tangents (..., 3) [rad] that lead from one rotation to another, see the module."""
    between = multiply(inverse(base), quaternions)
    between = np.where(between[..., 3:] < 0.0, -between, between)
    sine = np.linalg.norm(between[..., :3], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, between[..., 3:])
    short = sine < 1e-12
    return between[..., :3] * np.where(short, 2.0, angle / np.where(short, 1.0, sine))


def matrices(quaternions: FloatArray) -> FloatArray:
    """Rotation matrices (..., 3, 3)."""
    turned = Rotation.from_quat(quaternions.reshape(-1, 4)).as_matrix()
    return np.asarray(turned).reshape(*quaternions.shape[:-1], 3, 3)


def of_matrices(rotations: ArrayLike, name: str) -> FloatArray:
    """Quaternions (..., 4) of rotation matrices (..., 3, 3).

    Raises:
        InvalidInputError: One is no rotation, but a reflection, say, or scaled.
    """
    array = real_array(rotations, ("...", 3, 3), f"{name} has")
    flat = array.reshape(-1, 3, 3)
    apart = np.abs(flat @ flat.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if apart > TOLERANCE or (np.linalg.det(flat) < 0.0).any():
        raise InvalidInputError(f"{name} has a matrix that is no rotation, valid is a rotation")
    return np.asarray(Rotation.from_matrix(flat).as_quat()).reshape(*array.shape[:-2], 4)


def transport(tangents: FloatArray) -> FloatArray:
    """Parallel transport along geodesics: matrices (..., 3, 3) from tangents to tangents.

    Along ``exp_q(s v)``, s from 0 to 1, a tangent u at q becomes ``R(-v/2) u`` in the axes of the
    body at the other end: the body turned by v, and the tangent with it by half of that.

    Args:
        tangents: v, (..., 3) [rad].
    """
    identity = np.array([0.0, 0.0, 0.0, 1.0])
    return matrices(exp(identity, -0.5 * tangents))


def mean(quaternions: FloatArray, weights: FloatArray) -> FloatArray:
    """The intrinsic mean: least weighted sum of squared angles.

    Gauss-Newton, ``m <- exp_m(sum_n w_n log_m(q_n))``, from the mean by chords, the leading
    eigenvector of ``sum_n w_n q_n q_n^T`` (Markley et al. 2007), which does not see signs.

    Args:
        quaternions: (..., N, 4).
        weights: (..., N), not negative and not all zero; the axes before N broadcast.

    Returns:
        Means (..., 4), with w not negative.
    """
    shares = weights / weights.sum(axis=-1, keepdims=True)
    moments = np.einsum("...n,...ni,...nj->...ij", shares, quaternions, quaternions)
    found = np.linalg.eigh(moments)[1][..., -1]
    for _ in range(STEPS):
        moves = log(found[..., None, :], quaternions)
        step = np.einsum("...n,...ni->...i", shares, moves)
        found = exp(found, step)
        if np.abs(step).max(initial=0.0) < SHORTEST:
            break
    return np.where(found[..., 3:] < 0.0, -found, found)


def continuous(quaternions: FloatArray) -> FloatArray:
    """The same rotations (T, 4), each with the sign that is nearer to the one before.

    The first one's w is not negative.
    """
    along = (quaternions[1:] * quaternions[:-1]).sum(axis=-1)
    signs = np.cumprod(np.where(np.append(quaternions[0, 3], along) < 0.0, -1.0, 1.0))
    return quaternions * signs[:, None]


def interpolated(quaternions: FloatArray, rows: FloatArray) -> FloatArray:
    """Rotations (T, 4) at fractional rows (N,), along the shortest ways between neighbours."""
    before = np.clip(np.floor(rows).astype(int), 0, len(quaternions) - 2)
    begin, end = quaternions[before], quaternions[before + 1]
    return exp(begin, (rows - before)[:, None] * log(begin, end))
