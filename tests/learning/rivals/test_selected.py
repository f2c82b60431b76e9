import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning import Frame
from dressing_sim.learning.rivals import METHODS, Shown
from dressing_sim.learning.rivals.selected import ChosenComponents
from dressing_sim.learning.rivals.weighted import LearnedWeights

CRITERIA = ("bic", "dirichlet-process")


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(3), 60)


def zigzag(corners):
    """Noisy demonstrations over straight lines, one after the other."""
    rng = np.random.default_rng(0)
    places = np.array([[i, i % 2, 0.0] for i in range(corners + 1)], dtype=float)
    rows = np.linspace(0, corners, 120)
    path = np.stack([np.interp(rows, np.arange(corners + 1), column) for column in places.T], 1)
    points = path + 0.02 * rng.standard_normal((3, 120, 3))
    return Shown(points, ((Frame(np.eye(3), np.zeros(3)),),) * 3, 1.0)


@pytest.mark.parametrize("criterion", CRITERIA)
def test_a_richer_motion_has_more_components(criterion):
    method = ChosenComponents(samples=120, criterion=criterion, floor=1e-4)
    few, many = (method.components(zigzag(corners)) for corners in (2, 6))
    assert 2 <= few < many


def test_the_criterion_has_its_own_choice_for_lines_in_time():
    """A straight line at an even speed is one Gaussian over time and place."""
    assert ChosenComponents(samples=120, floor=1e-4).components(zigzag(1)) == 1
    assert ChosenComponents(samples=120, floor=1e-4).components(zigzag(4)) == 4


@pytest.mark.parametrize("criterion", CRITERIA)
def test_it_is_the_plain_one_with_the_chosen_number(shown, rng, criterion):
    method = ChosenComponents(samples=60, criterion=criterion, most=6)
    chosen = method.components(shown)
    assert 1 <= chosen <= 6
    plain = LearnedWeights(samples=60, updates=0, components=chosen)
    frames, start = shown.situations[1], np.zeros(3)
    made, expected = (one.learn(shown, rng)(frames, start) for one in (method, plain))
    np.testing.assert_allclose(made, expected, atol=1e-12)


def test_there_is_a_row_of_it():
    assert METHODS["tp-gmr-bic"] == ChosenComponents()
