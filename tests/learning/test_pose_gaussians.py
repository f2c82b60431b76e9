import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, rotation
from dressing_sim.learning import pose_gaussians as poses
from dressing_sim.learning.pose_gaussians import PoseGaussians

BASE = np.concatenate([[0.4, -0.1, 0.7], Rotation.from_euler("xyz", [0.5, 1.0, -0.4]).as_quat()])


def definite(rng, *shape):
    factors = rng.normal(size=(*shape, 6, 6))
    return factors @ np.swapaxes(factors, -1, -2) + 0.3 * np.eye(6)


def close(one, other, atol=1e-8):
    np.testing.assert_allclose(poses.log(one, other), np.zeros_like(one[..., :-1]), atol=atol)


def test_exp_and_log_undo_each_other(rng):
    tangents = rng.normal(0.0, 0.8, (9, 6))
    np.testing.assert_allclose(
        poses.log(BASE, poses.exp(np.tile(BASE, (9, 1)), tangents)), tangents
    )


def test_a_product_of_narrow_ones_is_that_of_euclidean_ones(rng):
    """In the limit of small variances and near means the manifold is flat."""
    apart, covariances = rng.normal(size=(3, 6)), definite(rng, 3)
    precisions = np.linalg.inv(covariances)
    flat = np.linalg.inv(precisions.sum(axis=0))
    expected = flat @ np.einsum("pij,pj->i", precisions, apart)
    errors = []
    for scale in (1e-1, 1e-2, 1e-3):
        means = poses.exp(np.tile(BASE, (3, 1)), scale * apart)
        fused = PoseGaussians(means, scale**2 * covariances).product()
        errors.append(np.abs(poses.log(BASE, fused.means) / scale - expected).max())
        np.testing.assert_allclose(fused.covariances / scale**2, flat, atol=5 * scale)
    assert errors[0] > 5 * errors[1] > 25 * errors[2]
    assert errors[2] < 1e-2


def test_a_product_of_rotations_about_one_axis_is_that_of_their_angles():
    angles, variances = np.array([0.2, 1.4]), np.array([0.5, 0.25])
    means = poses.exp(np.tile(BASE, (2, 1)), np.outer(angles, [0, 0, 0, 0, 0, 1.0]))
    covariances = variances[:, None, None] * np.eye(6)
    fused = PoseGaussians(means, covariances).product()
    expected = (angles / variances).sum() / (1.0 / variances).sum()
    close(fused.means, poses.exp(BASE, np.array([0, 0, 0, 0, 0, expected])))


def test_the_product_with_itself_halves_the_covariance(rng):
    covariance = definite(rng)
    fused = PoseGaussians(np.stack([BASE, BASE]), np.stack([covariance, covariance])).product()
    close(fused.means, BASE)
    np.testing.assert_allclose(fused.covariances, 0.5 * covariance)


def test_signs_of_quaternions_change_nothing(rng):
    means = poses.exp(np.tile(BASE, (2, 1)), rng.normal(0.0, 0.4, (2, 6)))
    one = PoseGaussians(means, 0.1 * definite(rng, 2))
    other = PoseGaussians(means * np.array([1.0] * 3 + [-1.0] * 4), one.covariances)
    np.testing.assert_array_equal(one.log_density(BASE), other.log_density(BASE))
    np.testing.assert_array_equal(one.product().means, other.product().means)


def test_frames_turn_and_shift_a_product_with_them(rng):
    means = poses.exp(np.tile(BASE, (2, 1)), rng.normal(0.0, 0.3, (2, 6)))
    local = PoseGaussians(means, 0.1 * definite(rng, 2))
    frames = [Frame(rotation(rng.normal(size=3)), rng.normal(size=3)) for _ in range(2)]
    turn, shift = rotation([0.3, -1.0, 2.0]), np.array([0.5, 0.1, -2.0])
    moved = [Frame(turn @ one.A, turn @ one.b + shift) for one in frames]
    one, other = local.in_world(frames).product(), local.in_world(moved).product()
    scene = Frame(turn, shift)
    close(poses.seen_from(scene, other.means), one.means)
    carrying = np.kron(np.diag([1.0, 0.0]), turn) + np.kron(np.diag([0.0, 1.0]), np.eye(3))
    expected = carrying @ one.covariances @ carrying.T
    np.testing.assert_allclose(other.covariances, expected, atol=1e-8)


def test_in_world_undoes_seen_from(rng):
    frame = Frame(rotation(rng.normal(size=3)), rng.normal(size=3))
    local = PoseGaussians(poses.seen_from(frame, BASE)[None, None], np.eye(6)[None, None])
    close(local.in_world([frame]).means[0, 0], BASE)


def test_a_density_is_the_normal_one_in_the_tangent_space(rng):
    from scipy.stats import multivariate_normal

    covariance, tangents = definite(rng), rng.normal(0.0, 0.5, (4, 6))
    density = PoseGaussians(BASE, covariance).log_density(
        poses.exp(np.tile(BASE, (4, 1)), tangents)
    )
    np.testing.assert_allclose(
        density, multivariate_normal(np.zeros(6), covariance).logpdf(tangents)
    )


def test_frames_that_are_no_rotation_are_refused():
    with pytest.raises(InvalidInputError, match="no rotation"):
        poses.seen_from(Frame(np.diag([1.0, 1.0, -1.0]), np.zeros(3)), BASE)
    with pytest.raises(InvalidInputError, match="dimension 2, valid is 3"):
        poses.rotations([Frame(np.eye(2), np.zeros(2))])
