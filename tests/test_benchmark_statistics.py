import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressing_sim.benchmark.statistics import wilson_interval

counts = st.integers(1, 500).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n)))


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [
        (0, 5, 0.0, 0.4345),
        (1, 5, 0.0362, 0.6245),
        (3, 5, 0.2307, 0.8824),
        (4, 5, 0.3755, 0.9638),
        (5, 5, 0.5655, 1.0),
        (0, 10, 0.0, 0.2775),
        (50, 100, 0.4038, 0.5962),
        (100, 100, 0.9630, 1.0),
    ],
)
def test_known_values(successes, trials, low, high):
    np.testing.assert_allclose(wilson_interval(successes, trials), (low, high), atol=5e-5)


@given(counts)
def test_the_interval_is_the_closed_form(count):
    successes, trials = count
    z, p = 1.959963984540054, successes / trials
    middle = (p + z**2 / (2 * trials)) / (1 + z**2 / trials)
    half = z / (1 + z**2 / trials) * np.sqrt(p * (1 - p) / trials + z**2 / (4 * trials**2))
    expected = np.clip([middle - half, middle + half], 0.0, 1.0)
    np.testing.assert_allclose(wilson_interval(successes, trials), expected, atol=1e-9)


@given(counts)
def test_the_interval_holds_the_rate_and_mirrors_failures(count):
    successes, trials = count
    low, high = wilson_interval(successes, trials)
    assert 0.0 <= low <= successes / trials <= high <= 1.0
    mirrored = wilson_interval(trials - successes, trials)
    np.testing.assert_allclose(mirrored, (1.0 - high, 1.0 - low), atol=1e-12)


def test_more_confidence_is_a_wider_interval():
    low, high = wilson_interval(3, 5, confidence=0.5)
    wider = wilson_interval(3, 5, confidence=0.99)
    assert wider[0] < low < high < wider[1]


def test_without_a_trial_nothing_is_known():
    assert wilson_interval(0, 0) == (0.0, 1.0)
