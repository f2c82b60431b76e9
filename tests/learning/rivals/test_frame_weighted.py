import numpy as np
import pytest
from learning_tasks import moved_frames, reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, rotation
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.frame_weighted import FrameWeighted, bend


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(3), 60)


def test_with_weight_one_a_path_follows_the_other_frame_and_with_none_the_first(shown):
    path, own, new = shown.points[0], shown.situations[0], shown.situations[1]
    first = bend(path, own, new, np.zeros(60), 0)
    np.testing.assert_allclose(first, new[0].to_world(own[0].to_local(path)), atol=1e-10)
    other = bend(path, own, new, np.ones(60), 0)
    np.testing.assert_allclose(other, new[1].to_world(own[1].to_local(path)), atol=1e-10)


def test_weights_rise_from_the_frame_of_the_start_to_that_of_the_end(shown, rng):
    """So the start is kept in the one and the end in the other."""
    skill = FrameWeighted(samples=60, iterations=10).learn(shown, rng)
    frames = (shown.situations[0][0], Frame(np.eye(3), shown.situations[0][1].b + 0.1))
    path = skill(frames, shown.points[0, 0])
    assert np.linalg.norm(path[0] - shown.points[0, 0]) < 0.02
    assert np.linalg.norm(path[-1] - frames[1].b) < 0.03


def test_its_own_situation_gives_the_reference_wherever_it_is(shown, rng):
    skill = FrameWeighted(samples=60, iterations=2, reference="nearest").learn(shown, rng)
    turn, shift = rotation([0.3, 0.2, -1.0]), np.array([1.0, 2.0, 3.0])
    there = skill(moved_frames(shown.situations[2], turn, shift), np.zeros(3))
    np.testing.assert_allclose(there, shown.points[2] @ turn.T + shift, atol=1e-9)


def test_one_frame_is_refused(rng, shown):
    alone = tuple(frames[:1] for frames in shown.situations)
    with pytest.raises(InvalidInputError, match="two frames"):
        FrameWeighted(samples=60).learn(Shown(shown.points, alone, 1.0), rng)
