import numpy as np
import pytest

from dressing_sim.learning.gmr import Regression
from dressing_sim.learning.kernels.exponential import exp_below_zero
from dressing_sim.learning.kernels.linalg import cholesky, invert_definite, invert_lower
from dressing_sim.learning.kernels.regression import regress


def test_the_exponential_is_exact_to_rounding():
    x = np.concatenate([-np.logspace(-12, np.log10(39.9), 2000), [0.0], -np.arange(1, 40) * 1.0])
    shift = np.full_like(x, 3.0)
    values = x + shift
    expected = np.exp(values - shift)
    exp_below_zero(values, shift, len(values))
    np.testing.assert_allclose(values, expected, rtol=3e-15)


def test_what_is_negligible_is_zero_and_the_rest_is_left_alone():
    values = np.array([-41.0, -1e9, -np.inf, 0.0, 7.0])
    exp_below_zero(values, np.zeros(5), 4)
    np.testing.assert_array_equal(values, [0, 0, 0, 1, 7])


@pytest.mark.parametrize("size", [1, 2, 3, 6])
def test_factors_and_inverses(size):
    root = np.random.default_rng(size).standard_normal((size, size))
    matrix = root @ root.T + 0.1 * np.eye(size)
    factor, lower, inverse = (np.full((size, size), np.nan) for _ in range(3))
    assert cholesky(matrix, factor)
    np.testing.assert_allclose(factor, np.linalg.cholesky(matrix))
    lower[:] = 0.0
    invert_lower(factor, lower)
    np.testing.assert_allclose(lower @ factor, np.eye(size), atol=1e-10)
    assert invert_definite(matrix, inverse) == pytest.approx(np.linalg.slogdet(matrix)[1])
    np.testing.assert_allclose(inverse, np.linalg.inv(matrix), rtol=1e-8)


@pytest.mark.parametrize("matrix", [-np.eye(2), np.ones((2, 2)), np.full((2, 2), np.nan)])
def test_a_matrix_that_is_not_definite_is_told(matrix):
    assert not cholesky(matrix.astype(float), np.empty((2, 2)))
    assert np.isnan(invert_definite(matrix.astype(float), np.empty((2, 2))))


def test_a_frame_without_a_definite_covariance_gives_nan_and_not_what_memory_held():
    definite, singular = np.eye(2), np.array([[1.0, 1.0], [1.0, 1.0]])
    mixture = Regression(
        np.zeros((2, 1)),
        np.zeros((2, 1, 2)),
        np.broadcast_to(np.eye(2), (2, 1, 2, 2)).copy(),
        np.ones((2, 1, 2)),
        np.zeros((2, 1, 2, 2)),
        np.stack([definite, singular])[:, None],
        np.zeros((2, 2, 2)),
        False,
    )
    means, covariances = regress(np.zeros((3, 2)), mixture)
    assert np.isnan(means).all()
    assert np.isnan(covariances).all()


def test_the_exponential_is_cut_off_at_forty_below():
    values = np.array([-39.999, -40.0, -40.001])
    expected = [np.exp(-39.999), 0.0, 0.0]
    exp_below_zero(values, np.zeros(3), 3)
    np.testing.assert_allclose(values, expected, rtol=3e-15)


def test_a_factor_and_an_inverse_are_triangular_whatever_was_there():
    matrix = np.array([[4.0, 2.0, 1.0], [2.0, 5.0, 3.0], [1.0, 3.0, 6.0]])
    factor, lower = np.full((3, 3), 7.0), np.full((3, 3), 7.0)
    assert cholesky(matrix, factor)
    invert_lower(factor, lower)
    np.testing.assert_array_equal(np.triu(factor, 1), 0.0)
    np.testing.assert_array_equal(np.triu(lower, 1), 0.0)
    np.testing.assert_allclose(lower, np.linalg.inv(factor))
