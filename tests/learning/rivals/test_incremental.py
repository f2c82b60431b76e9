import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning.em import responsibilities
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.fusion import time_mixture
from dressing_sim.learning.rivals.incremental import Incremental, beside, reduced, updated
from dressing_sim.learning.tpgmm import TPGMM

UPDATES = ("generative", "addition", "direct")


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


@pytest.fixture(scope="module")
def mixture(shown):
    return time_mixture(shown, 4, 1e-3)


def moments(mixture):
    mean = np.einsum("k,kpd->pd", mixture.priors, mixture.means)
    gap = mixture.means - mean
    inner = np.einsum("k,kpde->pde", mixture.priors, mixture.covariances)
    return mean, inner + np.einsum("k,kpd,kpe->pde", mixture.priors, gap, gap)


def test_joining_components_keeps_the_mixtures_mean_and_covariance(mixture):
    for count in (3, 1):
        for found, expected in zip(moments(reduced(mixture, count)), moments(mixture), strict=True):
            np.testing.assert_allclose(found, expected, atol=1e-10)


def test_a_mixture_beside_itself_is_reduced_to_itself(mixture):
    both = reduced(beside(mixture, mixture, 2), 4)
    order, other = (np.argsort(one.means[:, 0, 0]) for one in (both, mixture))
    np.testing.assert_allclose(both.means[order], mixture.means[other], atol=1e-10)
    np.testing.assert_allclose(both.covariances[order], mixture.covariances[other], atol=1e-10)
    np.testing.assert_allclose(both.priors[order], mixture.priors[other], atol=1e-12)


def test_a_direct_update_from_no_demonstration_is_a_step_of_expectation_maximisation(
    shown, mixture
):
    data, _ = TPGMM(4, encoding="time").samples(shown.demonstrations())
    shares, _ = responsibilities(data, mixture)
    found = updated(mixture, 0, data, shares, np.zeros((2, 4, 4)))
    mass = shares.sum(axis=1)
    np.testing.assert_allclose(found.priors, mass / mass.sum())
    np.testing.assert_allclose(
        found.means, np.einsum("kn,pdn->kpd", shares, data) / mass[:, None, None]
    )


def test_a_direct_update_of_many_demonstrations_hardly_moves(shown, mixture):
    data, _ = TPGMM(4, encoding="time").samples(shown.only([0]).demonstrations())
    shares, _ = responsibilities(data, mixture)
    found = updated(mixture, 10**9, data, shares, np.zeros((2, 4, 4)))
    np.testing.assert_allclose(found.means, mixture.means, atol=1e-6)
    np.testing.assert_allclose(found.covariances, mixture.covariances, atol=1e-6)


@pytest.mark.parametrize("update", UPDATES)
def test_what_was_learned_first_is_not_forgotten(update, shown, rng):
    skill = Incremental(samples=60, update=update).learn(shown, rng)
    for path, frames in zip(shown.points, shown.situations, strict=True):
        assert np.linalg.norm(skill(frames, path[0]) - path, axis=1).mean() < 0.1


@pytest.mark.parametrize("update", UPDATES)
def test_one_demonstration_is_learned_as_by_the_batch_method(update, shown, rng):
    alone, frames = shown.only([0]), shown.situations[1]
    one, other = (
        Incremental(samples=60, update=name).learn(alone, rng)(frames, np.zeros(3))
        for name in (update, "generative")
    )
    np.testing.assert_array_equal(one, other)
