import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    TPGMM,
    Frame,
    SyntheticDemonstration,
    bic,
    choose_by_bic,
    choose_by_dirichlet_process,
    n_parameters,
)


def stops(n_stops, seed=0, samples=60):
    """Slow wobbling about a few places, one after the other: a task with that many clusters."""
    rng = np.random.default_rng(seed)
    places = np.array([[3.0 * i, (-1.0) ** i] for i in range(n_stops)])
    frames = (Frame([[0, -1], [1, 0]], [1, 1]),)
    return [
        SyntheticDemonstration(
            np.repeat(places, samples, axis=0) + 0.1 * rng.standard_normal((samples * n_stops, 2)),
            0.1,
            frames,
        )
        for _ in range(3)
    ]


@pytest.mark.parametrize(
    ("k", "p", "d", "shared", "expected"),
    [
        # By hand: priors, then means and symmetric covariances.
        (1, 1, 2, 0, 0 + 2 + 3),
        (3, 2, 6, 0, 2 + 3 * 2 * (6 + 21)),
        # Time once: its mean and variance; in a frame 2 means, 2 cross terms, 3 covariances.
        (8, 2, 3, 1, 7 + 8 * (2 + 2 * (2 + 2 + 3))),
    ],
)
def test_parameters_are_counted_as_by_hand(k, p, d, shared, expected):
    assert n_parameters(k, p, d, shared) == expected


def test_the_criterion_is_the_likelihood_and_a_price_for_each_parameter():
    demonstrations = reaching_demonstrations(2)
    model = TPGMM(3).fit(demonstrations)
    n_samples = model.samples(demonstrations)[0].shape[2]
    expected = -2 * model.log_likelihood(demonstrations)
    expected += n_parameters(3, 2, 6) * np.log(n_samples)
    assert bic(model, demonstrations) == pytest.approx(expected)


@pytest.mark.parametrize("n_stops", [2, 4])
def test_the_right_number_is_found(n_stops):
    # Time, scaled to nothing, leaves the places: Gaussian clusters, which have a right number.
    model = TPGMM(1, encoding="time", time_scale=1e-6, floor=(1.0, 1e-6))
    demonstrations = stops(n_stops)
    choice = choose_by_bic(model, demonstrations, range(1, 9))
    assert choice.n_components == n_stops
    assert [k for k, _ in choice.scores] == list(range(1, 9))
    assert model.n_components == 1
    dirichlet = choose_by_dirichlet_process(model, demonstrations, max_components=9)
    assert dirichlet.n_components == n_stops
    assert dirichlet.converged
    assert dirichlet.weights.sum() == pytest.approx(1.0)


def test_numbers_that_cannot_be_fitted_are_left_out():
    demonstrations = stops(2, samples=4)
    choice = choose_by_bic(TPGMM(1, encoding="time"), demonstrations, [1, 2, 500])
    assert [k for k, _ in choice.scores] == [1, 2]
    with pytest.raises(InvalidInputError, match="too few"):
        choose_by_bic(TPGMM(1, encoding="time"), demonstrations, [500])
    with pytest.raises(InvalidInputError, match="concentration"):
        choose_by_dirichlet_process(TPGMM(1), demonstrations, concentration=0.0)


def test_a_candidate_below_one_is_an_error():
    with pytest.raises(InvalidInputError, match="a candidate is 0"):
        choose_by_bic(TPGMM(2), reaching_demonstrations(2), range(3))
