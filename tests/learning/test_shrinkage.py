import numpy as np
import pytest
from learning_tasks import moved, moved_frames, reaching_demonstrations, reaching_situation

from dressing_sim.learning import TPGMM, TrajectoryTPGMM, load_model, rotation, save_model
from dressing_sim.learning.em import Mixture, responsibilities
from dressing_sim.learning.shrinkage import between_covariances, shrink_between


def test_the_covariance_between_is_that_of_the_demonstrations_means():
    rng = np.random.default_rng(0)
    lengths, centres = [40, 60], rng.standard_normal((2, 3))
    samples = np.repeat(centres, lengths, axis=0) + 0.1 * rng.standard_normal((100, 3))
    data = samples.T[None]
    mixture = Mixture(np.ones(1), samples.mean(axis=0)[None, None], np.cov(samples.T)[None, None])
    means = np.array([samples[:40].mean(axis=0), samples[40:].mean(axis=0)])
    expected = np.cov(means.T, aweights=[40, 60], bias=True)
    np.testing.assert_allclose(between_covariances(mixture, data, lengths)[0, 0], expected)


@pytest.mark.parametrize("count", [1, 2, 5])
def test_shrinking_keeps_covariances_positive_definite_and_blocks_variances(count):
    demonstrations = reaching_demonstrations(count)
    model = TPGMM(4, floor=1e-3, relative_floor=True, shrinkage=True).fit(demonstrations)
    before, after = model.fitted().covariances, model.predictive.covariances
    assert np.linalg.eigvalsh(after).min() > 0
    for block in (slice(3), slice(3, 6)):
        # The amount of spread stays; only its directions are evened out.
        a, b = (np.trace(c[..., block, block], axis1=2, axis2=3) for c in (before, after))
        np.testing.assert_allclose(a, b, rtol=1e-9)
    np.testing.assert_array_equal(model.fitted().means, model.predictive.means)


def test_it_matters_less_with_more_demonstrations():
    def change(count):
        demonstrations = reaching_demonstrations(count)
        model = TPGMM(1).fit(demonstrations)
        data, lengths = model.samples(demonstrations)
        shrunk = shrink_between(model.fitted(), data, lengths, (3, 3))
        return np.abs(shrunk.covariances - model.fitted().covariances).max()

    assert change(40) < 0.25 * change(2)


def test_the_fit_is_the_same_and_the_regression_is_not():
    demonstrations = reaching_demonstrations(2)
    plain, shrunk = (TPGMM(4, shrinkage=s).fit(demonstrations) for s in (False, True))
    np.testing.assert_array_equal(plain.fitted().covariances, shrunk.fitted().covariances)
    assert plain.predictive is plain.fitted()
    data, _ = plain.samples(demonstrations)
    assert responsibilities(data, shrunk.fitted())[1] == plain.log_likelihood(demonstrations)
    frames = reaching_situation(np.random.default_rng(1))
    query = demonstrations[0].positions[::30]
    a, b = plain.regression(frames)(query)[0], shrunk.regression(frames)(query)[0]
    assert np.abs(a - b).max() > 1e-6


def test_the_motion_still_moves_with_the_world_and_is_kept_in_a_file(tmp_path):
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    demonstrations = reaching_demonstrations(2)
    frames = reaching_situation(np.random.default_rng(8))
    policy = TrajectoryTPGMM(shrinkage=True).fit(demonstrations)
    path = policy.generate(frames, frames[0].b)
    other = load_model(save_model(policy, tmp_path / "policy.npz"))
    np.testing.assert_array_equal(other.generate(frames, frames[0].b), path)
    policy.fit([moved(d, turn, shift) for d in demonstrations])
    moved_path = policy.generate(moved_frames(frames, turn, shift), turn @ frames[0].b + shift)
    np.testing.assert_allclose(moved_path, path @ turn.T + shift, atol=1e-6)


@pytest.mark.parametrize("encoding", ["trajectory", "time"])
@pytest.mark.parametrize("count", [1, 2, 4])
def test_the_part_between_demonstrations_is_shrunk_by_dimensions_over_those_and_demonstrations(
    count, encoding
):
    demonstrations = reaching_demonstrations(count)
    model = TPGMM(3, encoding=encoding).fit(demonstrations)
    data, lengths = model.samples(demonstrations)
    sizes = (3, 3) if encoding == "trajectory" else (1, 3)
    between = between_covariances(model.fitted(), data, lengths)
    change = shrink_between(model.fitted(), data, lengths, sizes).covariances
    change = change - model.fitted().covariances
    share = 3 / (3 + count - 1)  # of the output's three dimensions, even where time is an input
    even = np.zeros_like(between)
    for size, block in zip(sizes, (slice(0, sizes[0]), slice(sizes[0], None)), strict=True):
        spread = np.trace(between[..., block, block], axis1=2, axis2=3) / size
        even[..., block, block] = spread[..., None, None] * np.eye(size)
    np.testing.assert_allclose(change, share * (even - between), atol=1e-12)
