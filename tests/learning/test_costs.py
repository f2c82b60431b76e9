import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import dtw_cost, dtw_distance, rms_cost


def test_the_rms_cost_is_the_mean_of_the_whole_paths_errors():
    demonstrated = [np.zeros((2, 2)), np.zeros((3, 2))]
    reproductions = [np.array([[3.0, 0.0], [0.0, 4.0]]), np.full((3, 2), 1.0)]
    assert rms_cost(reproductions, demonstrated) == pytest.approx((5.0 + np.sqrt(6.0)) / 2)


def test_the_dtw_cost_is_the_mean_distance():
    rng = np.random.default_rng(0)
    a, b = [rng.random((9, 2)), rng.random((5, 2))], [rng.random((7, 2)), rng.random((8, 2))]
    assert dtw_cost(a, b) == pytest.approx(np.mean(list(map(dtw_distance, a, b))))


def test_paths_that_do_not_match_are_errors():
    with pytest.raises(InvalidInputError, match="shape"):
        rms_cost([np.zeros((2, 2))], [np.zeros((3, 2))])
    for cost in (rms_cost, dtw_cost):
        with pytest.raises(InvalidInputError, match="one reproduction"):
            cost([], [])
        with pytest.raises(InvalidInputError, match="one reproduction"):
            cost([np.zeros((2, 2))] * 2, [np.zeros((2, 2))])


def test_stacked_paths_and_lists_are_paths_and_nan_is_an_error():
    a, b = np.random.default_rng(0).random((2, 4, 6, 3))
    for cost in (rms_cost, dtw_cost):
        assert cost(a, b) == cost(list(a), list(b)) == cost(a.tolist(), b.tolist())
        with pytest.raises(InvalidInputError, match="finite"):
            cost([a[0], np.full((6, 3), np.nan)], list(b[:2]))
