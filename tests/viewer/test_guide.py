import numpy as np
import pytest

from dressing_sim.viewer.choices import Choices
from dressing_sim.viewer.guide import Guide

EYE = np.array([-0.05, 1.05, 0.80])


@pytest.fixture(scope="module")
def guide():
    return Guide.of(Choices())


def test_who_points_at_the_line_means_its_point_near_the_gripper(guide):
    points = guide.path.positions
    for at in (*range(20, len(points) - 60, 20), len(points) - 1):
        beyond = EYE + 1.7 * (points[at] - EYE)
        meant = guide.pointed_at(EYE, beyond, at - 10)
        assert np.linalg.norm(points[meant] - points[at]) < 0.005


def test_who_points_elsewhere_or_far_along_means_no_point(guide):
    points = guide.path.positions
    assert guide.pointed_at(EYE, points[100] + [0.0, 0.0, 0.5], 100) is None
    assert guide.pointed_at(EYE, points[-1] + [0.3, 0.0, 0.0], 0) is None


def test_what_is_left_falls_along_the_line_to_nothing(guide):
    points = guide.path.positions
    left = [guide.left(point) for point in points]
    assert left[-1] == 0.0
    assert (np.diff(left) <= 0.0).all()
    assert left[0] == pytest.approx(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())


@pytest.mark.parametrize(("at", "to"), [(40, 120), (120, 40)])
def test_a_way_goes_along_the_line_no_faster_than_allowed(guide, at, to):
    points = guide.path.positions
    way = guide.way(points[at], at, to, 0.02, 0.25)
    assert np.allclose(way[-1], points[to])
    steps = np.linalg.norm(np.diff([points[at], *way], axis=0), axis=1)
    assert steps.max() <= 0.25 * 0.02 + 1e-9
    beside = np.linalg.norm(way[:, None] - points, axis=-1).min(axis=1)
    assert beside.max() < 0.005
