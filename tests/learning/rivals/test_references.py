import numpy as np
import pytest
from learning_tasks import moved_frames, reaching_demonstrations

from dressing_sim.learning import Frame, rotation
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.references import Nearest, Straight, ViaOracle, nearest


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(3), 60)


def test_each_situation_is_nearest_to_itself_wherever_it_is_moved(shown):
    turn, shift = rotation([0.2, -0.7, 2.0]), np.array([3.0, 1.0, -1.0])
    for index, frames in enumerate(shown.situations):
        assert nearest(shown, moved_frames(frames, turn, shift)) == index


def test_the_nearest_demonstration_is_played_as_it_was_and_turned_with_its_frames(shown, rng):
    skill = Nearest(samples=60).learn(shown, rng)
    turn, shift = rotation([0.2, -0.7, 2.0]), np.array([3.0, 1.0, -1.0])
    for path, frames in zip(shown.points, shown.situations, strict=True):
        np.testing.assert_allclose(skill(frames, path[0]), path, atol=1e-12)
        there = skill(moved_frames(frames, turn, shift), path[0])
        np.testing.assert_allclose(there, path @ turn.T + shift, atol=1e-9)


def test_a_path_follows_the_frame_that_it_is_near(shown, rng):
    skill = Nearest(samples=60).learn(shown.only([0]), rng)
    first, last = shown.situations[0]
    there = skill((first, Frame(last.A, last.b + 0.1)), shown.points[0, 0])
    np.testing.assert_allclose(there[0], shown.points[0, 0], atol=2e-3)
    np.testing.assert_allclose(there[-1], shown.points[0, -1] + 0.1, atol=2e-3)


def test_a_straight_line_is_straight_from_the_start_to_the_end(shown, rng):
    start, frames = np.array([0.3, -0.2, 0.1]), shown.situations[1]
    path = Straight(samples=60).learn(shown, rng)(frames, start)
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    assert length == pytest.approx(np.linalg.norm(path[-1] - start))
    np.testing.assert_allclose(path[-1], shown.place(-1).predict(frames), atol=1e-12)


def test_the_oracle_passes_its_via_points_in_a_demonstrated_situation(shown, rng):
    alone = shown.only([2])
    path = ViaOracle(samples=60, via_points=59).learn(alone, rng)(
        alone.situations[0], alone.points[0, 0]
    )
    np.testing.assert_allclose(path, alone.points[0], atol=1e-9)


def test_the_oracle_finds_the_system_in_which_demonstrations_agree(rng):
    """A path that is the same seen from the last frame's axes at the first frame's origin."""
    base = reaching_demonstrations(4)
    local = np.linspace([0.0, 0.0, 0.0], [0.1, 0.2, 0.3], 60)
    situations = tuple(tuple(one.frames) for one in base)
    mixed = [Frame(last.A, first.b) for first, last in situations]
    points = np.stack([frame.to_world(local) for frame in mixed])
    skill = ViaOracle(samples=60).learn(Shown(points[:3], situations[:3], 1.0), rng)
    np.testing.assert_allclose(skill(situations[3], points[3, 0]), points[3], atol=1e-9)
