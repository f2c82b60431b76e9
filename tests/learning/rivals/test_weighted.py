import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.fusion import Bands, over_time, time_mixture
from dressing_sim.learning.rivals.weighted import InferredWeights, LearnedWeights, relevance


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


def of_last_frame(shown):
    """Demonstrations that the last frame alone decides."""
    local = np.linspace([0.0, 0.0, 0.0], [0.2, 0.1, 0.3], 60)
    points = np.stack([frames[-1].to_world(local) for frames in shown.situations])
    return Shown(points, shown.situations, 1.0)


def test_with_equal_weights_it_is_the_product_over_frames(shown, rng):
    plain = over_time(time_mixture(shown, 6, 1e-3), shown.phase)
    frames = shown.situations[1]
    skill = LearnedWeights(samples=60, updates=0).learn(shown, rng)
    expected = plain.in_world(frames).fused().means
    np.testing.assert_allclose(skill(frames, np.zeros(3)), expected, atol=1e-12)


def test_learned_weights_find_the_frame_that_decides(shown, rng):
    told = of_last_frame(shown)
    method = LearnedWeights(samples=60)
    weights = method.weights(told, rng)
    assert weights.sum() == pytest.approx(2.0)
    assert weights[1] > 3.0 * weights[0]


def test_learned_weights_are_the_same_for_a_seed(shown):
    method = LearnedWeights(samples=60, updates=3)
    one, other = (method.weights(shown, np.random.default_rng(5)) for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_inferred_weights_are_shares_of_the_inverse_determinants():
    covariances = np.stack([np.eye(3), 2.0 * np.eye(3)])[:, None]
    weights = relevance(Bands(np.zeros((2, 1, 3)), covariances))
    np.testing.assert_allclose(weights[:, 0], [2.0 * 8.0 / 9.0, 2.0 / 9.0])


def test_inferred_weights_leave_the_decision_to_the_frame_that_agrees(shown, rng):
    """Published: the frame of low variance is followed, far beyond the demonstrations too."""
    told = of_last_frame(shown)
    skill = InferredWeights(samples=60).learn(told.only([0, 1, 2]), rng)
    plain = LearnedWeights(samples=60, updates=0).learn(told.only([0, 1, 2]), rng)
    frames, truth = told.situations[3], told.points[3]
    error, before = (np.abs(one(frames, truth[0]) - truth).max() for one in (skill, plain))
    assert error < before
    assert error < 5e-3
