import numpy as np
import pytest
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import EMOptions
from dressing_sim.learning.em import (
    Mixture,
    covariance_floor,
    fit_mixture,
    initialise_by_k_means,
    initialise_by_time,
    responsibilities,
)


def curves(n_frames=2, n_dims=3, lengths=(150, 70, 101), seed=0):
    """Smooth noisy curves seen from unrelated frames: (P, D, N)."""
    rng = np.random.default_rng(seed)
    phases = np.concatenate([np.linspace(0, 1, length) for length in lengths])
    waves = np.arange(1, 4)[:, None] * np.pi * phases
    mixing = rng.standard_normal((n_frames, n_dims, 6))
    data = mixing @ np.concatenate([np.sin(waves), np.cos(waves)])
    return data + 0.1 * rng.standard_normal(data.shape), lengths


def direct_log_likelihoods(data, mixture):
    """log(pi_k prod_p N(x_p | ...)), (K, N), by scipy."""
    return np.array(
        [
            np.log(mixture.priors[k])
            + sum(
                multivariate_normal(mixture.means[k, p], mixture.covariances[k, p]).logpdf(
                    data[p].T
                )
                for p in range(len(data))
            )
            for k in range(mixture.n_components)
        ]
    )


def zero_floor(data):
    return np.zeros((data.shape[0], data.shape[1], data.shape[1]))


def test_responsibilities_are_the_frames_product_of_densities():
    data, lengths = curves()
    mixture = initialise_by_time(data, lengths, 5, zero_floor(data))
    logs = direct_log_likelihoods(data, mixture)
    weights, log_likelihood = responsibilities(data, mixture)
    np.testing.assert_allclose(weights, np.exp(logs - logsumexp(logs, axis=0)), atol=1e-12)
    assert log_likelihood == pytest.approx(logsumexp(logs, axis=0).sum(), rel=1e-12)


def test_one_step_is_the_weighted_moments():
    data, lengths = curves()
    start = initialise_by_time(data, lengths, 4, zero_floor(data))
    weights, _ = responsibilities(data, start)
    mixture, _ = fit_mixture(data, start, zero_floor(data), EMOptions(1, 1, 0.0))
    np.testing.assert_allclose(mixture.priors, weights.mean(axis=1), rtol=1e-10)
    for k, weight in enumerate(weights):
        for p, samples in enumerate(data):
            np.testing.assert_allclose(mixture.means[k, p], np.average(samples, 1, weight))
            expected = np.cov(samples, aweights=weight, bias=True)
            np.testing.assert_allclose(mixture.covariances[k, p], expected, atol=1e-10)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("n_components", [1, 3, 6])
def test_the_likelihood_never_falls(seed, n_components):
    data, lengths = curves(seed=seed)
    start = initialise_by_time(data, lengths, n_components, zero_floor(data))
    _, record = fit_mixture(data, start, zero_floor(data), EMOptions(5, 200, 0.0))
    assert np.diff(record.log_likelihoods).min(initial=0.0) >= -1e-10


def test_it_stops_by_the_tolerance_and_says_so():
    data, lengths = curves()
    start = initialise_by_time(data, lengths, 3, zero_floor(data))
    _, record = fit_mixture(data, start, zero_floor(data), EMOptions(5, 500, 1e-4))
    gains = np.diff(record.log_likelihoods)
    assert record.converged
    assert gains[-1] < 1e-4
    assert (gains[4:-1] >= 1e-4).all()
    _, cut_short = fit_mixture(data, start, zero_floor(data), EMOptions(5, 5, 1e-9))
    assert not cut_short.converged
    assert cut_short.n_steps == 5


def test_the_start_is_left_as_it_is():
    data, lengths = curves()
    start = initialise_by_time(data, lengths, 3, zero_floor(data))
    means = start.means.copy()
    fit_mixture(data, start, zero_floor(data), EMOptions())
    np.testing.assert_array_equal(start.means, means)


def test_order_of_samples_does_not_matter():
    data, lengths = curves()
    start = initialise_by_time(data, lengths, 4, zero_floor(data))
    shuffled = data[:, :, np.random.default_rng(1).permutation(data.shape[2])]
    a, _ = fit_mixture(data, start, zero_floor(data), EMOptions())
    b, _ = fit_mixture(shuffled, start, zero_floor(data), EMOptions())
    np.testing.assert_allclose(a.means, b.means, atol=1e-8)
    np.testing.assert_allclose(a.covariances, b.covariances, atol=1e-8)


def test_samples_far_from_every_component_do_not_underflow():
    data, lengths = curves()
    start = initialise_by_time(data, lengths, 3, zero_floor(data))
    far = data + 1e4
    weights, log_likelihood = responsibilities(far, start)
    assert np.isfinite(log_likelihood)
    np.testing.assert_allclose(weights.sum(axis=0), 1.0)


def test_an_absolute_floor_is_added_and_a_relative_one_follows_the_scale():
    data, _ = curves()
    absolute = covariance_floor(data, (1, 2), (1e-2, 1e-3), relative=False)
    np.testing.assert_allclose(absolute, np.tile(np.diag([1e-2, 1e-3, 1e-3]), (2, 1, 1)))
    relative = covariance_floor(data, (1, 2), (0.1, 0.1), relative=True)
    scaled = covariance_floor(7 * data, (1, 2), (0.1, 0.1), relative=True)
    np.testing.assert_allclose(scaled, 49 * relative)
    assert relative[0, 1, 1] == relative[0, 2, 2] == pytest.approx(0.1 * data[0, 1:].var(1).mean())


def test_the_floor_bounds_every_covariance():
    data, lengths = curves()
    floor = covariance_floor(data, (3,), (0.05,), relative=False)
    start = initialise_by_time(data, lengths, 6, floor)
    mixture, _ = fit_mixture(data, start, floor, EMOptions())
    assert np.linalg.eigvalsh(mixture.covariances).min() >= 0.05 * (1 - 1e-9)


def test_a_singular_covariance_is_a_clear_error():
    line = np.linspace(0, 1, 50)
    data = np.stack([line, 2 * line])[None]
    floor = zero_floor(data)
    flat = Mixture(np.ones(1), np.zeros((1, 1, 2)), np.ones((1, 1, 2, 2)))
    with pytest.raises(InvalidInputError, match="larger covariance floor"):
        fit_mixture(data, flat, floor, EMOptions())
    with pytest.raises(InvalidInputError, match="singular"):
        responsibilities(data, flat)


def test_too_few_samples_for_the_components_is_a_clear_error():
    data, lengths = curves(lengths=(5,))
    with pytest.raises(InvalidInputError, match="too few"):
        initialise_by_time(data, lengths, 4, zero_floor(data))


def test_k_means_clusters_all_frames_at_once_and_repeats_with_its_seed():
    rng = np.random.default_rng(0)
    centres = np.array([0.0, 5.0, 10.0])
    labels = rng.integers(3, size=300)
    data = np.stack([centres[labels], -centres[labels]])[:, None] + 0.1 * rng.standard_normal(
        (2, 1, 300)
    )
    floor = zero_floor(data)
    mixture = initialise_by_k_means(data, 3, floor, np.random.default_rng(5))
    again = initialise_by_k_means(data, 3, floor, np.random.default_rng(5))
    np.testing.assert_array_equal(mixture.means, again.means)
    # A component means the same in both frames.
    np.testing.assert_allclose(mixture.means[:, 0], -mixture.means[:, 1], atol=0.1)
    np.testing.assert_allclose(np.sort(mixture.means[:, 0, 0]), centres, atol=0.1)


@pytest.mark.parametrize("settings", [(0, 10, 1e-5), (11, 10, 1e-5), (5, 10, -1.0)])
def test_unusable_options_are_errors(settings):
    with pytest.raises(InvalidInputError):
        EMOptions(*settings)


def test_time_bins_are_half_open_and_their_moments_are_the_samples():
    data, lengths = curves(lengths=(9, 17))
    floor = covariance_floor(data, (3,), (0.3,), relative=False)
    mixture = initialise_by_time(data, lengths, 4, floor)
    bins = [np.r_[2 * k : 2 * k + 2, 9 + 4 * k : 9 + 4 * k + 4] for k in range(4)]
    np.testing.assert_allclose(mixture.priors, 0.25)
    for k, rows in enumerate(bins):
        for p in range(2):
            np.testing.assert_allclose(mixture.means[k, p], data[p][:, rows].mean(axis=1))
            expected = np.cov(data[p][:, rows]) + 0.3 * np.eye(3)
            np.testing.assert_allclose(mixture.covariances[k, p], expected, atol=1e-12)


def test_two_samples_are_enough_for_a_component_and_one_is_not():
    data, _ = curves(lengths=(7,))
    assert initialise_by_time(data, (7,), 3, zero_floor(data)).n_components == 3
    with pytest.raises(InvalidInputError, match="7 samples are too few"):
        initialise_by_time(data, (7,), 4, zero_floor(data))


def test_two_samples_a_component_are_enough_whatever_the_bins_round_to():
    """And a demonstration's last sample, which a half-open bin leaves out, counts if needed."""
    for k in range(1, 21):
        for length in range(2 * k, 2 * k + 40):
            data, lengths = curves(1, 1, (length,))
            mixture = initialise_by_time(data, lengths, k, 1e-3 + zero_floor(data))
            assert mixture.n_components == k


def test_samples_are_counted_out_only_where_the_bins_are_too_small():
    data, lengths = curves(lengths=(8,))
    mixture = initialise_by_time(data, lengths, 4, 1e-3 * np.tile(np.eye(3), (2, 1, 1)))
    np.testing.assert_allclose(mixture.means[3], data[:, :, 6:].mean(axis=2))
    np.testing.assert_allclose(mixture.priors, 0.25)


def test_k_means_does_not_depend_on_the_unit_of_a_coordinate():
    data, _ = curves()
    units = np.array([1.0, 1e3, 1e-3])[:, None]
    plain = initialise_by_k_means(data, 4, zero_floor(data), np.random.default_rng(2))
    scaled = initialise_by_k_means(units * data + 5, 4, zero_floor(data), np.random.default_rng(2))
    np.testing.assert_allclose(scaled.priors, plain.priors)
    np.testing.assert_allclose(scaled.means, plain.means * units[:, 0] + 5, rtol=1e-9)


def test_k_means_ends_where_every_sample_is_nearest_to_its_own_mean():
    data, _ = curves()
    mixture = initialise_by_k_means(data, 5, zero_floor(data), np.random.default_rng(1))
    joint = data.reshape(6, -1)
    scale = joint.std(axis=1)[:, None]
    means = mixture.means.reshape(5, 6).T
    distances = (((joint[:, None] - means[:, :, None]) / scale[:, None]) ** 2).sum(axis=0)
    labels = distances.argmin(axis=0)
    np.testing.assert_allclose(np.bincount(labels) / labels.size, mixture.priors)
    for k in range(5):
        np.testing.assert_allclose(joint[:, labels == k].mean(axis=1), means[:, k], atol=1e-12)


def test_k_means_needs_as_many_distinct_samples_as_components():
    data = np.repeat(np.array([[[0.0, 1.0, 2.0]]]), 4, axis=2)
    rng = np.random.default_rng(0)
    assert initialise_by_k_means(data, 3, np.eye(1)[None], rng).priors == pytest.approx(1 / 3)
    with pytest.raises(InvalidInputError, match="fewer than 4 distinct"):
        initialise_by_k_means(data, 4, np.eye(1)[None], rng)


def test_a_component_without_samples_keeps_its_place():
    data, lengths = curves()
    near = initialise_by_time(data, lengths, 2, zero_floor(data))
    near = Mixture(np.full(2, 0.5), near.means, near.covariances)
    far = near.means[:1] + 1e6
    start = Mixture(
        np.full(3, 1 / 3),
        np.concatenate([near.means, far]),
        np.concatenate([near.covariances, near.covariances[:1]]),
    )
    mixture, _ = fit_mixture(data, start, zero_floor(data), EMOptions(1, 3, 0.0))
    alone, _ = fit_mixture(data, near, zero_floor(data), EMOptions(1, 3, 0.0))
    np.testing.assert_array_equal(mixture.means[2], far[0])
    np.testing.assert_array_equal(mixture.covariances[2], near.covariances[0])
    assert mixture.priors[2] == 0.0
    np.testing.assert_allclose(mixture.means[:2], alone.means, rtol=1e-9)


def test_the_authors_settings_are_the_defaults():
    assert EMOptions() == EMOptions(5, 100, 1e-5)
    assert EMOptions(1, 1, 0.0).min_steps == 1


@pytest.mark.parametrize("floor", [(0.1,), (0.1, -0.1), (0.1, np.nan), (np.inf, 0.1)])
def test_a_floor_that_is_none_is_an_error(floor):
    data, _ = curves()
    with pytest.raises(InvalidInputError, match="2 values >= 0"):
        covariance_floor(data, (1, 2), floor, relative=False)


def test_a_mixture_whose_parts_do_not_match_is_an_error():
    data, lengths = curves()
    good = initialise_by_time(data, lengths, 3, zero_floor(data))
    good.check()
    for priors, means, covariances in (
        (good.priors[:2], good.means, good.covariances),
        (good.priors, good.means, good.covariances[:, :1]),
        (good.priors, good.means, good.covariances * np.nan),
        (good.priors * np.inf, good.means, good.covariances),
    ):
        with pytest.raises(InvalidInputError, match="a mixture"):
            Mixture(priors, means, covariances).check()


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("n_components", [1, 3, 6])
def test_with_the_floor_as_a_prior_the_objective_never_falls(seed, n_components):
    data, lengths = curves(seed=seed)
    floor = covariance_floor(data, (1, 2), (0.1, 0.3), relative=True)
    start = initialise_by_time(data, lengths, n_components, floor)
    options = EMOptions(5, 300, 1e-9, "prior")
    _, record = fit_mixture(data, start, floor, options)
    assert np.diff(record.objectives).min(initial=0.0) >= -1e-10
    assert not record.fell
    assert record.converged is (record.n_steps < 300)


def test_the_objective_is_the_likelihood_less_the_traces():
    """log L - N / 2 K sum_kp tr(S_kp^-1 F_p), a sample; and it is at a maximum in the end."""
    data, lengths = curves()
    floor = covariance_floor(data, (1, 2), (0.2, 0.1), relative=True)
    start = initialise_by_time(data, lengths, 4, floor)

    def objective(mixture):
        traces = np.trace(np.linalg.solve(mixture.covariances, floor[None]), axis1=2, axis2=3)
        likelihood = responsibilities(data, mixture)[1] / data.shape[2]
        return likelihood - traces.sum() / (2 * mixture.n_components)

    options = EMOptions(5, 5000, 1e-13, "prior")
    mixture, record = fit_mixture(data, start, floor, options)
    assert record.objectives[0] == pytest.approx(objective(start), abs=1e-12)
    best = objective(mixture)
    assert record.objectives[-1] == pytest.approx(best, abs=1e-9)
    rng = np.random.default_rng(0)
    for _ in range(20):
        turn = np.eye(3) + 1e-3 * rng.standard_normal((4, 2, 3, 3))
        covariances = turn @ mixture.covariances @ turn.swapaxes(-1, -2)
        means = mixture.means + 1e-3 * rng.standard_normal(mixture.means.shape)
        assert objective(Mixture(mixture.priors, means, covariances)) < best + 1e-9


def test_one_component_has_the_same_floor_either_way():
    """Its share of the samples is fair."""
    data, lengths = curves()
    floor = covariance_floor(data, (3,), (0.2,), relative=True)
    start = initialise_by_time(data, lengths, 1, floor)
    added, _ = fit_mixture(data, start, floor, EMOptions())
    prior, _ = fit_mixture(data, start, floor, EMOptions(flooring="prior"))
    np.testing.assert_allclose(prior.covariances, added.covariances, rtol=1e-12)


def test_a_prior_does_not_depend_on_how_often_the_same_samples_are_seen():
    data, lengths = curves()
    floor = covariance_floor(data, (3,), (0.2,), relative=True)
    start = initialise_by_time(data, lengths, 4, floor)
    options = EMOptions(20, 20, 0.0, "prior")
    once, _ = fit_mixture(data, start, floor, options)
    often, _ = fit_mixture(np.tile(data, 3), start, floor, options)
    np.testing.assert_allclose(often.covariances, once.covariances, rtol=1e-9)


def test_a_fit_that_ends_because_a_floor_lowers_the_likelihood_does_not_say_that_it_converged():
    fell = []
    for seed in range(20):
        data, lengths = curves(seed=seed)
        floor = covariance_floor(data, (3,), (0.3,), relative=True)
        start = initialise_by_time(data, lengths, 6, 1e-3 * floor)
        _, record = fit_mixture(data, start, floor, EMOptions(1, 100, 1e-6))
        gain = np.diff(record.objectives)[-1]
        assert record.converged is bool(abs(gain) < 1e-6)
        assert record.fell is bool(gain < -1e-8)
        np.testing.assert_array_equal(record.objectives, record.log_likelihoods)
        fell.append(record.fell)
    assert any(fell)


@pytest.mark.parametrize("flooring", ["added", "prior"])
def test_a_sample_of_importance_two_is_two_samples(flooring):
    data, lengths = curves()
    floor = 1e-2 * np.tile(np.eye(3), (2, 1, 1))
    start = initialise_by_time(data, lengths, 4, floor)
    options = EMOptions(10, 10, flooring=flooring)
    importance = np.repeat([2.0, 1.0, 1.0], lengths)
    once, record = fit_mixture(data, start, floor, options, 7.0 * importance)
    twice = np.concatenate([data, data[:, :, : lengths[0]]], axis=2)
    expected, other = fit_mixture(twice, start, floor, options)
    for name in ("priors", "means", "covariances"):
        np.testing.assert_allclose(getattr(once, name), getattr(expected, name), atol=1e-10)
    np.testing.assert_allclose(record.objectives, other.objectives, atol=1e-10)
    assert covariance_floor(data, (1, 2), (0.1, 0.2), True, importance) == pytest.approx(
        covariance_floor(twice, (1, 2), (0.1, 0.2), True)
    )


def test_alike_importances_change_no_bit():
    data, lengths = curves()
    start = initialise_by_time(data, lengths, 4, zero_floor(data))
    plain, _ = fit_mixture(data, start, zero_floor(data), EMOptions())
    alike, _ = fit_mixture(data, start, zero_floor(data), EMOptions(), np.full(data.shape[2], 0.5))
    for name in ("priors", "means", "covariances"):
        np.testing.assert_array_equal(getattr(plain, name), getattr(alike, name))
