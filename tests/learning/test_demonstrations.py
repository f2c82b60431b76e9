import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, Frame, SyntheticDemonstration
from dressing_sim.learning.demonstrations import check_demonstrations, duration, resample

FRAMES = (Frame(np.eye(2), np.zeros(2)),)
LINE = np.linspace([0, 0], [1, 2], 11)


class Plain:
    """A demonstration that knows nothing of the library."""

    positions = LINE
    dt = 0.1
    frames = FRAMES


def test_anything_with_positions_dt_and_frames_is_a_demonstration():
    assert isinstance(Plain(), DemonstrationLike)
    assert check_demonstrations([Plain(), SyntheticDemonstration(LINE, 0.1, FRAMES)])


@pytest.mark.parametrize(
    ("positions", "dt", "frames", "message"),
    [
        (LINE[:2], 0.1, FRAMES, "2 samples"),
        (np.ones((10, 2)), 0.1, FRAMES, "stands still"),
        (np.full((10, 2), np.nan), 0.1, FRAMES, "not finite"),
        (LINE, 0.0, FRAMES, "dt > 0"),
        (LINE, 0.1, (), "0 frames"),
        (LINE, 0.1, FRAMES * 2, "2 frames"),
        (LINE[:, :1], 0.1, FRAMES, "shape"),
    ],
)
def test_a_degenerate_demonstration_is_named_with_its_fault(positions, dt, frames, message):
    good = SyntheticDemonstration(LINE, 0.1, FRAMES)
    bad = SyntheticDemonstration(positions, dt, frames)
    with pytest.raises(InvalidInputError, match=f"demonstration 1 .*{message}"):
        check_demonstrations([good, bad])


def test_no_demonstration_is_an_error():
    with pytest.raises(InvalidInputError, match="at least one"):
        check_demonstrations([])


def test_resampling_keeps_the_ends_and_the_line():
    finer = resample(LINE, 0.1, 0.03)
    np.testing.assert_array_equal(finer[0], LINE[0])
    np.testing.assert_array_equal(finer[-1], LINE[-1])
    np.testing.assert_allclose(finer[:, 1], 2 * finer[:, 0])
    np.testing.assert_array_equal(resample(LINE, 0.1, 0.1), LINE)


def test_the_positions_of_a_synthetic_demonstration_cannot_change():
    demonstration = reaching_demonstrations(1)[0]
    with pytest.raises(ValueError, match="read-only"):
        demonstration.positions[0] = 0.0


@pytest.mark.parametrize(
    ("step", "count"), [(0.1 / 3, 31), (0.25, 5), (0.5, 3), (0.3, 5), (2.0, 2)]
)
def test_a_path_is_resampled_to_as_many_samples_as_its_duration_needs(step, count):
    positions = LINE**2
    resampled = resample(positions, 0.1, step)
    times = np.minimum(step * np.arange(count), 1.0)
    expected = [np.interp(times, 0.1 * np.arange(11), column) for column in positions.T]
    np.testing.assert_allclose(resampled, np.transpose(expected), atol=1e-12)


def test_three_samples_that_move_along_one_axis_are_enough():
    path = np.array([[0.0, 0.0], [0.0, 1e-6], [0.0, 0.0]])
    (kept,) = check_demonstrations([SyntheticDemonstration(path, 0.1, FRAMES)])
    assert duration(kept) == pytest.approx(0.2)


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_rounding_far_from_the_origin_is_no_motion(far):
    path = far + 1e-10 * (1.0 + far) * np.stack([np.arange(8.0), np.zeros(8)], axis=1)
    with pytest.raises(InvalidInputError, match="stands still"):
        check_demonstrations([SyntheticDemonstration(path, 0.1, FRAMES)])


@pytest.mark.parametrize(
    ("positions", "dt", "frames", "message"),
    [
        (LINE[:, 0], 0.1, FRAMES, "shape"),
        (LINE, np.nan, FRAMES, "dt > 0"),
        (LINE, np.inf, FRAMES, "dt > 0"),
        (LINE, -1.0, FRAMES, "dt > 0"),
        (LINE, 0.1, (Frame(np.eye(3), np.zeros(3)),), "frames of dimension 2"),
    ],
)
def test_what_has_no_time_or_no_plane_is_named_too(positions, dt, frames, message):
    bad = SyntheticDemonstration(positions, dt, frames)
    with pytest.raises(InvalidInputError, match=message):
        check_demonstrations([SyntheticDemonstration(LINE, 0.1, FRAMES), bad])


def test_a_demonstration_without_frames_is_an_error():
    with pytest.raises(InvalidInputError, match="0 frames where 1 are needed"):
        check_demonstrations([SyntheticDemonstration(LINE, 0.1, ())])
