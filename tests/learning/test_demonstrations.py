import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, Frame, SyntheticDemonstration
from dressing_sim.learning.demonstrations import check_demonstrations, resample

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
