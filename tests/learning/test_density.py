import numpy as np
import pytest
from learning_tasks import moved_frames, reaching_demonstrations, reaching_situation
from scipy.special import logsumexp
from scipy.stats import multivariate_normal

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import TPGMM, GaussianMixture, rotation

FRAMES = reaching_situation(np.random.default_rng(8))


def mixture(seed=0, n_components=3, n_dims=3):
    rng = np.random.default_rng(seed)
    factors = rng.standard_normal((n_components, n_dims, n_dims))
    return GaussianMixture(
        rng.dirichlet(np.ones(n_components)),
        3.0 * rng.standard_normal((n_components, n_dims)),
        factors @ factors.transpose(0, 2, 1) + 0.1 * np.eye(n_dims),
    )


def test_the_density_is_the_weighted_sum_of_its_components():
    one = mixture()
    points = 4.0 * np.random.default_rng(1).standard_normal((50, 3))
    logs = [
        np.log(prior) + multivariate_normal(mean, covariance).logpdf(points)
        for prior, mean, covariance in zip(one.priors, one.means, one.covariances, strict=True)
    ]
    np.testing.assert_allclose(one.log_density(points), logsumexp(logs, axis=0), atol=1e-9)
    far = one.log_density(np.full((1, 3), 1e6))
    assert np.isfinite(far).all()


def test_samples_have_the_moments_of_the_mixture():
    one = mixture()
    drawn = one.sample(200_000, np.random.default_rng(2))
    mean = one.priors @ one.means
    centred = one.means - mean
    covariance = np.einsum("k,kij->ij", one.priors, one.covariances)
    covariance += np.einsum("k,ki,kj->ij", one.priors, centred, centred)
    np.testing.assert_allclose(drawn.mean(axis=0), mean, atol=0.05)
    np.testing.assert_allclose(np.cov(drawn.T), covariance, atol=0.02 * covariance.max())
    np.testing.assert_array_equal(drawn[:9], one.sample(200_000, np.random.default_rng(2))[:9])


def test_a_marginal_is_the_density_integrated_over_the_other_coordinates():
    one = mixture(n_dims=2)
    xs = np.linspace(-60, 60, 24_001)
    for x in (-1.0, 2.5):
        plane = np.stack([np.full_like(xs, x), xs], axis=1)
        total = np.trapezoid(np.exp(one.log_density(plane)), xs)
        assert np.exp(one.marginal(1).log_density([[x]]))[0] == pytest.approx(total, rel=1e-6)


def test_deviations_are_those_from_the_nearest_mean_whatever_the_unit():
    one = GaussianMixture(np.ones(1), np.zeros((1, 2)), np.diag([4.0, 9.0])[None])
    np.testing.assert_allclose(one.deviations([[2.0, 0.0], [0.0, 9.0]]), [1.0, 3.0])
    other = GaussianMixture(one.priors, one.means, 1e6 * one.covariances)
    np.testing.assert_allclose(other.deviations([[2e3, 0.0]]), [1.0])


@pytest.mark.parametrize("encoding", ["time", "trajectory"])
def test_a_model_s_density_turns_with_the_world(encoding):
    model = TPGMM(4, encoding=encoding, floor=1e-3).fit(reaching_demonstrations(3))
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    lifted = np.eye(4 if encoding == "time" else 6)
    lifted[-3:, -3:] = turn
    offset = np.zeros(len(lifted))
    if encoding == "time":
        offset[1:] = shift
    else:
        lifted[:3, :3], offset[:3] = turn, shift
    plain = model.in_situation(FRAMES)
    points = plain.sample(20, np.random.default_rng(0))
    other = model.in_situation(moved_frames(FRAMES, turn, shift))
    np.testing.assert_allclose(
        other.log_density(points @ lifted.T + offset), plain.log_density(points), atol=1e-6
    )


def test_unusable_questions_are_errors():
    one = mixture()
    with pytest.raises(InvalidInputError, match="points"):
        one.log_density(np.zeros(3))
    with pytest.raises(InvalidInputError, match="number of coordinates"):
        one.marginal(4)
    with pytest.raises(InvalidInputError, match="rng"):
        one.sample(3, None)
    flat = GaussianMixture(np.ones(1), np.zeros((1, 2)), np.zeros((1, 2, 2)))
    with pytest.raises(InvalidInputError, match="singular"):
        flat.deviations([[0.0, 0.0]])
