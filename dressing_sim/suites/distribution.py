"""Where postures are drawn from: ranges, and what is kept of them."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from math import isfinite
from types import NoneType

import numpy as np

from dressing_sim.arm import (
    ANGLE_LIMITS_DEG,
    ARM_SIZES,
    DEFAULT_SHOULDER,
    MAX_SHOULDER_DISPLACEMENT,
    Posture,
)
from dressing_sim.checks import of_kind, whole_number
from dressing_sim.control import RobotKinematics, TrackingConfig, configuration_at, track_path
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.scene import WorldConfig, grip_start

#: Draws for one posture, after which the ranges are held to be impossible. The default ranges need
#: fewer than two on average, those of ``hard_elbow`` about three.
MAX_DRAWS = 1000


@dataclass(frozen=True, slots=True)
class PostureDistribution:
    """Where random postures come from: uniform in each range, then kept if possible.

    The arm is held out forwards and sideways, within the anatomical limits, the forearm not far
    from horizontal, as somebody does who is helped into a sleeve. Own choice.

    Raises:
        InvalidInputError: A range outside the anatomical limits or upside down, an unknown size,
            or a distance that is negative or not finite.
    """

    flexion_deg: tuple[float, float] = (52.0, 90.0)
    abduction_deg: tuple[float, float] = (0.0, 55.0)
    rotation_deg: tuple[float, float] = (10.0, 70.0)
    elbow_deg: tuple[float, float] = (5.0, 70.0)
    sizes: tuple[str, ...] = ("male", "female")
    """Names of arms in `ARM_SIZES`, each as likely as any other."""
    shoulder_displacement: float = 0.03
    """The shoulder is moved by up to this much in each coordinate [m]."""
    max_forearm_slope_deg: float = 25.0
    """The forearm may slope up or down by at most this."""
    min_wrist_distance: float = 0.32
    """The wrist is at least this far from the axis of the robot's base [m]; nearer, the hand would
    be among the robot's own links."""
    shoulder_clearance: float = 0.09
    """The robot must be able to bring the gripper this far above the shoulder [m]."""

    def __post_init__(self) -> None:
        for angle, (lowest, highest) in ANGLE_LIMITS_DEG.items():
            low, high = getattr(self, angle)
            if not lowest <= low <= high <= highest:  # also false for NaN
                raise InvalidInputError(
                    f"posture distribution: {angle} is {low} to {high}, valid is a range from low "
                    f"to high within {lowest:g} to {highest:g}"
                )
        unknown = [size for size in self.sizes if size not in ARM_SIZES]
        if unknown or not self.sizes:
            raise InvalidInputError(
                f"posture distribution: sizes is {self.sizes}, valid is one or more of "
                f"{', '.join(ARM_SIZES)}"
            )
        for name, largest in (
            ("shoulder_displacement", MAX_SHOULDER_DISPLACEMENT),
            ("max_forearm_slope_deg", 90.0),
            ("min_wrist_distance", 10.0),
            ("shoulder_clearance", 10.0),
        ):
            value = getattr(self, name)
            if not (isfinite(value) and 0.0 <= value <= largest):
                raise InvalidInputError(
                    f"posture distribution: {name} is {value}, valid is 0 to {largest:g}"
                )


def sample_postures(
    n: int,
    rng: np.random.Generator,
    distribution: PostureDistribution | None = None,
    prefix: str = "random",
) -> list[Posture]:
    """Random postures that the robot can dress as far as its reach goes.

    Args:
        n: How many.
        rng: Source of randomness.
        distribution: Ranges and what is kept.
        prefix: Of the postures' names. Seeds of episodes depend on these, so draws that are
            compared or pooled should have different ones.

    Returns:
        Postures named ``PREFIX0``, ``PREFIX1``, ...; the first ones do not depend on n.

    Raises:
        InvalidInputError: n is not a whole number from 0, or nothing was kept of `MAX_DRAWS` draws.
    """
    whole_number(n, "the number of postures", 0, 99999)
    of_kind(rng, np.random.Generator, "rng", "a random generator of numpy's")
    valid = "a PostureDistribution or None"
    of_kind(distribution, (PostureDistribution, NoneType), "distribution", valid)
    of_kind(prefix, str, "prefix", "a text")
    distribution, kinematics = distribution or PostureDistribution(), RobotKinematics()
    return [sample_posture(f"{prefix}{i}", rng, distribution, kinematics) for i in range(n)]


def sample_posture(
    name: str,
    rng: np.random.Generator,
    distribution: PostureDistribution,
    kinematics: RobotKinematics,
) -> Posture:
    """One random posture, see `sample_postures`."""
    refused: Counter[str] = Counter()
    for _ in range(MAX_DRAWS):
        shift = rng.uniform(-1.0, 1.0, 3) * distribution.shoulder_displacement
        posture = Posture(
            name=name,
            flexion_deg=rng.uniform(*distribution.flexion_deg),
            abduction_deg=rng.uniform(*distribution.abduction_deg),
            rotation_deg=rng.uniform(*distribution.rotation_deg),
            elbow_deg=rng.uniform(*distribution.elbow_deg),
            size=distribution.sizes[rng.integers(len(distribution.sizes))],
            shoulder_position=tuple(np.add(DEFAULT_SHOULDER, shift).tolist()),
        )
        reason = refusal(posture, distribution, kinematics)
        if reason is None:
            return posture
        refused[reason] += 1
    reasons = ", ".join(f"{count} {reason}" for reason, count in refused.most_common())
    raise InvalidInputError(
        f"no posture was kept of {MAX_DRAWS} drawn from {distribution} ({reasons}); valid are "
        "ranges that more of the postures meet"
    )


def refusal(
    posture: Posture, distribution: PostureDistribution, kinematics: RobotKinematics
) -> str | None:
    """Why a posture in the ranges is not kept, or None if it is.

    Args:
        posture: The arm.
        distribution: What is kept.
        kinematics: The robot.
    """
    slope = (posture.elbow - posture.wrist)[2] / posture.arm_size.forearm_length
    slope_deg = np.rad2deg(np.arcsin(min(abs(slope), 1.0)))
    if slope_deg > distribution.max_forearm_slope_deg:
        return "with too steep a forearm"
    if np.hypot(*posture.wrist[:2]) < distribution.min_wrist_distance:
        return "with the wrist too near the robot"
    if not reachable(posture, kinematics, distribution.shoulder_clearance):
        return "out of the robot's reach"
    return None


def reachable(posture: Posture, kinematics: RobotKinematics, clearance: float) -> bool:
    """Whether the robot can follow the arm, from where the sleeve is held to above the shoulder.

    Args:
        posture: The arm.
        kinematics: The robot.
        clearance: Height over the elbow and the shoulder that it must get to [m].
    """
    config = TrackingConfig()
    start = grip_start(posture, WorldConfig().sleeve)
    q, error = configuration_at(start, kinematics, config)
    if error > config.max_error:
        return False
    above = np.array([0.0, 0.0, clearance])
    path = np.stack([start, posture.elbow + above, posture.shoulder + above])
    return track_path(path, 3.0, q, kinematics, config).max_error <= config.max_error
