import numpy as np
import pytest
from learning_tasks import moved_frames, reaching_demonstrations

from dressing_sim.learning import rotation
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.springs import forces, rollout
from dressing_sim.learning.rivals.task_dmp import TaskDMP, task_parameters


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


def test_forces_of_a_path_lead_along_it(shown):
    path = shown.points[0]
    # It begins at rest, so the first step has no length.
    path = np.concatenate([path[:1], path])
    np.testing.assert_allclose(rollout(forces(path, path[-1]), path[0], path[-1]), path, atol=1e-9)


def test_without_forces_the_goal_is_neared_and_not_passed():
    path = rollout(np.zeros((200, 1)), np.zeros(1), np.ones(1))
    assert path[-1, 0] == pytest.approx(1.0, abs=2e-3)
    assert np.all(np.diff(path[:, 0]) >= 0.0)
    assert path.max() <= 1.0


def test_forces_over_phase_move_every_goal_by_as_much(shown):
    path = shown.points[0]
    force = forces(path, path[-1])
    away = rollout(force, path[0] + 0.3, path[-1] + 0.3)
    np.testing.assert_allclose(away, rollout(force, path[0], path[-1]) + 0.3, atol=1e-9)


def test_task_parameters_do_not_change_when_a_situation_is_moved(shown):
    frames = shown.situations[0]
    there = moved_frames(frames, rotation([0.3, 1.0, -2.0]), np.array([4.0, 5.0, 6.0]))
    np.testing.assert_allclose(task_parameters(there, 0.6), task_parameters(frames, 0.6), atol=1e-9)


def test_a_demonstrated_situation_is_that_demonstrations_own(shown, rng):
    method = TaskDMP(samples=60, components=14, floor=1e-8, width=0.2)
    skill = method.learn(shown, rng)
    for path, frames in zip(shown.points, shown.situations, strict=True):
        assert np.linalg.norm(skill(frames, path[0]) - path, axis=1).max() < 0.06
        assert np.linalg.norm(skill(frames, path[0])[-1] - path[-1]) < 0.03
