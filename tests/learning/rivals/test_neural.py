import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.learning.rivals import Shown
from dressing_sim.learning.rivals.neural import NeuralPrimitive, _layers, loss


@pytest.fixture(scope="module")
def shown():
    return Shown.of(reaching_demonstrations(2, wobble=0.0), 50)


def test_slopes_are_those_of_finite_differences(rng):
    encoder, decoder = _layers(6, 8, 8, rng), _layers(11, 8, 6, rng)
    given, q = rng.standard_normal((3, 6)), rng.standard_normal(2)
    asked, path = rng.uniform(size=4), rng.standard_normal((4, 3))
    _, slopes = loss(encoder, decoder, given, asked, path, q)
    for layer, slope in zip([*encoder, *decoder], slopes, strict=True):
        place = np.unravel_index(int(np.argmax(np.abs(slope))), layer.shape)
        values = []
        for step in (1e-6, -2e-6):
            layer[place] += step
            values.append(loss(encoder, decoder, given, asked, path, q)[0])
        layer[place] += 1e-6
        assert slope[place] == pytest.approx((values[0] - values[1]) / 2e-6, rel=1e-5, abs=1e-7)


def test_the_order_of_observed_points_does_not_matter(rng):
    """Published: observations are averaged."""
    encoder, decoder = _layers(6, 8, 8, rng), _layers(11, 8, 6, rng)
    given, q = rng.standard_normal((4, 6)), rng.standard_normal(2)
    rest = rng.uniform(size=4), rng.standard_normal((4, 3)), q
    one, other = (loss(encoder, decoder, g, *rest)[0] for g in (given, given[::-1]))
    assert one == pytest.approx(other, rel=1e-12)


def test_two_demonstrations_are_told_apart_and_reproduced(shown):
    skill = NeuralPrimitive(samples=50, steps=1500).learn(shown, np.random.default_rng(0))
    for path, frames in zip(shown.points, shown.situations, strict=True):
        error = np.linalg.norm(skill(frames, path[0]) - path, axis=1)
        assert error.mean() < 0.1 * shown.scale
