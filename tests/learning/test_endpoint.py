import numpy as np
import pytest
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


@pytest.mark.parametrize("count", [1, 2, 5])
def test_the_covariance_is_shrunk_towards_a_ball_of_the_same_trace(count):
    demonstrations = reaching_demonstrations(count)
    endpoint = Endpoint.of(demonstrations, -1)
    for p in range(2):
        paths = [d.frames[p].to_local(d.positions) for d in demonstrations]
        ends = np.array([path[-1] for path in paths])
        np.testing.assert_allclose(endpoint.means[p], ends.mean(axis=0), atol=1e-12)
        sample = np.cov(ends.T) if count > 1 else np.zeros((3, 3))
        share = 3 / (3 + max(count - 1, 1))
        ball = np.trace(sample) / 3 * np.eye(3)
        floor = 1e-3 * np.mean([path.var(axis=0).mean() for path in paths])
        expected = (1 - share) * sample + share * ball + floor * np.eye(3)
        np.testing.assert_allclose(endpoint.covariances[p], expected, atol=1e-12)


def test_the_predicted_point_is_the_likeliest_by_all_frames_together():
    endpoint = Endpoint.of(reaching_demonstrations(3), -1)
    frames = Frame(2.0 * rotation([0.1, 0.7, -0.4]), [0.1, 0.2, 0]), Frame(np.eye(3), [0.4, 0, 0.3])
    point = endpoint.predict(frames)

    def badness(x):
        offsets = np.stack([frame.to_local(x) for frame in frames]) - endpoint.means
        return np.einsum("pi,pij,pj", offsets, np.linalg.inv(endpoint.covariances), offsets)

    for step in 1e-3 * np.concatenate([np.eye(3), -np.eye(3)]):
        assert badness(point + step) > badness(point)


def test_weights_are_shares_of_the_points():
    demonstrations = reaching_demonstrations(3)
    plain, alike = (Endpoint.of(demonstrations, -1, one) for one in (None, [0.2, 0.2, 0.2]))
    np.testing.assert_allclose(alike.means, plain.means)
    np.testing.assert_allclose(alike.covariances, plain.covariances)
    ends = [[f.to_local(d.positions[-1]) for f in d.frames] for d in demonstrations]
    heavy = Endpoint.of(demonstrations, -1, [2.0, 1.0, 1.0])
    np.testing.assert_allclose(heavy.means, np.average(ends, axis=0, weights=[2.0, 1.0, 1.0]))


def test_a_demonstration_that_outweighs_all_others_is_as_one_alone():
    demonstrations = reaching_demonstrations(3)
    heavy = Endpoint.of(demonstrations, -1, [1e9, 1.0, 1.0])
    np.testing.assert_allclose(
        heavy.predict(demonstrations[0].frames), demonstrations[0].positions[-1], atol=1e-6
    )
    assert Endpoint.of(demonstrations[:1], -1, [3.0]).covariances == pytest.approx(
        Endpoint.of(demonstrations[:1], -1).covariances
    )
