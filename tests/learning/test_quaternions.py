import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import quaternions as quat

AXIS = np.array([1.0, 2.0, -2.0]) / 3.0
START = Rotation.from_euler("xyz", [0.3, -0.8, 1.2]).as_quat()


def drawn(rng, count):
    return Rotation.random(count, rng=rng).as_quat()


def same(one, other, atol=1e-9):
    """Whether quaternions are the same rotations, whatever their signs."""
    np.testing.assert_allclose(np.abs((one * other).sum(axis=-1)), 1.0, atol=atol)


def test_exp_and_log_undo_each_other(rng):
    base, others = drawn(rng, 50), drawn(rng, 50)
    same(quat.exp(base, quat.log(base, others)), others)
    tangents = rng.normal(size=(50, 3))
    tangents *= rng.uniform(0.0, 3.1, (50, 1)) / np.linalg.norm(tangents, axis=1, keepdims=True)
    np.testing.assert_allclose(quat.log(base, quat.exp(base, tangents)), tangents, atol=1e-9)
    np.testing.assert_array_equal(quat.log(base, base), np.zeros((50, 3)))


def test_a_tangent_is_the_rotation_vector_of_scipy(rng):
    base, others = Rotation.random(20, rng=rng), Rotation.random(20, rng=rng)
    expected = (base.inv() * others).as_rotvec()
    np.testing.assert_allclose(quat.log(base.as_quat(), others.as_quat()), expected, atol=1e-9)
    product = quat.multiply(base.as_quat(), others.as_quat())
    same(product, (base * others).as_quat())


def test_the_sign_of_a_quaternion_changes_nothing_to_the_bit(rng):
    base, others = drawn(rng, 20), drawn(rng, 20)
    np.testing.assert_array_equal(quat.log(base, others), quat.log(-base, -others))
    np.testing.assert_array_equal(quat.log(base, others), quat.log(base, -others))
    flipped = others * rng.choice([-1.0, 1.0], (20, 1))
    weights = rng.uniform(size=20)
    np.testing.assert_array_equal(quat.mean(others, weights), quat.mean(flipped, weights))


def test_the_mean_of_a_geodesics_ends_is_its_middle_and_weights_divide_it():
    ends = quat.exp(START, np.array([0.0, 2.8])[:, None] * AXIS)
    same(quat.mean(ends, np.ones(2)), quat.exp(START, 1.4 * AXIS))
    same(quat.mean(ends, np.array([3.0, 1.0])), quat.exp(START, 0.7 * AXIS))


def test_a_mean_moves_along_with_what_it_is_of_on_either_side(rng):
    near = quat.exp(START, rng.normal(0.0, 0.5, (30, 3)))
    weights, turn = rng.uniform(size=30), drawn(rng, 1)[0]
    found = quat.mean(near, weights)
    same(quat.mean(quat.multiply(turn, near), weights), quat.multiply(turn, found))
    same(quat.mean(quat.multiply(near, turn), weights), quat.multiply(found, turn))
    # Where the gradient of the squared angles vanishes.
    np.testing.assert_allclose(weights @ quat.log(found, near), np.zeros(3), atol=1e-8)


def test_parallel_transport_is_that_of_the_sphere_in_four_dimensions(rng):
    """Along a great circle from q in direction e, u becomes u + (u e)((cos a - 1) e - sin a q)."""
    base, move, tangent = drawn(rng, 1)[0], rng.normal(size=3), rng.normal(size=3)

    def ambient(at, vector):
        return quat.multiply(at, np.append(0.5 * vector, 0.0))

    arc = 0.5 * np.linalg.norm(move)
    direction, u = ambient(base, move) / arc, ambient(base, tangent)
    along = u @ direction
    expected = u + along * ((np.cos(arc) - 1.0) * direction - np.sin(arc) * base)
    moved = quat.transport(move) @ tangent
    np.testing.assert_allclose(ambient(quat.exp(base, move), moved), expected, atol=1e-12)


def test_transport_keeps_lengths_the_geodesics_direction_and_comes_back(rng):
    move, tangent = rng.normal(size=(2, 7, 3))
    there = quat.transport(move)
    moved = np.einsum("nij,nj->ni", there, tangent)
    np.testing.assert_allclose(np.linalg.norm(moved, axis=1), np.linalg.norm(tangent, axis=1))
    np.testing.assert_allclose(np.einsum("nij,nj->ni", there, move), move, atol=1e-12)
    np.testing.assert_allclose(
        quat.transport(-move) @ there, np.tile(np.eye(3), (7, 1, 1)), atol=1e-12
    )


def test_signs_are_made_continuous_and_rows_are_interpolated_at_even_speed(rng):
    steps = quat.exp(START, np.linspace(0.0, 2.0, 11)[:, None] * AXIS)
    mixed = steps * rng.choice([-1.0, 1.0], (11, 1))
    smooth = quat.continuous(mixed)
    assert ((smooth[1:] * smooth[:-1]).sum(axis=1) > 0.9).all()
    assert smooth[0, 3] >= 0.0
    same(smooth, steps)
    between = quat.interpolated(mixed, np.array([0.0, 2.5, 10.0]))
    same(between, quat.exp(START, np.array([0.0, 0.5, 2.0])[:, None] * AXIS))


def test_matrices_and_quaternions_are_the_same_rotations(rng):
    drawn_ones = drawn(rng, 5)
    same(quat.of_matrices(quat.matrices(drawn_ones), "A"), drawn_ones)


@pytest.mark.parametrize("wrong", [np.diag([1.0, 1.0, -1.0]), 2.0 * np.eye(3)])
def test_a_matrix_that_is_no_rotation_is_refused(wrong):
    with pytest.raises(InvalidInputError, match="no rotation, valid is a rotation"):
        quat.of_matrices(wrong, "A")


def test_a_quaternion_that_is_not_of_length_one_is_refused():
    with pytest.raises(InvalidInputError, match="of length 2, valid is 1"):
        quat.unit([[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 2.0]], "it")
    with pytest.raises(InvalidInputError, match="valid is"):
        quat.unit([1.0, 0.0], "it")
