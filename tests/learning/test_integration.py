"""The path x_{t+1} = x_t + E[dx | x_t] of a single Gaussian, which is a linear recurrence."""

import numpy as np
import pytest

from dressing_sim.learning.gmr import Regression
from dressing_sim.learning.kernels.regression import integrate

NOWHERE = np.array([1e9, 1e9])


def field(gain, step=(0.0, 0.0)):
    """E[dx | x] = gain x + step, as a mixture of one component in one frame."""
    matrix = np.broadcast_to(np.asarray(gain, dtype=float), (2, 2)) * np.eye(2)
    return Regression(
        log_weights=np.zeros((1, 1)),
        input_means=np.zeros((1, 1, 2)),
        precisions=np.eye(2)[None, None],
        output_means=np.array(step, dtype=float)[None, None],
        gains=np.ascontiguousarray(matrix)[None, None],
        residuals=np.eye(2)[None, None],
        ridge=np.zeros((1, 2, 2)),
        shared=False,
    )


def path(field, start, steps=20, min_steps=0, longest=1e9, rest=0.0, count=1, end=None, radius=0.0):
    end = NOWHERE if end is None else np.array(end, dtype=float)
    start = np.array(start, dtype=float)
    return integrate(start, field, steps, min_steps, longest, rest, count, end, radius)


def test_a_linear_field_gives_a_geometric_path_to_the_last_step():
    found = path(field(-0.25), [8.0, -4.0], steps=12)
    powers = 0.75 ** np.arange(13)[:, None]
    np.testing.assert_allclose(found, powers * [8.0, -4.0], rtol=1e-12)


def test_a_step_that_is_too_long_keeps_its_direction():
    found = path(field(0.0, [3.0, 4.0]), [1.0, 1.0], steps=4, longest=2.5)
    np.testing.assert_allclose(np.diff(found, axis=0), np.tile([1.5, 2.0], (4, 1)))
    just = path(field(0.0, [3.0, 4.0]), [1.0, 1.0], steps=4, longest=5.1)
    np.testing.assert_allclose(np.diff(just, axis=0), np.tile([3.0, 4.0], (4, 1)))


@pytest.mark.parametrize(("count", "least"), [(1, 0), (3, 0), (3, 9), (1, 9)])
def test_it_rests_after_so_many_short_steps_in_a_row(count, least):
    # Steps 4, 2, 1, 0.5, ...: the fourth is the first below 0.9.
    found = path(field(-0.5), [8.0, 0.0], rest=0.9, count=count, min_steps=least)
    assert len(found) - 1 == max(3 + count, least)


def test_a_pause_that_is_too_short_is_no_rest():
    # Steps 0.05, 0.075, ...: the first alone is short.
    growing = field([[0.5], [0.0]])
    assert len(path(growing, [0.1, 0.0], steps=9, rest=0.06, count=2)) == 10
    assert len(path(growing, [0.1, 0.0], steps=9, rest=0.06, count=1)) == 2


@pytest.mark.parametrize(("radius", "rows"), [(2.5, 5), (0.9, 5), (0.88, 12), (0.45, 12)])
def test_it_ends_before_a_step_away_from_an_end_that_is_near(radius, rows):
    # Along x in steps of one, past an end at (3.2, 0.4): the fifth point is the first beyond it,
    # at a distance of 0.894, and the next is farther.
    past = {"steps": 11, "end": [3.2, 0.4], "radius": radius}
    assert len(path(field(0.0, [1.0, 0.0]), [0.0, 0.0], **past)) == rows
    past["radius"] = 9.0
    assert len(path(field(0.0, [1.0, 0.0]), [0.0, 0.0], min_steps=6, **past)) == 7


def test_it_may_rest_at_the_very_start():
    assert len(path(field(0.0), [2.0, 2.0], rest=1e-3, count=1)) == 2
    assert len(path(field(0.0, [1.0, 0.0]), [0.5, 0.0], end=[0.0, 0.0], radius=1.0)) == 1
