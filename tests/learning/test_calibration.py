import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.calibration import Logistic, calibrated


def drawn(n, weights, intercept, seed=0):
    rng = np.random.default_rng(seed)
    features = rng.normal(3.0, 2.0, (n, len(weights)))
    odds = (features - 3.0) / 2.0 @ weights + intercept
    return features, rng.uniform(size=n) < 1.0 / (1.0 + np.exp(-odds))


def test_it_recovers_known_coefficients():
    weights = np.array([1.5, -0.8, 0.0])
    found = Logistic.fit(*drawn(40_000, weights, 0.7))
    np.testing.assert_allclose(found.weights, weights, atol=0.06)
    assert found.intercept == pytest.approx(0.7, abs=0.05)


def test_the_gradient_vanishes_where_it_ends():
    features, happened = drawn(60, np.array([1.0, -1.0]), 0.2)
    found = Logistic.fit(features, happened, penalty=2.0)
    n1 = happened.sum()
    targets = np.where(happened, (n1 + 1) / (n1 + 2), 1 / (len(happened) - n1 + 2))
    left = found.probability(features) - targets
    assert left.sum() == pytest.approx(0.0, abs=1e-9)
    x = (features - found.mean) / found.scale
    np.testing.assert_allclose(x.T @ left + 2.0 * found.weights, 0.0, atol=1e-4)


def test_units_and_offsets_of_features_do_not_matter():
    features, happened = drawn(80, np.array([1.0, 0.5]), 0.0)
    other = features * [1000.0, -0.01] + [5.0, 7.0]
    for fit in (Logistic.fit, calibrated):
        np.testing.assert_allclose(
            fit(other, happened).probability(other),
            fit(features, happened).probability(features),
            atol=1e-7,
        )


def test_where_all_succeed_the_probability_is_laplaces():
    features = np.random.default_rng(0).normal(size=(8, 3))
    for fit in (Logistic.fit, calibrated):
        np.testing.assert_allclose(fit(features, [True] * 8).probability(features), 0.9, atol=1e-4)


def test_a_feature_that_is_always_the_same_says_nothing():
    features, happened = drawn(50, np.array([1.0]), 0.0)
    constant = np.column_stack([features, np.full(50, 0.1)])
    found = calibrated(constant, happened)
    assert found.weights[1] == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(
        found.probability(constant), calibrated(features, happened).probability(features), atol=1e-6
    )


def test_calibration_tempers_a_model_that_is_too_sure():
    features, happened = drawn(60, np.append([1.0], np.zeros(12)), 0.0, seed=1)
    fresh, truth = drawn(5000, np.append([1.0], np.zeros(12)), 0.0, seed=2)
    plain = Logistic.fit(features, happened, penalty=0.01)
    tempered = calibrated(features, happened, penalty=0.01)
    assert np.abs(tempered.weights).sum() < 0.8 * np.abs(plain.weights).sum()
    losses = [np.mean((model.probability(fresh) - truth) ** 2) for model in (plain, tempered)]
    assert losses[1] < losses[0]
    # It is the same model but for how sure it is.
    np.testing.assert_allclose(
        tempered.weights / np.linalg.norm(tempered.weights),
        plain.weights / np.linalg.norm(plain.weights),
    )


def test_scores_that_say_nothing_give_all_the_same_probability():
    rng = np.random.default_rng(4)
    features = rng.normal(size=(30, 8))
    happened = np.arange(30) % 2 == 0  # each fold's model learns the contrary of what it is asked
    found = calibrated(features, happened, folds=2)
    p = found.probability(features)
    np.testing.assert_allclose(p, 0.5, atol=0.1)


@pytest.mark.parametrize(
    ("features", "happened", "penalty", "part"),
    [
        (np.zeros((3, 2)), [True, False], 1.0, "successes have shape"),
        (np.zeros(3), [True] * 3, 1.0, "features have"),
        (np.zeros((3, 2)), [True] * 3, -1.0, "penalty"),
        (np.full((3, 2), np.nan), [True] * 3, 1.0, "features have"),
    ],
)
def test_what_cannot_be_fitted_is_an_error(features, happened, penalty, part):
    with pytest.raises(InvalidInputError, match=part):
        Logistic.fit(features, happened, penalty)
