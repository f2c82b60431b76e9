import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.via_points import ViaPointPrimitive

PHASE = np.linspace(0.0, 1.0, 60)
ROWS = np.array([0, 30, 59])


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


@pytest.mark.parametrize("away", [0.0, 0.01, 0.5])
def test_via_points_are_passed_whether_known_or_far(away, rng):
    method = ViaPointPrimitive(samples=60)
    via = np.array([[0.0, 0.0, 0.0], [0.3, 0.2 + away, 0.1], [0.5, 0.0, 0.2]])
    shape = 0.1 * rng.standard_normal((20, 3))
    path = method.through(PHASE, ROWS, via, shape, 1e-2 * np.eye(20))
    np.testing.assert_allclose(path[ROWS], via, atol=1e-9)


def test_a_via_point_on_the_path_changes_nothing(rng):
    method = ViaPointPrimitive(samples=60)
    shape = 0.1 * rng.standard_normal((20, 3))
    ends = np.array([[0.0, 0.0, 0.0], [0.5, 0.0, 0.2]])
    free = method.through(PHASE, ROWS[[0, 2]], ends, shape, np.eye(20))
    via = np.stack([ends[0], free[30], ends[1]])
    np.testing.assert_allclose(method.through(PHASE, ROWS, via, shape, np.eye(20)), free, atol=1e-9)


def test_beyond_the_demonstrations_their_shape_is_kept(rng):
    """Far via-points bend the straight lines alone: second differences stay, but at the knot."""
    method = ViaPointPrimitive(samples=60)
    shape = 0.1 * rng.standard_normal((20, 3))
    via = np.array([[0.0, 0.0, 0.0], [2.0, 2.0, 2.0], [0.5, 0.0, 0.2]])
    far = method.through(PHASE, ROWS, via, shape, 1e-6 * np.eye(20))
    free = method.through(PHASE, ROWS[[0, 2]], via[[0, 2]], shape, 1e-6 * np.eye(20))
    gap = np.abs(np.diff(far - free, 2, axis=0)).max(axis=1)
    assert np.argmax(gap) == 29
    assert np.delete(gap, 29).max() < 1e-12


def test_one_demonstration_is_reproduced(shown, rng):
    alone = shown.only([1])
    path = ViaPointPrimitive(samples=60, via_points=0).learn(alone, rng)(
        alone.situations[0], alone.points[0, 0]
    )
    np.testing.assert_allclose(path, alone.points[0], atol=5e-3)
