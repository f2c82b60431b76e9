import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.fusion import Bands
from dressing_sim.learning.rivals.kernelized import KernelizedPrimitives

AT = np.linspace(0.0, 1.0, 20)
ASKED = np.linspace(0.0, 1.0, 33)


def reference(variance):
    means = np.column_stack([np.sin(3.0 * AT), np.cos(2.0 * AT)])
    return Bands(means, np.tile(variance * np.eye(2), (20, 1, 1)))


def test_with_equal_covariances_it_is_kernel_ridge_regression():
    method, bands = KernelizedPrimitives(kernel=20.0, trust=2.0), reference(0.01)
    gram = np.exp(-20.0 * (AT[:, None] - AT) ** 2)
    cross = np.exp(-20.0 * (ASKED[:, None] - AT) ** 2)
    expected = cross @ np.linalg.solve(gram + 0.02 * np.eye(20), bands.means)
    np.testing.assert_allclose(method.predict(AT, bands, None, ASKED).means, expected, atol=1e-8)


def test_its_variance_is_that_of_a_gaussian_process_scaled():
    method, bands = KernelizedPrimitives(kernel=20.0, spread=60.0), reference(0.01)
    gram = np.exp(-20.0 * (AT[:, None] - AT) ** 2)
    cross = np.exp(-20.0 * (ASKED[:, None] - AT) ** 2)
    known = np.sum(cross * np.linalg.solve(gram + 0.6 * np.eye(20), cross.T).T, axis=1)
    found = method.predict(AT, bands, None, ASKED).covariances
    np.testing.assert_allclose(found[:, 0, 0], 20 / 60.0 * (1.0 - known), atol=1e-6)
    np.testing.assert_allclose(found[:, 0, 1], 0.0, atol=1e-9)


def test_a_via_point_is_passed():
    start = np.array([0.4, 0.2])
    path = KernelizedPrimitives().predict(AT, reference(0.01), start, ASKED).means
    np.testing.assert_allclose(path[0], start, atol=1e-3)


def test_what_demonstrations_agree_on_is_reproduced(rng):
    shown = Shown.of(reaching_demonstrations(3, wobble=0.0), 60)
    skill = KernelizedPrimitives(samples=60, floor=1e-5, components=10).learn(shown, rng)
    for path, frames in zip(shown.points, shown.situations, strict=True):
        assert np.linalg.norm(skill(frames, path[0]) - path, axis=1).max() < 0.05
        np.testing.assert_allclose(skill(frames, path[0])[0], path[0], atol=1e-3)


def test_the_parameters_are_checked():
    with pytest.raises(InvalidInputError, match="kernel"):
        KernelizedPrimitives(kernel=-1.0)
