import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.movement_primitives import (
    DynamicPrimitive,
    ProbabilisticPrimitive,
)

pytest.importorskip("movement_primitives")
pytest.importorskip("pytransform3d")


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 100)


def test_a_dynamic_primitive_reproduces_and_converges_to_the_goal_wherever_it_is(shown, rng):
    alone = shown.only([0])
    skill = DynamicPrimitive(weights=40).learn(alone, rng)
    frames, path = alone.situations[0], alone.points[0]
    np.testing.assert_allclose(skill(frames, path[0]), path, atol=5e-3)
    end = alone.place(-1).predict(frames)
    for start in ([0.4, 0.1, -0.2], [-0.3, 0.0, 0.2]):
        assert np.linalg.norm(skill(frames, np.array(start))[-1] - end) < 0.02


def test_its_answer_moves_with_start_and_goal(shown, rng):
    """With forces over phase alone, a path is linear in the start and the goal."""
    skill = DynamicPrimitive().learn(shown, rng)
    frames = shown.situations[0]
    begins = [np.zeros(3), np.array([0.2, 0.0, 0.0]), np.array([0.4, 0.0, 0.0])]
    one, two, three = (skill(frames, begin) for begin in begins)
    np.testing.assert_allclose(two, 0.5 * (one + three), atol=1e-9)


def test_the_forces_of_all_demonstrations_are_their_mean_and_differ_from_each_ones(shown, rng):
    """At the same start and goal a path is linear in the forces."""
    frames, start = shown.situations[0], shown.points[0, 0]

    def away(chosen):
        """The path less its goal."""
        some = shown.only(chosen)
        path = DynamicPrimitive().learn(some, rng)(frames, some.place(-1).predict(frames) + start)
        return path - some.place(-1).predict(frames)

    one, other, both = away([0]), away([1]), away([0, 1])
    np.testing.assert_allclose(both, 0.5 * (one + other), atol=1e-9)
    assert np.abs(one - other).max() > 0.01


def test_too_many_weights_are_refused(shown, rng):
    with pytest.raises(InvalidInputError, match="weights"):
        DynamicPrimitive(weights=200).learn(shown, rng)


def test_a_probabilistic_primitive_passes_its_via_points(shown, rng):
    skill = ProbabilisticPrimitive(via_points=3).learn(shown, rng)
    start, frames = np.array([0.05, 0.02, 0.01]), shown.situations[2]
    path = skill(frames, start)
    np.testing.assert_allclose(path[0], start, atol=2e-3)
    np.testing.assert_allclose(path[-1], shown.place(-1).predict(frames), atol=2e-3)
    # The middle of 100 rows is row 50.
    np.testing.assert_allclose(path[50], shown.place(50).predict(frames), atol=2e-3)


def test_without_via_points_between_and_prior_it_is_near_the_demonstrations_mean(shown, rng):
    skill = ProbabilisticPrimitive(via_points=2, prior=1e-12).learn(shown.only([0]), rng)
    path = skill(shown.situations[0], shown.points[0, 0])
    np.testing.assert_allclose(path, shown.points[0], atol=5e-3)
