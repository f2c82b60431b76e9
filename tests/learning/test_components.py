import numpy as np
import pytest
from learning_tasks import reaching_demonstrations
from scipy.special import multigammaln, softmax
from scipy.stats import beta

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    TPGMM,
    Frame,
    SyntheticDemonstration,
    bic,
    choose_by_bic,
    choose_by_dirichlet_process,
    em,
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


def expected_log_density(samples, weight, centre, scatter):
    """E[log N(x | mu, Lambda^-1)] by the textbook, of a Normal-Wishart of strength one."""
    size, mass = len(samples), weight.sum()
    mean, offset = np.average(samples, 1, weight), np.average(samples, 1, weight) - centre
    scatter = scatter + mass * np.cov(samples, aweights=weight, bias=True)
    scatter = scatter + mass / (1 + mass) * np.outer(offset, offset)
    degrees, mean = size + mass, (centre + mass * mean) / (1 + mass)

    def log_normaliser(degrees):
        log_det = np.linalg.slogdet(0.5 * scatter)[1]
        return multigammaln(0.5 * degrees, size) - 0.5 * degrees * log_det

    step = 1e-4  # a Wishart is an exponential family: log det is what belongs to degrees / 2
    log_det = (log_normaliser(degrees + step) - log_normaliser(degrees - step)) / step
    away = samples - mean[:, None]
    distances = np.einsum("in,ij,jn->n", away, np.linalg.inv(scatter), away)
    return 0.5 * (log_det - size / (1 + mass) - degrees * distances)


@pytest.mark.parametrize("n_frames", [1, 2])
@pytest.mark.parametrize("concentration", [0.7, 1.0, 20.0])
def test_one_variational_step_is_the_textbooks(n_frames, concentration):
    demonstrations = [
        SyntheticDemonstration(d.positions, d.dt, d.frames[:n_frames])
        for d in reaching_demonstrations(2, samples=13, wobble=0.05)
    ]
    model = TPGMM(1, floor=(0.5, 0.2))
    data, lengths = model.samples(demonstrations)
    floor = np.diag([0.5] * 3 + [0.2] * 3)
    variances = data.var(axis=2)
    slightly = np.array([floor + 1e-9 * np.diag(variance) for variance in variances])
    weights, _ = em.responsibilities(data, em.initialise_by_time(data, lengths, 3, slightly))
    weights = weights[np.argsort(-weights.sum(axis=1))]
    mass, logs, rest = weights.sum(axis=1), [], 0.0
    for k, weight in enumerate(weights):
        taken, left = 1 + mass[k], concentration + mass[k + 1 :].sum()
        log = beta(taken, left).expect(np.log) + rest
        rest += beta(left, taken).expect(np.log)
        for samples, variance in zip(data, variances, strict=True):
            scatter = 6 * (floor + 0.01 * np.diag(variance))
            log = log + expected_log_density(samples, weight, samples.mean(axis=1), scatter)
        logs.append(log)
    shares = np.sort(softmax(logs, axis=0).mean(axis=1))[::-1]
    settings = {"max_components": 3, "concentration": concentration, "max_steps": 1}
    choice = choose_by_dirichlet_process(model, demonstrations, **settings)
    np.testing.assert_allclose(choice.weights, shares, atol=1e-6)
    assert (choice.n_steps, choice.converged) == (1, False)
    assert choice.n_components == (shares > 0.01).sum()
    change = np.abs(shares - np.sort(mass / mass.sum())[::-1]).max()
    for factor in (0.99, 1.01):
        again = choose_by_dirichlet_process(
            model, demonstrations, **settings, tolerance=factor * change
        )
        assert again.converged is (factor > 1)


def test_a_time_based_model_counts_time_once_in_its_criterion():
    demonstrations = reaching_demonstrations(2)
    model = TPGMM(3, encoding="time").fit(demonstrations)
    expected = -2 * model.log_likelihood(demonstrations)
    expected += n_parameters(3, 2, 4, 1) * np.log(240)
    assert bic(model, demonstrations) == pytest.approx(expected)


def test_the_defaults_of_the_dirichlet_process():
    model, demonstrations = TPGMM(1, floor=1e-3), reaching_demonstrations(2, samples=40)
    plain = choose_by_dirichlet_process(model, demonstrations)
    said = choose_by_dirichlet_process(
        model,
        demonstrations,
        max_components=15,
        concentration=1.0,
        max_steps=500,
        tolerance=1e-4,
    )
    assert len(plain.weights) == 15
    assert plain.n_steps == said.n_steps > 1
    np.testing.assert_array_equal(plain.weights, said.weights)
    assert plain.converged
    assert choose_by_dirichlet_process(model, demonstrations, max_components=1).n_components == 1
