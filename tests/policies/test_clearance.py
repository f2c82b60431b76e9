import numpy as np

from dressing_sim.policies.clearance import beside, within
from dressing_sim.policies.skeleton import Skeleton

SKELETON = Skeleton(np.zeros(3), np.array([0.0, 0.3, 0.0]), np.array([0.0, 0.6, 0.0]))


def alongside(side, height):
    """A path beside a straight arm, at these distances from its axis."""
    return np.column_stack([np.full(80, side), np.linspace(0.55, 0.05, 80), np.full(80, height)])


def test_a_path_within_bounds_stays_as_it_is():
    path = alongside(0.08, 0.06)
    bounds = np.full((2, 80), [[0.05], [0.15]])
    np.testing.assert_array_equal(within(path, SKELETON, *bounds), path)
    hand = np.array([0.0, 0.0, 0.1])
    np.testing.assert_array_equal(beside(path, SKELETON, hand, np.full(80, 0.1)), path)


def test_a_path_is_led_to_the_nearer_bound():
    for side, expected in ((0.04, 0.06), (0.2, 0.15)):
        bounds = np.full((2, 80), [[0.06], [0.15]])
        moved = within(alongside(side, 0.0), SKELETON, *bounds)
        np.testing.assert_allclose(np.linalg.norm(SKELETON.outward(moved), axis=1), expected)


def test_corrections_are_smooth():
    """A bound that holds for half the path makes no step."""
    bounds = np.where(np.arange(80) < 40, 0.12, 0.0), np.full(80, 1.0)
    moved = within(alongside(0.06, 0.0), SKELETON, *bounds)
    assert np.abs(np.diff(moved[:, 0])).max() < 0.6 * 0.06
    assert moved[20, 0] > 0.119
    assert moved[60, 0] < 0.061


def test_the_hand_is_cleared_sideways_alone():
    hand, path = np.array([0.0, 0.0, 0.1]), alongside(0.08, 0.02)
    moved = beside(path, SKELETON, hand, np.full(80, 0.17))
    np.testing.assert_array_equal(moved[:, 2], path[:, 2])
    assert np.all(moved[:, 0] > path[:, 0] + 0.01)
    distance = np.linalg.norm(SKELETON.outward(moved + hand), axis=1)
    before = np.linalg.norm(SKELETON.outward(path + hand), axis=1)
    assert np.all(0.17 - distance < 0.4 * (0.17 - before))
    over = alongside(0.0, 0.02)
    np.testing.assert_allclose(beside(over, SKELETON, hand, np.full(80, 0.17)), over, atol=1e-12)
