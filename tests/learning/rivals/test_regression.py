import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning import TimeTPGMM
from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.fusion import Bands, over_time, time_mixture
from dressing_sim.learning.rivals.regression import FrameRegression, WorldRegression


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(4), 60)


def test_one_component_is_the_line_of_least_squares(shown, rng):
    path = WorldRegression(samples=60, components=1, floor=1e-12).learn(shown, rng)(
        shown.situations[0], shown.points[0, 0]
    )
    # The last sample is in no bin of the initial mixture, but in expectation-maximisation.
    line = np.polyfit(shown.phase, shown.points.mean(axis=0), 1)
    np.testing.assert_allclose(path, shown.phase[:, None] * line[0] + line[1], atol=1e-6)


def test_what_agrees_in_a_frame_is_reproduced_in_it(shown, rng):
    local = np.stack([np.linspace([0.0, 0, 0], [0.3, 0.1, 0.2], 60)] * 4)
    points = np.stack([f[1].to_world(x) for f, x in zip(shown.situations, local, strict=True)])
    told = Shown(points, shown.situations, 1.0)
    method = FrameRegression(samples=60, frame="last", components=3, floor=1e-9)
    for path, frames in zip(points, shown.situations, strict=True):
        np.testing.assert_allclose(method.learn(told, rng)(frames, path[0]), path, atol=1e-3)


def test_the_regression_and_the_product_are_those_of_the_library(shown):
    """Fused over frames it is the library's own time-based policy."""
    policy = TimeTPGMM(5, floor=1e-3, relative_floor=True, time_scale=1.0, ridge=0.0)
    policy.fit(shown.demonstrations())
    frames = shown.situations[2]
    expected, covariances = policy.at_times(frames, shown.phase)
    bands = over_time(time_mixture(shown, 5, 1e-3), shown.phase).in_world(frames).fused()
    np.testing.assert_allclose(bands.means, expected, atol=1e-9)
    np.testing.assert_allclose(bands.covariances, covariances, rtol=1e-6, atol=1e-12)


def test_a_product_weighs_by_precision():
    bands = Bands(np.array([[0.0], [3.0]]), np.array([[[1.0]], [[0.5]]]))
    assert bands.fused().means[0] == pytest.approx(2.0)
    assert bands.fused().covariances[0, 0] == pytest.approx(1.0 / 3.0)
    assert bands.fused(np.array([4.0, 1.0])).means[0] == pytest.approx(1.0)
