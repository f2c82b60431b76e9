import numpy as np
import pytest
from learning_tasks import reaching_demonstrations, reaching_situation
from scipy.stats import multivariate_normal

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import TPGMM, Frame
from dressing_sim.learning.em import Mixture
from dressing_sim.learning.gmr import (
    WorldMixture,
    check_fusion,
    lift,
    product,
    regression,
    to_world,
)


def random_mixture(k=3, p=2, d=4, seed=0):
    rng = np.random.default_rng(seed)
    roots = rng.standard_normal((k, p, d, d))
    covariances = roots @ roots.transpose(0, 1, 3, 2) + 0.1 * np.eye(d)
    return Mixture(rng.dirichlet(np.ones(k)), rng.standard_normal((k, p, d)), covariances)


def one_view(mixture):
    return WorldMixture(
        mixture.priors,
        np.ascontiguousarray(mixture.means.transpose(1, 0, 2)),
        np.ascontiguousarray(mixture.covariances.transpose(1, 0, 2, 3)),
    )


def direct_regression(mixture, query, i):
    """Conditional mean and covariance of a one-frame mixture, by the textbook."""
    means, covariances, weights = [], [], []
    for prior, mean, s in zip(
        mixture.priors, mixture.means[:, 0], mixture.covariances[:, 0], strict=True
    ):
        gain = s[i:, :i] @ np.linalg.inv(s[:i, :i])
        means.append(mean[i:] + gain @ (query - mean[:i]))
        covariances.append(s[i:, i:] - gain @ s[:i, i:])
        weights.append(prior * multivariate_normal(mean[:i], s[:i, :i]).pdf(query))
    weights = np.array(weights) / np.sum(weights)
    centre = weights @ np.array(means)
    spread = sum(
        w * (c + np.outer(m, m)) for w, c, m in zip(weights, covariances, means, strict=True)
    )
    return centre, spread - np.outer(centre, centre)


def test_regression_is_the_conditional_with_the_spread_of_means():
    mixture = random_mixture(p=1)
    queries = np.random.default_rng(1).standard_normal((6, 2))
    means, covariances = regression(one_view(mixture), 2)(queries)
    for query, mean, covariance in zip(queries, means, covariances, strict=True):
        expected_mean, expected_covariance = direct_regression(mixture, query, 2)
        np.testing.assert_allclose(mean, expected_mean, atol=1e-10)
        np.testing.assert_allclose(covariance, expected_covariance, atol=1e-10)


def test_several_views_are_multiplied():
    mixture = random_mixture(p=2)
    query = np.array([0.3, -0.2])
    mean, covariance = regression(one_view(mixture), 2)(query[None])
    precision, weighted = 0.0, 0.0
    for p in range(2):
        view = Mixture(mixture.priors, mixture.means[:, [p]], mixture.covariances[:, [p]])
        m, c = direct_regression(view, query, 2)
        precision = precision + np.linalg.inv(c)
        weighted = weighted + np.linalg.inv(c) @ m
    np.testing.assert_allclose(covariance[0], np.linalg.inv(precision), atol=1e-10)
    np.testing.assert_allclose(mean[0], np.linalg.inv(precision) @ weighted, atol=1e-10)


def test_the_product_of_gaussians_is_proportional_to_the_product_of_their_densities():
    world = one_view(random_mixture(k=1, p=2, d=2))
    fused = product(world)
    points = np.random.default_rng(0).standard_normal((5, 2))

    def log_density(mixture, view):
        return multivariate_normal(mixture.means[view, 0], mixture.covariances[view, 0]).logpdf(
            points
        )

    difference = log_density(world, 0) + log_density(world, 1) - log_density(fused, 0)
    np.testing.assert_allclose(difference, difference[0], atol=1e-9)


def test_components_move_to_the_world_as_samples_do():
    frames = [Frame([[0, -2], [1, 0]], [3, 4]), Frame([[1, 0], [0, -1]], [0, 1])]
    bases, origins = lift(frames, n_time=1, n_copies=2)
    rng = np.random.default_rng(0)
    samples = rng.standard_normal((1000, 5))
    mixture = Mixture(
        np.ones(1),
        np.tile(samples.mean(axis=0), (1, 2, 1)),
        np.tile(np.cov(samples.T, bias=True), (1, 2, 1, 1)),
    )
    world = to_world(mixture, bases, origins)
    for p, frame in enumerate(frames):
        moved = np.concatenate(
            [
                samples[:, :1],
                frame.to_world(samples[:, 1:3]),
                frame.displacements_to_world(samples[:, 3:]),
            ],
            axis=1,
        )
        np.testing.assert_allclose(world.means[p, 0], moved.mean(axis=0), atol=1e-12)
        np.testing.assert_allclose(world.covariances[p, 0], np.cov(moved.T, bias=True), atol=1e-12)


def test_the_two_orders_agree_for_one_frame_and_differ_for_two():
    demonstrations = reaching_demonstrations()
    situation = reaching_situation(np.random.default_rng(9))
    query = demonstrations[0].positions[40:60]
    model = TPGMM(4).fit(demonstrations)
    a, b = (
        model.regression(situation, order)(query)[0]
        for order in ("regression-then-product", "product-then-regression")
    )
    assert np.abs(a - b).max() > 1e-6
    single = [type(d)(d.positions, d.dt, d.frames[:1]) for d in demonstrations]
    model = TPGMM(4).fit(single)
    a, b = (
        model.regression(situation[:1], order)(query)[0]
        for order in ("regression-then-product", "product-then-regression")
    )
    np.testing.assert_allclose(a, b, atol=1e-10)


def test_an_unknown_order_names_the_two():
    with pytest.raises(InvalidInputError, match="regression-then-product, product-then"):
        check_fusion("both")


def test_queries_far_away_stay_finite():
    demonstrations = reaching_demonstrations()
    model = TPGMM(4).fit(demonstrations)
    for order in ("regression-then-product", "product-then-regression"):
        for shared in (False, True):
            result = model.regression(demonstrations[0].frames, order, shared=shared)
            means, covariances = result(np.full((1, 3), 1e6))
            assert np.isfinite(means).all()
            assert np.isfinite(covariances).all()


def test_shared_responsibilities_are_those_of_the_product_of_input_densities():
    mixture = random_mixture(p=2)
    query, ridge = np.array([0.3, -0.2]), np.array([0.2 * np.eye(2), 0.5 * np.eye(2)])
    mean, covariance = regression(one_view(mixture), 2, ridge, shared=True)(query[None])
    weights = mixture.priors**2
    for p in range(2):
        weights = weights * [
            multivariate_normal(m[p, :2], c[p, :2, :2]).pdf(query)
            for m, c in zip(mixture.means, mixture.covariances, strict=True)
        ]
    weights = weights / weights.sum()
    precision, weighted = 0.0, 0.0
    for p in range(2):
        centres, spreads = [], []
        for k in range(3):
            one = Mixture(np.ones(1), mixture.means[[k]][:, [p]], mixture.covariances[[k]][:, [p]])
            m, c = direct_regression(one, query, 2)
            centres.append(m)
            spreads.append(c + np.outer(m, m))
        centre = weights @ np.array(centres)
        spread = np.einsum("k,kij->ij", weights, spreads) - np.outer(centre, centre) + ridge[p]
        precision = precision + np.linalg.inv(spread)
        weighted = weighted + np.linalg.inv(spread) @ centre
    np.testing.assert_allclose(covariance[0], np.linalg.inv(precision), atol=1e-10)
    np.testing.assert_allclose(mean[0], np.linalg.inv(precision) @ weighted, atol=1e-10)


def test_a_ridge_is_added_to_the_covariance_of_the_only_view():
    world, query = one_view(random_mixture(p=1)), np.array([[0.3, -0.2]])
    ridge = np.array([[[0.7, 0.2], [0.2, 0.4]]])
    mean, covariance = regression(world, 2, ridge)(query)
    plain_mean, plain_covariance = regression(world, 2)(query)
    np.testing.assert_allclose(mean, plain_mean)
    np.testing.assert_allclose(covariance, plain_covariance + ridge)


def test_an_empty_component_has_no_say():
    mixture = random_mixture(p=1)
    priors = np.array([0.4, 0.6, 0.0])
    query = np.array([[0.3, -0.2]])
    with_empty = Mixture(priors, mixture.means, mixture.covariances)
    without = Mixture(priors[:2], mixture.means[:2], mixture.covariances[:2])
    for a, b in zip(
        regression(one_view(with_empty), 2)(query),
        regression(one_view(without), 2)(query),
        strict=True,
    ):
        np.testing.assert_allclose(a, b)


@pytest.mark.parametrize("order", ["regression-then-product", "product-then-regression"])
def test_a_ridge_lies_in_the_frame_it_belongs_to(order):
    """It goes with the frame's basis before the product over frames, and with none after it."""
    demonstrations = reaching_demonstrations()
    single = [type(d)(d.positions, d.dt, d.frames[:1]) for d in demonstrations]
    basis = np.diag([1.0, 2.0, 0.5])
    frame, query = Frame(basis, [0.1, 0, 0]), demonstrations[0].positions[40:44]
    model = TPGMM(3).fit(single)
    means, covariances = model.regression([frame], order, 0.3)(query)
    plain_means, plain = model.regression([frame], order)(query)
    expected = basis @ basis.T if order == "regression-then-product" else np.eye(3)
    np.testing.assert_allclose(covariances - plain, np.tile(0.3 * expected, (4, 1, 1)), atol=1e-9)
    np.testing.assert_allclose(means, plain_means)
