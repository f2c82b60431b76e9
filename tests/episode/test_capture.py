"""What is told of a moving arm: how late, how often, how exactly."""

import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.episode.capture import CaptureConfig, MotionCapture
from dressing_sim.errors import InvalidInputError
from dressing_sim.motion import UNITS

POSTURE = Posture("one", 70, 20, 30, 40)
HERE = POSTURE.coordinates * UNITS


def test_the_newest_measurement_is_the_last_that_has_had_time_to_arrive():
    capture = MotionCapture(POSTURE, CaptureConfig(rate=10.0, latency=0.25))
    for time, number in ((0.0, 0), (0.34, 0), (0.35, 1), (0.44, 1), (0.45, 2), (10.25, 100)):
        assert capture.newest(time) == number
        assert capture.taken(number) <= max(time - 0.25, 0.0) + 1e-9
    at_once = MotionCapture(POSTURE, CaptureConfig(rate=50.0, latency=0.0))
    assert [at_once.newest(0.02 * step) for step in range(50)] == list(range(50))


def test_without_noise_it_is_the_arm():
    exact = MotionCapture(POSTURE, CaptureConfig(position_noise=0.0, angle_noise=0.0))
    seen = exact.measured(7, HERE)
    np.testing.assert_allclose(seen.coordinates, POSTURE.coordinates, atol=1e-12)
    assert seen.motion is None


def test_noise_has_the_stated_deviation_and_each_measurement_its_own():
    config = CaptureConfig(position_noise=0.004, angle_noise=0.015)
    capture = MotionCapture(POSTURE, config)
    seen = np.array([capture.measured(n, HERE).coordinates * UNITS - HERE for n in range(2000)])
    np.testing.assert_allclose(seen.std(axis=0), [0.004] * 3 + [0.015] * 4, rtol=0.08)
    np.testing.assert_allclose(seen.mean(axis=0), 0.0, atol=2e-3)
    assert np.abs(np.corrcoef(seen[:-1, 0], seen[1:, 0])[0, 1]) < 0.08


def test_noise_depends_on_seed_name_and_number_alone():
    def first(seed=0, name="one", number=3):
        posture = Posture(name, 70, 20, 30, 40)
        return MotionCapture(posture, CaptureConfig(seed=seed)).measured(number, HERE).coordinates

    np.testing.assert_array_equal(first(), first())
    for other in (first(seed=1), first(name="other"), first(number=4)):
        assert np.abs(first() - other).min() > 0.0


def test_an_arm_that_cannot_be_is_seen_as_the_nearest_that_can():
    straight = Posture("straight", 70, 20, 30, 0.0)
    capture = MotionCapture(straight, CaptureConfig(angle_noise=0.2))
    bends = [capture.measured(n, straight.coordinates * UNITS).elbow_deg for n in range(50)]
    assert min(bends) == 0.0
    assert max(bends) > 5.0


@pytest.mark.parametrize(
    "choice", [{"rate": 0.0}, {"latency": -0.1}, {"angle_noise": np.nan}, {"seed": -1}]
)
def test_numbers_that_cannot_be_meant_are_refused(choice):
    with pytest.raises(InvalidInputError, match=f"capture: {next(iter(choice))}"):
        CaptureConfig(**choice)
