import numpy as np
import pytest

from dressing_sim.benchmark.analysis.forecasts import Forecasts, surest
from dressing_sim.errors import InvalidInputError


def perfect():
    """Of those told a probability of k in ten, k in ten succeed."""
    p = np.repeat(np.arange(11) / 10.0, 10)
    return Forecasts.of(p, np.tile(np.arange(10), 11) < np.round(10.0 * p))


def random(n=200, seed=0):
    rng = np.random.default_rng(seed)
    p = rng.uniform(size=n).round(2)
    return Forecasts.of(p, rng.uniform(size=n) < p**2)


def test_a_perfectly_calibrated_forecast_scores_its_own_variance():
    forecasts = perfect()
    p = forecasts.probabilities
    assert forecasts.brier == pytest.approx(np.mean(p * (1.0 - p)))
    assert forecasts.decomposition.miscalibration == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(forecasts.recalibrated, p)
    for one in forecasts.bins(11):
        assert one.rate.percent == pytest.approx(100.0 * one.probability)


@pytest.mark.parametrize("seed", range(5))
def test_the_decomposition_sums_to_the_score_and_no_part_is_negative(seed):
    forecasts = random(seed=seed)
    parts = forecasts.decomposition
    assert parts.score == pytest.approx(forecasts.brier, abs=1e-15)
    assert parts.miscalibration > 0.0
    assert parts.discrimination > 0.0
    rate = forecasts.successes.mean()
    assert parts.uncertainty == pytest.approx(rate * (1.0 - rate))


def test_telling_all_the_same_discriminates_nothing():
    parts = Forecasts.of(np.full(40, 0.3), np.arange(40) < 20).decomposition
    assert parts.discrimination == pytest.approx(0.0, abs=1e-15)
    assert parts.miscalibration == pytest.approx(0.2**2)


def test_a_rising_function_of_the_probabilities_discriminates_as_well():
    forecasts = random()
    other = Forecasts.of(forecasts.probabilities**3, forecasts.successes)
    assert other.decomposition.discrimination == pytest.approx(
        forecasts.decomposition.discrimination
    )


def test_at_full_coverage_success_is_the_plain_rate():
    forecasts = random()
    covered = forecasts.coverage()
    assert covered[0].share == 1.0
    assert covered[0].rate.n_success == forecasts.successes.sum()
    assert covered[0].rate.n == len(forecasts)
    shares = [one.share for one in covered]
    assert shares == sorted(shares, reverse=True)
    for one in covered:
        tried = forecasts.probabilities >= one.threshold
        assert (one.rate.n, one.rate.n_success) == (tried.sum(), forecasts.successes[tried].sum())
    assert surest(covered, 1.0) == covered[0]
    half = surest(covered, 0.5)
    assert 0.5 <= half.share < 0.52
    assert half.rate.percent > covered[0].rate.percent


def test_equal_probabilities_stay_together():
    forecasts = Forecasts.of([0.5] * 23 + [0.9] * 17, [True] * 40)
    assert [one.rate.n for one in forecasts.bins()] == [23, 17]
    assert [one.rate.n for one in forecasts.coverage()] == [40, 17]


def test_bins_hold_every_episode_once():
    forecasts = random(97)
    bins = forecasts.bins(10)
    assert sum(one.rate.n for one in bins) == 97
    assert sum(one.rate.n_success for one in bins) == forecasts.successes.sum()
    p = [one.probability for one in bins]
    assert p == sorted(p)
    assert 8 <= len(bins) <= 10


def test_the_gain_is_the_difference_of_scores():
    forecasts = random()
    constant = Forecasts.of(np.full(len(forecasts), 0.4), forecasts.successes)
    gain = forecasts.gain(0.4, np.random.default_rng(0))
    assert gain.value == pytest.approx(constant.brier - forecasts.brier)
    assert gain.interval[0] < gain.value < gain.interval[1]
    assert constant.gain(0.4, np.random.default_rng(0)).interval == (0.0, 0.0)


@pytest.mark.parametrize(
    ("p", "happened", "part"),
    [
        ([], [], "probabilities have"),
        ([0.5, 1.2], [True, False], "0.5 to 1.2, valid is 0 to 1"),
        ([0.5], [True, False], "successes have shape"),
    ],
)
def test_what_is_no_forecast_is_an_error(p, happened, part):
    with pytest.raises(InvalidInputError, match=part):
        Forecasts.of(p, happened)
