"""Where the motions of people are drawn from, and what is kept of them."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from dressing_sim.arm import Posture
from dressing_sim.control import RobotKinematics
from dressing_sim.errors import InvalidInputError
from dressing_sim.motion import COORDINATES, UNITS, Drift, Motion, Sway
from dressing_sim.suites.distribution import (
    MAX_DRAWS,
    PostureDistribution,
    reachable,
    sample_posture,
)


@dataclass(frozen=True, slots=True)
class MotionDistribution:
    """Where random motions come from: a drift and sways of a held-out arm. Own choice.

    The arm drifts for some seconds, one coordinate after another or several together, as somebody
    does who tires, reaches for the sleeve or is asked to hold still; angles sway slowly about that,
    and the trunk sways with breath and balance. A posture is drawn again if the robot could not
    reach the arm at one of `TIMES`.
    """

    drift_deg: float = 15.0
    """Each angle drifts by up to so much, either way."""
    drift_begin: tuple[float, float] = (0.0, 5.0)
    """Each drift begins within this time [s]."""
    drift_duration: tuple[float, float] = (3.0, 8.0)
    """And takes so long [s]."""
    shoulder_drift: float = 0.02
    """Each coordinate of the shoulder drifts by up to so much, either way [m]."""
    sway_deg: tuple[float, float] = (0.5, 2.5)
    """Amplitude of each angle's sway."""
    shoulder_sway: tuple[float, float] = (0.0, 0.01)
    """Of each coordinate of the shoulder [m]."""
    sway_frequency: tuple[float, float] = (0.1, 0.4)
    """Of each sway [Hz]."""

    def draw(self, rng: np.random.Generator) -> Motion:
        """A random motion."""
        sways, drifts = [], []
        for name in COORDINATES:
            angle = name.endswith("_deg")
            most = self.drift_deg if angle else self.shoulder_drift
            change, begin, duration = (
                float(rng.uniform(*limits))
                for limits in ((-most, most), self.drift_begin, self.drift_duration)
            )
            drifts.append(Drift(name, change, begin, duration))
            amplitude, frequency, phase_deg = (
                float(rng.uniform(*limits))
                for limits in (
                    self.sway_deg if angle else self.shoulder_sway,
                    self.sway_frequency,
                    (0.0, 360.0),
                )
            )
            sways.append(Sway(name, amplitude, frequency, phase_deg))
        return Motion(tuple(sways), tuple(drifts))


#: When a moving arm must be within reach: a dressing takes some twelve seconds [s].
TIMES = (3.0, 6.0, 9.0, 12.0, 15.0)


def sample_moving_postures(
    n: int,
    rng: np.random.Generator,
    distribution: PostureDistribution,
    motions: MotionDistribution,
    prefix: str = "moving",
) -> list[Posture]:
    """Random postures, as of `sample_postures`, that move at random, within reach all the time."""
    kinematics, kept = RobotKinematics(), []
    for number in range(n):
        for _ in range(MAX_DRAWS):
            posture = sample_posture(f"{prefix}{number}", rng, distribution, kinematics)
            moving = _moving(posture, motions.draw(rng))
            if moving is None or moving.motion is None:
                continue
            offsets = [moving.motion.offsets(time) / UNITS for time in TIMES]
            later = [moving.at(moving.coordinates + offset) for offset in offsets]
            clearance = distribution.shoulder_clearance
            if all(reachable(one, kinematics, clearance) for one in later):
                kept.append(moving)
                break
        else:
            raise InvalidInputError(f"no motion was kept of {MAX_DRAWS} drawn from {motions}")
    return kept


def _moving(posture: Posture, motion: Motion) -> Posture | None:
    """The posture with this motion, or None if an arm cannot move so."""
    try:
        return replace(posture, motion=motion)
    except InvalidInputError:
        return None
