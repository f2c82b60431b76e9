"""The arm to be dressed: its size, its anatomical limits, and a posture with its two frames.

Coordinates are those of the robot's base: x forward, y to the robot's left, z up, in metres. The
mannequin sits at the robot's right-hand side and looks along +y, so its left arm, the one that is
dressed, is the one next to the robot.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, astuple, dataclass, field, replace
from numbers import Real
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import of_kind, real_number, shown
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import Frame, Situation
from dressing_sim.motion import COORDINATES, UNITS, Motion

Vector = NDArray[np.float64]

#: Directions of the mannequin's body in the robot's base frame.
FORWARD = np.array([0.0, 1.0, 0.0])
LEFT = np.array([-1.0, 0.0, 0.0])
UP = np.array([0.0, 0.0, 1.0])

#: Where the left shoulder joint is when the mannequin sits in its usual place [m].
DEFAULT_SHOULDER = (0.52, -0.26, 0.24)

#: The shoulder joint may be displaced from its usual place by at most this much a coordinate [m].
MAX_SHOULDER_DISPLACEMENT = 0.15

#: Anatomical ranges [deg], American Academy of Orthopaedic Surgeons, Joint Motion (1965). Flexion,
#: abduction and internal rotation are positive.
ANGLE_LIMITS_DEG: Mapping[str, tuple[float, float]] = {
    "flexion_deg": (-60.0, 180.0),
    "abduction_deg": (-50.0, 180.0),
    "rotation_deg": (-90.0, 70.0),
    "elbow_deg": (0.0, 150.0),
}


@dataclass(frozen=True, slots=True)
class ArmSize:
    """Lengths and radii of one arm [m]."""

    upper_arm_length: float
    upper_arm_radius: float
    forearm_length: float
    forearm_radius: float
    hand_radius: float

    def scaled(self, deviations: float, variation: ArmSize) -> ArmSize:
        """This arm with every measure the same number of standard deviations larger.

        Args:
            deviations: How many, negative for a smaller arm.
            variation: Standard deviation divided by mean of each measure.
        """
        pairs = zip(astuple(self), astuple(variation), strict=True)
        return ArmSize(*(value * (1.0 + deviations * relative) for value, relative in pairs))


#: Least and greatest measure of an arm that is not one of `ARM_SIZES` [m], from small children to
#: very tall adults with room to spare (own choice): beyond are other units, or slips of the finger.
SIZE_LIMITS: Mapping[str, tuple[float, float]] = {
    "upper_arm_length": (0.10, 0.45),
    "upper_arm_radius": (0.015, 0.09),
    "forearm_length": (0.08, 0.42),
    "forearm_radius": (0.012, 0.08),
    "hand_radius": (0.012, 0.08),
}


def own_size(size: ArmSize | Mapping[str, object], name: str) -> ArmSize:
    """The size of somebody's arm, or its measures by name, once each is within `SIZE_LIMITS`.

    Args:
        size: Lengths and radii [m].
        name: What errors call it.

    Raises:
        InvalidInputError: A measure is missing, unknown, no number, or not an arm's.
    """
    given = asdict(size) if isinstance(size, ArmSize) else dict(size)
    odd = sorted({*given} ^ {*SIZE_LIMITS}, key=str)
    if odd:
        raise InvalidInputError(
            f"{name} has {shown(sorted(map(str, given)))}, valid are {', '.join(SIZE_LIMITS)}, in m"
        )
    limits = SIZE_LIMITS.items()
    return ArmSize(*(real_number(given[key], f"{name}: {key} [m]", *each) for key, each in limits))


#: Frames that an arm has at its joints, and the joint that each one's x axis points at.
FRAMES: Mapping[str, str] = {"shoulder": "elbow", "wrist": "elbow", "elbow": "shoulder"}

#: The paper's situation.
SITUATION = ("shoulder", "wrist")

#: 50th percentile; lengths and radii as in Assistive Gym's ``human_creation.py``.
_MEDIAN = {
    "male": ArmSize(0.279, 0.043, 0.257, 0.033, 0.043),
    "female": ArmSize(0.264, 0.0355, 0.234, 0.027, 0.0355),
}

#: Standard deviation / mean of each measure in ANSUR II, the 2012 Anthropometric Survey of U.S.
#: Army Personnel (Gordon et al., Natick/TR-15/007; its public data, 4082 men and 1986 women), in
#: the order of `ArmSize`: acromion-radiale length, flexed biceps circumference, radiale-stylion
#: length, flexed forearm circumference, hand circumference.
ARM_VARIATION: Mapping[str, ArmSize] = {
    "male": ArmSize(0.0521, 0.0967, 0.0576, 0.0709, 0.0483),
    "female": ArmSize(0.0552, 0.1007, 0.0632, 0.0701, 0.0473),
}

#: Arms by name: the 50th percentiles, and ``_small`` and ``_large`` with every measure two standard
#: deviations below or above them.
ARM_SIZES: Mapping[str, ArmSize] = _MEDIAN | {
    f"{sex}_{name}": median.scaled(deviations, ARM_VARIATION[sex])
    for sex, median in _MEDIAN.items()
    for name, deviations in (("small", -2.0), ("large", 2.0))
}


def rotation_about(axis: Vector, angle: float) -> NDArray[np.float64]:
    """Rotation matrix (3, 3) about a unit axis by an angle [rad] (Rodrigues' formula)."""
    x, y, z = axis
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


@dataclass(frozen=True, slots=True)
class Posture:
    """A posture of the left arm, given by anatomical joint angles; of a still arm unless it moves.

    With all angles zero the arm hangs straight down. The upper arm is first abducted (sideways),
    then flexed (forward and up), after being turned about its own axis (internal rotation); the
    elbow then bends the forearm, forward when the arm hangs unrotated.

    Attributes:
        name: What the posture is called in suites and reports.
        flexion_deg: Shoulder flexion [deg].
        abduction_deg: Shoulder abduction [deg].
        rotation_deg: Internal (+) or external (-) rotation of the upper arm [deg].
        elbow_deg: Elbow flexion [deg]; zero is the straight arm.
        size: Name of an arm in `ARM_SIZES`, or lengths and radii of somebody's own.
        shoulder_position: Shoulder joint (3,) in the robot's base frame [m]; any sequence of
            numbers, kept as a tuple.
        motion: How the person moves away from this posture, and gives way; None for an arm that
            stays where it is.

    Raises:
        InvalidInputError: A name that is no text, an angle that is no number or outside
            ``ANGLE_LIMITS_DEG``, an unknown size or one that no arm has, a shoulder that is not
            three numbers or further from its usual place than ``MAX_SHOULDER_DISPLACEMENT``, or a
            motion that leaves these limits.
    """

    name: str
    flexion_deg: float
    abduction_deg: float
    rotation_deg: float
    elbow_deg: float
    size: str | ArmSize = "male"
    shoulder_position: tuple[float, float, float] = field(default=DEFAULT_SHOULDER)
    motion: Motion | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise InvalidInputError(f"posture {shown(self.name)}: valid is a name that is text")
        for angle, (low, high) in ANGLE_LIMITS_DEG.items():
            value = getattr(self, angle)
            number = isinstance(value, Real) and not isinstance(value, bool)
            if not (number and low <= value <= high):  # also false for NaN
                raise InvalidInputError(
                    f"posture {self.name!r}: {angle} is {shown(value)}, "
                    f"valid is {low:g} to {high:g}, a number of degrees"
                )
            object.__setattr__(self, angle, float(value))
        if isinstance(self.size, ArmSize):
            object.__setattr__(self, "size", own_size(self.size, f"posture {self.name!r}: size"))
        elif not isinstance(self.size, str) or self.size not in ARM_SIZES:
            raise InvalidInputError(
                f"posture {self.name!r}: unknown size {shown(self.size)}, "
                f"valid is one of {', '.join(ARM_SIZES)}, or an ArmSize"
            )
        place = _numbers(self.shoulder_position)
        if len(place) != 3 or not all(
            abs(value - usual) <= MAX_SHOULDER_DISPLACEMENT + 1e-9  # 0.52 + 0.15 is rounded up
            for value, usual in zip(place, DEFAULT_SHOULDER, strict=True)
        ):
            raise InvalidInputError(
                f"posture {self.name!r}: shoulder_position is {shown(self.shoulder_position)}, "
                f"valid is {DEFAULT_SHOULDER} +- {MAX_SHOULDER_DISPLACEMENT:g} m in each coordinate"
            )
        object.__setattr__(self, "shoulder_position", place)
        if self.motion is not None:
            self._check_motion(of_kind(self.motion, Motion, "posture: motion", "a Motion or None"))

    def _check_motion(self, motion: Motion) -> None:
        least, most = coordinate_limits()
        for name, value, low, high, first, last in zip(
            COORDINATES, self.coordinates, least, most, *motion.farthest(), strict=True
        ):
            if value + first < low - 1e-9 or value + last > high + 1e-9:
                raise InvalidInputError(
                    f"posture {self.name!r}: its motion takes {name} from {value + first:g} to "
                    f"{value + last:g}, valid is {low:g} to {high:g}"
                )

    @property
    def coordinates(self) -> Vector:
        """Place of the shoulder and angles, (7,), in the order of `COORDINATES` [m, deg]."""
        return np.array([*self.shoulder_position, *(getattr(self, a) for a in ANGLE_LIMITS_DEG)])

    def at(self, coordinates: Vector) -> Posture:
        """The still posture of the same arm with these coordinates, or the nearest to them.

        Args:
            coordinates: (7,), in the order of `COORDINATES` [m, deg].
        """
        numbers = np.clip(coordinates, *coordinate_limits())
        angles = dict(zip(ANGLE_LIMITS_DEG, numbers[3:].tolist(), strict=True))
        place = tuple(numbers[:3].tolist())
        return replace(self, shoulder_position=place, motion=None, **angles)

    def moved(self, joints: Vector | None) -> Posture:
        """`at` where the joints of a person who moves are, (7,) [m, rad]; itself for None."""
        return self if joints is None else self.at(joints / UNITS)

    @property
    def arm_size(self) -> ArmSize:
        """Lengths and radii of the arm."""
        return self.size if isinstance(self.size, ArmSize) else ARM_SIZES[self.size]

    @property
    def size_name(self) -> str:
        """The size in a word or a few."""
        if isinstance(self.size, str):
            return self.size
        size = self.size
        return f"{1e3 * size.upper_arm_length:.0f} + {1e3 * size.forearm_length:.0f} mm"

    @property
    def upper_arm_rotation(self) -> NDArray[np.float64]:
        """Orientation (3, 3) of the upper arm: columns forward, left, up of the hanging arm."""
        flexion, abduction, rotation = np.deg2rad(
            [self.flexion_deg, self.abduction_deg, self.rotation_deg]
        )
        # The left-handed signs follow from the body's axes: raising the arm forward turns it
        # about LEFT the negative way, sideways about FORWARD the positive way.
        return (
            rotation_about(LEFT, -flexion)
            @ rotation_about(FORWARD, abduction)
            @ rotation_about(UP, -rotation)
            @ np.column_stack([FORWARD, LEFT, UP])
        )

    @property
    def shoulder(self) -> Vector:
        """Shoulder joint (3,) in the robot's base frame [m]."""
        return np.array(self.shoulder_position, dtype=float)

    @property
    def elbow(self) -> Vector:
        """Elbow joint (3,) in the robot's base frame [m]."""
        return self.shoulder - self.arm_size.upper_arm_length * self.upper_arm_rotation[:, 2]

    @property
    def wrist(self) -> Vector:
        """Wrist joint (3,) in the robot's base frame [m]."""
        forward, _, up = self.upper_arm_rotation.T
        bend = np.deg2rad(self.elbow_deg)
        direction = -np.cos(bend) * up + np.sin(bend) * forward
        return self.elbow + self.arm_size.forearm_length * direction

    def frames(self, *names: str) -> Situation:
        """The situation a policy is asked for: the frames at the shoulder and at the wrist.

        Args:
            names: Other frames, of `FRAMES`, in this order.

        Returns:
            Frames with their origins at the joints of these names and their x axes towards the
            elbow (Zhu, Gienger, Kober 2022, Section VI), that of the elbow towards the shoulder.
            The paper leaves the other two axes open; here z points up as far as x allows (see
            `gravity_frame`), because a sleeve hangs, and because this is defined for a straight
            arm too.

        Raises:
            InvalidInputError: The arm has no such frame.
        """
        return situation(self.shoulder, self.elbow, self.wrist, names or SITUATION)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file; `from_dict` is the inverse."""
        return {
            "name": self.name,
            **{angle: getattr(self, angle) for angle in ANGLE_LIMITS_DEG},
            "size": asdict(self.size) if isinstance(self.size, ArmSize) else self.size,
            "shoulder_position": list(self.shoulder_position),
            **({} if self.motion is None else {"motion": self.motion.to_dict()}),
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Posture:
        """Build a posture from plain values, checking names and types.

        Raises:
            InvalidInputError: A key is missing or unknown, or a value is not valid.
        """
        if not isinstance(values, Mapping):
            raise InvalidInputError(
                f"posture {shown(values)}: missing its name and angles, valid is an object"
            )
        required = {"name", *ANGLE_LIMITS_DEG}
        allowed = {*required, "size", "shoulder_position", "motion"}
        name = values.get("name", "without a name")
        missing, unknown = required - set(values), set(values) - allowed
        if missing or unknown:
            what = (
                f"missing {sorted(missing)}"
                if missing
                else f"unknown {shown(sorted(map(str, unknown)))}"
            )
            raise InvalidInputError(
                f"posture {shown(name)}: {what}, valid keys are {', '.join(sorted(allowed))}"
            )
        size = values.get("size")
        if isinstance(size, Mapping):
            values = {**values, "size": own_size(size, f"posture {shown(name)}: size")}
        if values.get("motion") is not None:
            values = {**values, "motion": Motion.from_dict(values["motion"])}
        return cls(**values)


def coordinate_limits() -> tuple[Vector, Vector]:
    """Least and greatest coordinates (7,) of an arm, in the order of `COORDINATES` [m, deg]."""
    angles = np.array(list(ANGLE_LIMITS_DEG.values())).T
    middle = np.array(DEFAULT_SHOULDER)
    least = np.concatenate([middle - MAX_SHOULDER_DISPLACEMENT, angles[0]])
    return least, np.concatenate([middle + MAX_SHOULDER_DISPLACEMENT, angles[1]])


def _numbers(values: object) -> tuple[float, ...]:
    """A tuple of floats, empty if the values are not all numbers."""
    try:
        listed = [] if isinstance(values, str) else list(values)  # type: ignore[call-overload]
    except Exception:  # whatever an object of somebody else's does
        listed = []
    valid = all(isinstance(value, Real) and not isinstance(value, bool) for value in listed)
    return tuple(float(value) for value in listed) if valid else ()


def up_across(axis: Vector) -> Vector:
    """Unit vector (3,) across a unit vector, as far up as it allows.

    ``(up - (up . axis) axis) / |.|``; along a vertical axis (within 0.6 degrees) `FORWARD` takes
    the part of up.
    """
    across = UP - (UP @ axis) * axis
    if np.linalg.norm(across) < 1e-2:
        across = FORWARD - (FORWARD @ axis) * axis
    return across / np.linalg.norm(across)


def gravity_frame(origin: Vector, towards: Vector) -> Frame:
    """Frame with x towards a point and z as far up as x allows.

    ``x = (towards - origin) / |.|``, z as `up_across` has it, ``y = z x x``.

    Args:
        origin: Origin (3,) in the robot's base frame [m].
        towards: Point (3,) on the positive x axis, in the same frame [m].
    """
    x = (towards - origin) / np.linalg.norm(towards - origin)
    z = up_across(x)
    return Frame(np.column_stack([x, np.cross(z, x), z]), origin)


def situation(
    shoulder: Vector, elbow: Vector, wrist: Vector, names: Sequence[str] = SITUATION
) -> Situation:
    """Frames of an arm given by its three joints (3,) [m], see `Posture.frames`."""
    joints = {"shoulder": shoulder, "elbow": elbow, "wrist": wrist}
    unknown = [name for name in names if not isinstance(name, str) or name not in FRAMES]
    if unknown:
        raise InvalidInputError(f"unknown frame {shown(unknown[0])}; valid is {', '.join(FRAMES)}")
    return Situation.of([gravity_frame(joints[n], joints[FRAMES[n]]) for n in names], names)
