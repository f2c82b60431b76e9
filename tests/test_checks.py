"""Arrays and numbers from Python: nothing is cast that was not meant."""

from fractions import Fraction

import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.checks import LONGEST_NAME, clean_name, real_array, real_number, whole_number
from dressing_sim.control.tracking import checked_rotation
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, SyntheticDemonstration, dtw_distance, rms_cost
from dressing_sim.learning.demonstrations import check_demonstrations
from dressing_sim.path import Path, checked_path

LINE = np.linspace([0.3, 0.0, 0.5], [0.5, -0.2, 0.4], 10)
MASKED = np.ma.masked_array(LINE, mask=LINE > 0.49)
POSTURE = Posture("arm", 70, 20, 30, 40)
FRAMES = (Frame(np.eye(3), np.zeros(3)),)


class Plain:
    """A demonstration of somebody else's."""

    dt, frames = 0.1, FRAMES

    def __init__(self, positions):
        self.positions = positions


#: Whatever takes a path of three dimensions.
TAKERS = {
    "Path": Path,
    "a policy's path": lambda path: checked_path(path, "policy p"),
    "Demonstration": lambda path: Demonstration(path, 0.1, POSTURE, 0, np.zeros((10, 7))),
    "commands": lambda path: Demonstration(
        LINE, 0.1, POSTURE, 0, np.ma.concatenate([path, path, path[:, :1]], axis=1)
    ),
    "SyntheticDemonstration": lambda path: check_demonstrations(
        [SyntheticDemonstration(path, 0.1, FRAMES)]
    ),
    "check_demonstrations": lambda path: check_demonstrations([Plain(path)]),
    "Frame": lambda path: FRAMES[0].to_local(path),
    "dtw": lambda path: dtw_distance(path, LINE),
    "costs": lambda path: rms_cost([path], [LINE]),
}


@pytest.mark.parametrize("taker", TAKERS)
@pytest.mark.parametrize(
    ("path", "part"),
    [
        (MASKED, "masked"),
        (LINE + 1e-3j, "complex"),
        (LINE.astype(str), "of shape (10, "),
        (LINE > 0.4, "of shape (10, "),
        (np.where(LINE > 0.49, np.nan, LINE), "not finite"),
        (LINE * 1e200, "e+"),
    ],
)
def test_what_is_no_array_of_real_numbers_is_refused_and_named(taker, path, part):
    TAKERS[taker](LINE)
    with pytest.raises(InvalidInputError) as caught:
        TAKERS[taker](path)
    assert part in str(caught.value)
    assert "valid" in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("make", [Path, TAKERS["a policy's path"]])
def test_a_path_that_is_transposed_or_empty_is_named(make):
    with pytest.raises(InvalidInputError, match=r"shape \(3, 10\) \(is it transposed\?\)"):
        make(LINE.T)
    with pytest.raises(InvalidInputError, match=r"shape \(0, 3\), valid is \(T, 3\) with T of 2"):
        make(LINE[:0])


@pytest.mark.parametrize("taker", ["Path", "a policy's path", "Demonstration"])
def test_millimetres_are_known_by_the_robot_s_reach(taker):
    with pytest.raises(InvalidInputError, match=r"reach is 0\.855 m; .*millimetres"):
        TAKERS[taker](LINE * 1000.0)


def test_a_path_that_leaves_the_robot_s_reach_is_one():
    assert len(Path(np.linspace([0, 0, 0.5], [50, 0, 0], 9))) == 9


@pytest.mark.parametrize("dt", [None, "0.1", np.array([0.1]), np.array(0.1), True, 1j, -1, np.nan])
def test_a_time_step_that_is_none_is_refused(dt):
    with pytest.raises(InvalidInputError, match="dt"):
        Demonstration(LINE, dt, POSTURE, 0, np.zeros((10, 7)))
    with pytest.raises(InvalidInputError, match="demonstration 0 needs dt > 0"):
        check_demonstrations([SyntheticDemonstration(LINE, dt, FRAMES)])


@pytest.mark.parametrize("values", [[1, 2], [np.int8(1), 2.5], [Fraction(1, 2), 10**30 // 10**20]])
def test_numbers_of_any_kind_are_real(values):
    np.testing.assert_array_equal(real_array(values, ("n",), "it has"), np.array(values, float))


def test_an_array_is_not_copied_and_a_mask_that_hides_nothing_is_no_mask():
    assert real_array(LINE, ("T", 3), "it has") is LINE
    assert real_array(np.ma.masked_array(LINE), None, "it has").shape == LINE.shape


@pytest.mark.parametrize("value", ["1", True, None, 1j, np.nan, np.inf, 10**400, [1.0], -1.0, 7.0])
def test_a_number_is_finite_and_within_its_bounds(value):
    with pytest.raises(InvalidInputError, match=r"it is .*valid is a number from 0 to 5"):
        real_number(value, "it", 0.0, 5.0)


@pytest.mark.parametrize("value", ["1", True, None, 1.0, np.nan, -1, 6])
def test_a_whole_number_is_one_within_its_bounds(value):
    with pytest.raises(InvalidInputError, match=r"it is .*valid is a whole number, 0 to 5"):
        whole_number(value, "it", 0, 5)


@pytest.mark.parametrize("name", ["", "  ", "a\nb", "a\x1b[2Jb", "x" * (LONGEST_NAME + 1), 3, None])
def test_a_name_can_be_printed(name):
    with pytest.raises(InvalidInputError, match=r"the name is .*printable") as caught:
        clean_name(name, "the name")
    assert str(caught.value).isprintable()
    assert clean_name("Büste 7, links", "the name")


def test_a_rotation_is_no_complex_matrix():
    with pytest.raises(InvalidInputError, match="complex"):
        checked_rotation(np.eye(3) * (1 + 0j))
