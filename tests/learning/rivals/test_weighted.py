import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning import Frame
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.fusion import over_time, time_mixture
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


def test_inferred_weights_are_shares_of_powers_of_the_variance():
    sizes = np.array([[1.0] * 20, [2.0] * 20])
    np.testing.assert_allclose(relevance(sizes, 0.0), 1.0)
    np.testing.assert_allclose(relevance(sizes, -1.0)[:, 3], [4.0 / 3.0, 2.0 / 3.0])
    np.testing.assert_allclose(relevance(sizes, -125.0)[:, 3], [2.0, 0.0], atol=1e-12)
    # A change of weight is smooth.
    step = relevance(np.stack([np.r_[np.ones(50), np.full(50, 9.0)], np.ones(100)]), -10.0)
    assert np.abs(np.diff(step, axis=1)).max() < 0.3


def test_inferred_weights_reproduce_demonstrations_no_worse_than_equal_ones(shown):
    method = InferredWeights(samples=60)
    bands = over_time(time_mixture(shown, 6, 1e-3), shown.phase)

    def cost(weights):
        made = [bands.in_world(frames).fused(weights).means for frames in shown.situations]
        return np.mean(np.sqrt(np.mean(np.sum((made - shown.points) ** 2, axis=2), axis=1)))

    assert cost(method.weights(shown, bands)) <= cost(None) + 1e-12


def test_inferred_weights_leave_the_decision_to_the_frame_that_agrees(shown, rng):
    """Published: the frame of low variance is followed, far beyond the demonstrations too."""
    told = of_last_frame(shown)
    skill = InferredWeights(samples=60).learn(told.only([0, 1, 2]), rng)
    plain = LearnedWeights(samples=60, updates=0).learn(told.only([0, 1, 2]), rng)
    first, last = told.situations[3]
    frames = Frame(first.A, first.b - 3.0), last
    error, before = (
        np.abs(one(frames, np.zeros(3)) - told.points[3]).max() for one in (skill, plain)
    )
    assert error < 0.2 * before
    assert error < 5e-3
