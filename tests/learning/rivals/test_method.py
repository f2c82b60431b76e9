import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import SyntheticDemonstration
from dressing_sim.learning.motion import minimum_jerk
from dressing_sim.learning.rivals import METHODS, Shown
from dressing_sim.learning.rivals.method import library, resampled


def test_pauses_at_the_ends_are_cut_off_and_durations_are_made_alike():
    one = reaching_demonstrations(1)[0]
    paused = np.concatenate([np.repeat(one.positions[:1], 80, axis=0), one.positions])
    shown = Shown.of([one, SyntheticDemonstration(paused, one.dt, one.frames)], 50)
    assert shown.points.shape == (2, 50, 3)
    np.testing.assert_allclose(shown.points[0], shown.points[1], atol=2e-2)
    assert shown.duration == pytest.approx(119 * 0.05, rel=0.25)


def test_a_line_is_resampled_exactly():
    line = np.linspace([0.0, 1.0], [2.0, 5.0], 7)
    np.testing.assert_allclose(resampled(line, 13), np.linspace([0.0, 1.0], [2.0, 5.0], 13))


def test_minimum_jerk_rests_at_both_ends():
    np.testing.assert_allclose(
        minimum_jerk(np.array([-1.0, 0.0, 0.5, 1.0, 2.0])), [0, 0, 0.5, 1, 1]
    )
    assert minimum_jerk(np.array([1e-3]))[0] < 1e-7


def test_a_package_that_is_missing_is_named_with_how_to_get_it():
    with pytest.raises(InvalidInputError, match=r"no_such_package is not installed.*\[rivals\]"):
        library("no_such_package.module")


@pytest.mark.parametrize("name", METHODS)
def test_hyper_parameters_that_mean_nothing_are_refused(name):
    method = type(METHODS[name])
    with pytest.raises(InvalidInputError, match="samples"):
        method(samples=5)
    with pytest.raises(InvalidInputError, match="samples"):
        method(samples=0.5)


def test_a_choice_that_there_is_not_is_refused():
    with pytest.raises(InvalidInputError, match="first, last"):
        type(METHODS["gmr-frame"])(frame="middle")
