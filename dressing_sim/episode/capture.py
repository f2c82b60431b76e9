"""Where somebody who watches believes that a moving arm is: late, not always, and not exactly."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import whole_number
from dressing_sim.config import check_numbers
from dressing_sim.motion import UNITS
from dressing_sim.seeds import derived_seed


@dataclass(frozen=True, slots=True)
class CaptureConfig:
    """What a motion-capture system or a camera tells of an arm that moves; own choice.

    A still arm is known exactly, unless `still`. The usual one is a camera and a skeleton fitted to
    what it sees, not markers, which nobody wears to be dressed.
    """

    rate: float = 30.0
    """Measurements a second [Hz]; each is taken at the control step before its time."""
    latency: float = 0.1
    """From a measurement until it is known [s]. The first one is known from the start."""
    position_noise: float = 0.005
    """Standard deviation of the shoulder's place, each coordinate [m]."""
    angle_noise: float = 0.02
    """Standard deviation of each angle [rad]."""
    still: bool = False
    """Whether a still arm is measured as well: once, before the robot moves."""
    seed: int = 0
    """Of the noise. It also depends on the posture's name, and on nothing else: rows of a table
    see the same arm."""

    def __post_init__(self) -> None:
        noise = ("position_noise", "angle_noise")
        check_numbers(self, "capture", ("rate",), ("latency", *noise))
        whole_number(self.seed, "capture: seed", 0, 2**63 - 1)


class MotionCapture:
    """Measures the arm of one dressing; it remembers nothing.

    Args:
        posture: The arm.
        config: Rate, latency, noise.
    """

    def __init__(self, posture: Posture, config: CaptureConfig) -> None:
        self._posture, self._config = posture, config
        self._stream = derived_seed(f"{config.seed}/capture {posture.name}")

    def newest(self, time: float) -> int:
        """Number of the newest measurement that is known, from 0, so long after the start [s]."""
        late = (time - self._config.latency) * self._config.rate
        return max(int(np.floor(late + 1e-9)), 0)  # times are sums of steps

    def taken(self, number: int) -> float:
        """When a measurement is taken, after the start [s]."""
        return number / self._config.rate

    def measured(self, number: int, coordinates: NDArray[np.float64]) -> Posture:
        """What a measurement says: the arm with noise, or the nearest possible one.

        Args:
            number: Which.
            coordinates: Where the arm is then, (7,) [m, rad], as `World.person` says.
        """
        config = self._config
        noise = np.array([config.position_noise] * 3 + [config.angle_noise] * 4)
        drawn = np.random.default_rng([self._stream, number]).normal(0.0, 1.0, len(noise))
        return self._posture.at((coordinates + noise * drawn) / UNITS)
