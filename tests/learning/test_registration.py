import numpy as np
import pytest
from learning_tasks import moved_frames, reaching_demonstrations, reaching_situation

from dressing_sim.learning import Frame, rotation
from dressing_sim.learning.registration import (
    by_length,
    by_phase,
    landmarks_of,
    moving,
    moving_part,
)

LINE = np.linspace([0.0, 0.0], [10.0, 0.0], 101)


def test_the_moving_part_begins_and_ends_where_it_crosses_the_distance():
    """Between samples: 0.25 from both ends of a line of 10, at 1 a second."""
    positions, times = moving_part(LINE, 0.1, 0.025)
    np.testing.assert_allclose(positions[[0, -1], 0], [0.25, 9.75], atol=1e-12)
    np.testing.assert_allclose(times[[0, -1]], [0.25, 9.75], atol=1e-12)
    np.testing.assert_allclose(positions[:, 0], times, atol=1e-12)
    assert (np.diff(times) > 0.0).all()


@pytest.mark.parametrize("finer", [2, 7, 50])
@pytest.mark.parametrize("path", [reaching_demonstrations(1)[0].positions, LINE], ids=["", "line"])
def test_the_moving_part_does_not_depend_on_the_sampling_rate(path, finer):
    rows = np.arange((len(path) - 1) * finer + 1) / finer
    fine = np.stack([np.interp(rows, np.arange(len(path)), c) for c in path.T], 1)
    (plain, plain_times), (other, times) = (
        moving_part(path, 0.1, 2e-3),
        moving_part(fine, 0.1 / finer, 2e-3),
    )
    np.testing.assert_allclose(other[[0, -1]], plain[[0, -1]], atol=1e-9)
    np.testing.assert_allclose(times[[0, -1]], plain_times[[0, -1]], atol=1e-7)


def test_standing_still_is_left_out_and_nothing_else_is():
    still = np.concatenate([np.repeat(LINE[:1], 30, 0), LINE, np.repeat(LINE[-1:], 50, 0)])
    positions, times = moving_part(still, 0.1, 2e-3)
    expected, _ = moving_part(LINE, 0.1, 2e-3)
    np.testing.assert_allclose(positions, expected, atol=1e-12)
    assert times[0] == pytest.approx(3.0 + 0.02)
    whole, _ = moving_part(still, 0.1, 0.0)
    assert whole is still
    assert moving(still, 2e-3) == slice(30, 131)


def test_a_path_may_be_cut_by_length_with_times_of_its_own():
    uneven = np.cumsum(np.random.default_rng(0).uniform(0.05, 0.2, 101))
    phased = by_length(LINE, uneven, [], 11)
    np.testing.assert_allclose(phased.points[:, 0], np.arange(11.0), atol=1e-6)
    np.testing.assert_allclose(phased.times, uneven[::10], atol=1e-6)
    even = by_length(LINE, 0.1, [], 11)
    np.testing.assert_array_equal(even.times, by_length(LINE, np.arange(101) * 0.1, [], 11).times)


def test_a_phase_begins_with_the_motion():
    (demonstration,) = reaching_demonstrations(1)
    phased = by_phase(demonstration, 2e-3, 40)
    assert phased.points.shape == (40, 3)
    assert phased.times[0] == 0.0
    assert phased.times[-1] < 119 * 0.05


def test_landmarks_move_with_their_frames_and_know_no_scale_of_them():
    frames = reaching_situation(np.random.default_rng(0))
    points = landmarks_of(frames, 2.0)
    assert points.shape == (8, 3)
    np.testing.assert_allclose(points[[0, 4]], [frame.b for frame in frames])
    np.testing.assert_allclose(np.linalg.norm(points[1:4] - points[0], axis=1), 0.5)
    scaled = [Frame(0.3 * frame.A, frame.b) for frame in frames]
    np.testing.assert_allclose(landmarks_of(scaled, 2.0), points)
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    expected = points @ turn.T + shift
    np.testing.assert_allclose(landmarks_of(moved_frames(frames, turn, shift), 2.0), expected)
