import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.attractor import VirtualAttractor, attractor, drawn


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


def from_rest(path):
    return np.concatenate([path[:1], path])


def test_the_attractor_of_a_path_draws_the_mass_along_it(shown):
    path = from_rest(shown.points[0])
    np.testing.assert_allclose(drawn(attractor(path), path[0]), path, atol=1e-9)


def test_an_attractor_that_stands_still_is_where_the_path_does():
    path = np.tile([1.0, -2.0, 0.5], (30, 1))
    np.testing.assert_allclose(attractor(path), path, atol=1e-12)


def test_an_attractor_at_an_even_speed_runs_ahead_by_damping_over_stiffness():
    speed = np.array([0.6, 0.0, -0.2])
    path = np.linspace(0.0, 1.0, 200)[:, None] * speed
    ahead = (attractor(path) - path)[5:-2]
    np.testing.assert_allclose(ahead, np.tile(4.0 / 25.0 * speed, (len(ahead), 1)), atol=1e-9)


def test_a_start_elsewhere_is_forgotten(shown, rng):
    skill = VirtualAttractor(samples=60).learn(shown, rng)
    frames, start = shown.situations[0], shown.points[0, 0]
    near, far = skill(frames, start), skill(frames, start + [0.1, -0.1, 0.1])
    apart = np.linalg.norm(far - near, axis=1)
    assert apart[0] == pytest.approx(0.1 * np.sqrt(3.0))
    assert apart[30] < 0.1 * apart[0]
    assert apart[-1] < 1e-3 * apart[0]


def test_demonstrations_are_reproduced(shown, rng):
    method = VirtualAttractor(samples=60, components=12, floor=1e-6)
    skill = method.learn(shown, rng)
    for path, frames in zip(shown.points, shown.situations, strict=True):
        assert np.linalg.norm(skill(frames, path[0]) - path, axis=1).max() < 0.05
