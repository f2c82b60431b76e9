import numpy as np
import pytest
from learning_tasks import moved_frames, reaching_demonstrations

from dressing_sim.learning import Frame, rotation
from dressing_sim.learning.registration import corners
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.transported import Transportation, evidence
from dressing_sim.learning.transport import Transport


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(2), 60)


def test_a_moved_situation_moves_the_path_with_it(shown, rng):
    skill = Transportation(samples=60).learn(shown, rng)
    turn, shift = rotation([0.3, 0.2, -1.0]), np.array([1.0, 2.0, 3.0])
    for path, frames in zip(shown.points, shown.situations, strict=True):
        there = skill(moved_frames(frames, turn, shift), path[0])
        np.testing.assert_allclose(there, path @ turn.T + shift, atol=1e-8)


def test_the_points_that_frames_mark_are_met(shown, rng):
    """A frame elsewhere takes the end of the path, which is at its origin, along."""
    skill = Transportation(samples=60, noise=1e-3).learn(shown.only([0]), rng)
    first, last = shown.situations[0]
    frames = first, Frame(last.A, last.b + [0.05, -0.1, 0.08])
    path = skill(frames, shown.points[0, 0])
    assert np.linalg.norm(path[-1] - shown.points[0, -1] - [0.05, -0.1, 0.08]) < 0.01
    assert np.linalg.norm(path[0] - shown.points[0, 0]) < 0.01


def test_the_evidence_is_that_of_a_gaussian_process(shown):
    sources = corners(shown.situations[0], 0.3)
    targets = corners(shown.situations[1], 0.3)
    for length in (0.2, 0.7):
        made = Transport.between(sources, targets, length, 0.05)
        gaps = np.sum((made.anchors[:, None] - made.anchors) ** 2, axis=2)
        covariance = made.amplitude**2 * (
            np.exp(-0.5 * gaps / length**2) + 0.05**2 * np.eye(len(gaps))
        )
        left = targets - made.anchors
        _, log = np.linalg.slogdet(covariance)
        expected = -0.5 * (np.sum(left * np.linalg.solve(covariance, left)) + 3 * log)
        # The quadratic term at the most likely amplitude is the number of values.
        assert evidence(made) == pytest.approx(expected + 0.5 * left.size)
