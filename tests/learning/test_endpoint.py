import numpy as np
from learning_tasks import moved_frames, reaching_demonstrations, reaching_situation

from dressing_sim.learning import Endpoint, Frame, rotation


def test_the_frame_in_which_the_points_agree_decides():
    demonstrations = reaching_demonstrations(4, wobble=0.0)
    frames = reaching_situation(np.random.default_rng(9))
    start = Endpoint.of(demonstrations, 0).predict(frames)
    end = Endpoint.of(demonstrations, -1).predict(frames)
    assert np.linalg.norm(start - frames[0].b) < 0.05
    assert np.linalg.norm(end - frames[1].b) < 0.05


def test_the_point_moves_with_the_world():
    endpoint = Endpoint.of(reaching_demonstrations(3), -1)
    frames = reaching_situation(np.random.default_rng(9))
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    moved = endpoint.predict(moved_frames(frames, turn, shift))
    np.testing.assert_allclose(moved, turn @ endpoint.predict(frames) + shift, atol=1e-10)


def test_one_demonstration_is_enough_and_its_own_situation_gives_its_point():
    demonstration = reaching_demonstrations(1)[0]
    endpoint = Endpoint.of([demonstration], 0)
    np.testing.assert_allclose(
        endpoint.predict(demonstration.frames), demonstration.positions[0], atol=1e-10
    )
    assert isinstance(demonstration.frames[0], Frame)
