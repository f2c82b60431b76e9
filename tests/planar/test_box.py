import numpy as np
import pytest

from dressing_sim.learning import Frame, SyntheticDemonstration, rotation
from dressing_sim.planar.box import MOUTH, OUTLINE, outline, penetration, violation

BOX = Frame(np.eye(2), np.zeros(2))


def test_the_outline_is_closed_and_moves_with_the_frame():
    frame = Frame(2 * rotation(0.5), [3.0, 4.0])
    corners = outline(frame)
    np.testing.assert_array_equal(corners[0], corners[-1])
    np.testing.assert_allclose(frame.to_local(corners[:-1]), OUTLINE, atol=1e-12)


@pytest.mark.parametrize(
    ("path", "depth"),
    [
        ([[0, 0], MOUTH, [0, 3]], 0.0),  # up the channel and out
        ([[0, 0], [0.2, 0.5], [0.0, 0.9]], 0.05),  # a little into the right wall
        ([[0, 0.5], [3, 0.5]], 0.125),  # right through the wall, which is 0.25 thick
        ([[0, 0], [0, -3]], 0.125),  # through the bottom
        ([[5, 5], [6, 6]], 0.0),
    ],
)
def test_depth_in_the_walls(path, depth):
    assert penetration(path, BOX) == pytest.approx(depth, abs=0.02)


def test_a_wall_between_two_samples_is_seen():
    assert penetration([[0.0, 0.5], [3.0, 0.5]], BOX) > 0.1


def test_depth_is_in_world_units():
    path = np.array([[0, 0.5], [3, 0.5]])
    small = Frame(0.1 * np.diag([-1.0, 1.0]), np.zeros(2))
    assert penetration(small.to_world(path), small) == pytest.approx(
        0.1 * penetration(path, BOX), rel=0.1
    )


def test_the_violation_is_that_of_the_worst_box():
    far = Frame(np.eye(2), [100.0, 0.0])
    path = np.array([[0, 0.5], [3, 0.5]])
    demonstration = SyntheticDemonstration(path, 0.1, (far, BOX))
    assert violation(demonstration) == penetration(path, BOX)
