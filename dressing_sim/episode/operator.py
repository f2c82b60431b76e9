"""The scripted operator: leads the gripper as a person would who can see the whole arm.

It starts above the wrist, follows the forearm, goes round the outside of the elbow so far that the
underside of the sleeve passes it too, follows the upper arm and ends above the shoulder. Each call
draws its own speed, heights, waypoints and tremor, as no two demonstrations of a person are alike.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from types import NoneType
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.interpolate import PchipInterpolator

from dressing_sim.arm import Posture, up_across
from dressing_sim.checks import of_kind, real_number, real_vector, whole_number
from dressing_sim.config import LATER, check_numbers
from dressing_sim.learning import DemonstrationLike
from dressing_sim.learning.policy import Inputs
from dressing_sim.path import Path

Vector = NDArray[np.float64]

#: Time between two commands that a disturbance reaches [s]; a choice of this package: people
#: correct what they see a few times a second.
COMMAND_PERIOD = 0.2


@dataclass(frozen=True, slots=True)
class OperatorConfig:
    """Where the operator leads the gripper, and how much a person varies.

    Heights are distances of the gripper from the arm's axis, upwards across the arm.
    """

    dt: float = 0.02
    """Time between two points of the path [s]."""
    forearm_height: float = 0.080
    """Over the forearm [m]."""
    elbow_height: float = 0.095
    """On arrival at the elbow [m]."""
    outer_height: float = -0.04
    """Beside a right-angled elbow, on its outside; straighter arms are passed higher [m]."""
    outer_distance: float = 0.16
    """Farthest from the upper arm's axis, sideways, when passing the elbow [m]."""
    overshoot: float = 0.22
    """How far the gripper goes on along the forearm's line beyond the elbow [m]."""
    upper_height: float = 0.085
    """Over the upper arm if the arm is straight [m]."""
    upper_outer_height: float = 0.035
    """Over the upper arm after a right-angled elbow [m]."""
    upper_distance: float = 0.12
    """Sideways from the upper arm after a right-angled elbow [m]."""
    slope_lift: float = 0.05
    """How much higher beside and over an upper arm that points straight down, in proportion to
    the sine of its slope: else the hand, wider than the fingers, would touch the arm [m]."""
    upper_fraction: float = 0.5
    """Where along the upper arm the last waypoint before the shoulder is, 0 elbow, 1 shoulder."""
    shoulder_height: float = 0.090
    """Over the shoulder at the end [m]."""
    speed: float = 0.10
    """Mean speed of the gripper [m/s]."""
    speed_variation: float = 0.15
    """Standard deviation of the logarithm of the speed."""
    height_variation: float = 0.004
    """Standard deviation of all heights of one path together [m]."""
    waypoint_variation: float = 0.004
    """Standard deviation of each waypoint, each coordinate [m]."""
    sway: float = 0.002
    """Amplitude of slow drift, below 1 Hz [m]."""
    tremor: float = 0.0003
    """Amplitude of physiological tremor, 6 to 10 Hz [m]."""
    disturbance: float = field(default=0.0, metadata=LATER)
    """How far noise in the commands leads the gripper off the way that the operator means it to go:
    standard deviation in the long run, each coordinate [m]. The operator sees it and corrects."""
    correction: float = field(default=0.5, metadata=LATER)
    """Time constant of the operator's correction of a disturbance [s]."""

    def __post_init__(self) -> None:
        names = [field.name for field in fields(self)]
        varied = [name for name in names if name.endswith("variation")]
        varied += ["sway", "tremor", "disturbance"]
        check_numbers(self, "operator", ("dt", "speed", "correction"), varied)
        for name in names:
            # Metres or less: nothing that a person does is larger. A step or a speed near zero
            # would make a path of more points than memory has room for.
            low = 1e-3 if name in ("dt", "speed", "correction") else -10.0
            real_number(getattr(self, name), f"operator: {name}", low, 10.0)


class Operator:
    """Draws paths for the gripper from full knowledge of the posture: the policy ``expert``.

    Args:
        config: Heights, speed and variability.
    """

    inputs: ClassVar[Inputs] = "posture"

    #: Its randomness is the episode's own, in demonstrations and in tests.
    stream: ClassVar[str] = ""

    def __init__(self, config: OperatorConfig | None = None) -> None:
        of_kind(config, (OperatorConfig, NoneType), "operator: config", "OperatorConfig or None")
        self.config = config or OperatorConfig()

    @property
    def dt(self) -> float:
        """Time between two points of a path [s]."""
        return self.config.dt

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn nothing."""
        return self

    def generate(self, posture: Posture, start: ArrayLike, seed: int = 0) -> Path:
        """The path that a seed gives, see `path`."""
        of_kind(posture, Posture, "posture", "a Posture")
        whole_number(seed, "seed")
        start = real_vector(start, 3, "start has", "m")
        return Path(self.path(posture, start, np.random.default_rng(seed)), self.dt)

    def path(self, posture: Posture, start: Vector, rng: np.random.Generator) -> Vector:
        """A path from the gripper's position to above the shoulder.

        Args:
            posture: The arm to dress; the operator sees all of it, the elbow included.
            start: Gripper (3,), in the robot's base frame [m].
            rng: Source of the path's variability.

        Returns:
            Positions, shape (n, 3), one each ``config.dt`` seconds, in the robot's base frame [m].
        """
        config = self.config
        raised = rng.normal(0.0, config.height_variation)
        waypoints = self._waypoints(posture, raised)
        waypoints += rng.normal(0.0, config.waypoint_variation, waypoints.shape)
        points = np.vstack([start, waypoints])
        lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
        distance = np.concatenate([[0.0], np.cumsum(lengths)])
        speed = config.speed * np.exp(rng.normal(0.0, config.speed_variation))
        duration = distance[-1] / speed
        time = np.append(np.arange(0.0, duration, config.dt), duration)
        path = PchipInterpolator(distance, points)(distance[-1] * _minimum_jerk(time / duration))
        path = path + self._shake(time, rng)
        # Drawn last, and only if wanted: the way that is meant is the same with and without.
        return path + self._astray(time, rng) if config.disturbance > 0.0 else path

    def _waypoints(self, posture: Posture, raised: float) -> NDArray[np.float64]:
        """Waypoints (5, 3) after the start [m]."""
        config, size = self.config, posture.arm_size
        wrist, elbow, shoulder = posture.wrist, posture.elbow, posture.shoulder
        along_forearm = (elbow - wrist) / size.forearm_length
        along_upper = (shoulder - elbow) / size.upper_arm_length
        over_forearm, over_upper = up_across(along_forearm), up_across(along_upper)
        # The outside of the bend: where the forearm's line goes on, as seen from the upper arm.
        forward = along_forearm @ along_upper
        outside = along_forearm - forward * along_upper
        outside = outside - (outside @ over_upper) * over_upper
        bend = float(np.linalg.norm(outside))  # sine of the sideways bend, 0 for a straight arm
        if bend > 0.0:
            outside = outside / bend
        # A nearly straight arm needs no detour.
        turn = float(np.linalg.norm(np.cross(along_forearm, along_upper)))
        overshoot = config.overshoot * min(1.0, 2.0 * turn)

        lift = raised + config.slope_lift * bend * max(along_upper[2], 0.0)

        def between(straight: float, bent: float) -> float:
            return straight + (bent - straight) * bend + lift

        on_forearm = wrist + 0.4 * (elbow - wrist) + (config.forearm_height + raised) * over_forearm
        at_elbow = elbow - 0.02 * along_forearm + (config.elbow_height + raised) * over_forearm
        ahead = overshoot * max(float(forward), 0.0)
        round_elbow = (
            elbow
            + between(config.elbow_height, config.outer_height) * over_upper
            + ahead * along_upper
            + min(overshoot * bend, config.outer_distance) * outside
        )
        on_upper = (
            elbow
            + max(config.upper_fraction * size.upper_arm_length, ahead + 0.05) * along_upper
            + between(config.upper_height, config.upper_outer_height) * over_upper
            + config.upper_distance * bend * outside
        )
        over_shoulder = shoulder + (config.shoulder_height + raised) * over_upper
        return np.stack([on_forearm, at_elbow, round_elbow, on_upper, over_shoulder])

    def _shake(self, time: Vector, rng: np.random.Generator) -> NDArray[np.float64]:
        """Sway and tremor, shape (n, 3) [m]; zero at the start, where the gripper is at rest."""
        shake = np.zeros((len(time), 3))
        for amplitude, low, high in (
            (self.config.sway, 0.2, 0.8),
            (self.config.tremor, 6.0, 10.0),
        ):
            for axis in range(3):
                frequency = rng.uniform(low, high, 3)
                phase = rng.uniform(0.0, 2.0 * np.pi, 3)
                waves = np.sin(2.0 * np.pi * frequency * time[:, None] + phase)
                shake[:, axis] += amplitude / np.sqrt(3.0) * waves.sum(axis=1)
        # Fade in and out over half a second: nobody trembles before moving.
        ramp = np.clip(np.minimum(time, time[-1] - time) / 0.5, 0.0, 1.0)
        return shake * ramp[:, None]

    def _astray(self, time: Vector, rng: np.random.Generator) -> NDArray[np.float64]:
        """What noise in the commands does to a path, shape (n, 3) [m]; nothing at the start.

        A command is where the gripper should be next. Each gets noise, and leads back a part of
        what earlier noise has done: ``e' = a e + sqrt(1 - a^2) s n``, ``a = exp(-period /
        correction)``, s the disturbance and n normal. Noise in the supervisor's commands is DART's
        (Laskey et al. 2017, "DART: noise injection for robust imitation learning", CoRL).
        """
        config = self.config
        kept = np.exp(-COMMAND_PERIOD / config.correction)
        times = np.arange(0.0, time[-1] + COMMAND_PERIOD, COMMAND_PERIOD)
        noise = rng.normal(0.0, config.disturbance * np.sqrt(1.0 - kept**2), (len(times), 3))
        error = np.zeros((len(times), 3))
        for step in range(1, len(times)):
            error[step] = kept * error[step - 1] + noise[step]
        return np.column_stack([np.interp(time, times, column) for column in error.T])


def _minimum_jerk(x: Vector) -> Vector:
    """Fraction of a reach covered at a fraction of its time: even, with a soft start and end.

    A blend of constant speed and the minimum-jerk profile of Flash and Hogan (1985),
    ``10 x^3 - 15 x^4 + 6 x^5``.
    """
    return 0.7 * x + 0.3 * (10.0 * x**3 - 15.0 * x**4 + 6.0 * x**5)
