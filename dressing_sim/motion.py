"""How a person moves: a sway and a drift that nobody asked for, and an arm that gives way.

An arm has seven coordinates, see `COORDINATES`: where the shoulder is, and the anatomical angles of
`dressing_sim.arm.Posture`. A `Motion` says how far each is from the posture at each time, and how
hard the joints resist when cloth pulls the arm away from there. It is data of the person, such as
the size of the arm; `dressing_sim.world.person` carries it out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import listed, of_kind, one_of, real_array, real_number, shown
from dressing_sim.config import from_plain, to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.motion import minimum_jerk

T = TypeVar("T", bound="Sway | Drift")

#: The shoulder in the robot's base frame [m], then the angles of a posture [deg].
COORDINATES = (
    *(f"shoulder_{axis}" for axis in "xyz"),
    "flexion_deg",
    "abduction_deg",
    "rotation_deg",
    "elbow_deg",
)

#: Those of the arm's joints, without the shoulder's place.
JOINTS = COORDINATES[3:]

#: From the units of names and files to those of the code: metres stay, degrees become radians.
UNITS = np.array([np.deg2rad(1.0) if name.endswith("_deg") else 1.0 for name in COORDINATES])
UNITS.flags.writeable = False

#: Most sways, and drifts, of a motion.
MOST = 100

#: Largest amplitude of a sway and change of a drift, [m] and [deg]; more is no sway but a reach.
LARGEST: Mapping[str, float] = {
    name: 45.0 if name.endswith("_deg") else 0.10 for name in COORDINATES
}


@dataclass(frozen=True, slots=True)
class Sway:
    """A coordinate swings: ``amplitude sin(2 pi frequency t + phase)``.

    Attributes:
        coordinate: One of `COORDINATES`.
        amplitude: In metres or, of an angle, degrees.
        frequency: In hertz, up to 2; what is faster is no sway but tremor.
        phase_deg: In degrees.
    """

    coordinate: str
    amplitude: float
    frequency: float
    phase_deg: float = 0.0

    def __post_init__(self) -> None:
        one_of(self.coordinate, "sway: coordinate", COORDINATES)
        most = LARGEST[self.coordinate]
        _keep(self, amplitude=(0.0, most), frequency=(0.01, 2.0), phase_deg=(-360.0, 360.0))


@dataclass(frozen=True, slots=True)
class Drift:
    """A coordinate goes elsewhere and stays there, by minimum jerk (Flash and Hogan 1985).

    Attributes:
        coordinate: One of `COORDINATES`.
        change: From beginning to end, in metres or, of an angle, degrees.
        begin: Since the robot begins to move [s].
        duration: [s].
    """

    coordinate: str
    change: float
    begin: float = 0.0
    duration: float = 5.0

    def __post_init__(self) -> None:
        one_of(self.coordinate, "drift: coordinate", COORDINATES)
        most = LARGEST[self.coordinate]
        _keep(self, change=(-most, most), begin=(0.0, 3600.0), duration=(0.5, 3600.0))


@dataclass(frozen=True, slots=True)
class Compliance:
    """How the joints of a held arm resist being moved, in the order of `JOINTS`.

    ``torque = stiffness (where it is held - angle) + damping (its speed - speed)``. The arm's own
    weight is carried by the person wherever the arm is.

    The defaults are meant to be the diagonal of the matrices of Davidson and Charles, "Fundamental
    Principles of Tremor Propagation in the Upper Limb", Annals of Biomedical Engineering 45 (2017),
    doi:10.1007/s10439-016-1765-5: stiffness of shoulder flexion and elbow after Gomi and Osu
    (Journal of Neuroscience 18, 1998; 10.8 and 8.67 N m/rad, without torque in the joints); damping
    is 0.07 s times stiffness. Their couplings between joints, of one posture, are left out. The
    numbers were read in public programs, not in the articles' tables; ``docs/moving.md`` says what
    was found, and that an arm held out against gravity should be three to four times as stiff.

    Attributes:
        stiffness: [N m/rad].
        damping: [N m s/rad].
    """

    stiffness: tuple[float, ...] = (10.80, 5.468, 7.486, 8.670)
    damping: tuple[float, ...] = (0.756, 0.383, 0.524, 0.607)

    def __post_init__(self) -> None:
        for name, least in (("stiffness", 0.1), ("damping", 0.0)):
            told = f"compliance: {name}"
            values = listed(getattr(self, name), told, "a number for each joint")
            real_array(values, (len(JOINTS),), f"{told} has", "N m/rad, or N m s/rad")
            numbers = tuple(real_number(value, told, least, 1e4) for value in values)
            object.__setattr__(self, name, numbers)


@dataclass(frozen=True, slots=True)
class Motion:
    """How a person moves during a dressing, and gives way.

    In the first ``ease`` seconds sways grow from nothing, so that the arm begins in its posture and
    at rest:

        offset(t) = m(t / ease) sum_i a_i sin(2 pi f_i t + p_i) + sum_j c_j m((t - b_j) / d_j)

    where m is minimum jerk from 0 to 1.

    Attributes:
        sway: Any number for a coordinate.
        drift: The same.
        compliance: How the joints give way to forces; None for an arm that nothing moves from
            where it wants to be.
        ease: [s].
    """

    sway: tuple[Sway, ...] = ()
    drift: tuple[Drift, ...] = ()
    compliance: Compliance | None = None
    ease: float = 1.0

    def __post_init__(self) -> None:
        for name, kind in (("sway", Sway), ("drift", Drift)):
            values = listed(getattr(self, name), f"motion: {name}", f"a list of {kind.__name__}")
            for value in values:
                of_kind(value, kind, f"motion: {name}", f"a list of {kind.__name__}")
            object.__setattr__(self, name, values)
        if self.compliance is not None:
            of_kind(self.compliance, Compliance, "motion: compliance", "a Compliance or None")
        _keep(self, ease=(0.1, 60.0))

    def offsets(self, time: float) -> NDArray[np.float64]:
        """How far the coordinates are from the posture's, (7,) [m, rad].

        Args:
            time: Since the robot began to move [s]; before, the person is still.
        """
        found = np.zeros(len(COORDINATES))
        eased = float(minimum_jerk(np.asarray(time / self.ease)))
        for one in self.sway:
            angle = 2.0 * np.pi * one.frequency * time + np.deg2rad(one.phase_deg)
            found[COORDINATES.index(one.coordinate)] += eased * one.amplitude * np.sin(angle)
        for other in self.drift:
            share = minimum_jerk(np.asarray((time - other.begin) / other.duration))
            found[COORDINATES.index(other.coordinate)] += other.change * float(share)
        return found * UNITS

    def farthest(self) -> NDArray[np.float64]:
        """Bounds of the offsets, (2, 7) [m, deg]: least and greatest, which need not be reached."""
        bounds = np.zeros((2, len(COORDINATES)))
        for one in self.sway:
            bounds[:, COORDINATES.index(one.coordinate)] += [-one.amplitude, one.amplitude]
        for other in self.drift:
            column = COORDINATES.index(other.coordinate)
            bounds[:, column] += [min(other.change, 0.0), max(other.change, 0.0)]
        return bounds

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file; `from_dict` is the inverse."""
        return {
            "sway": _plain(self.sway),
            "drift": _plain(self.drift),
            "compliance": None if self.compliance is None else to_plain(self.compliance),
            "ease": self.ease,
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Motion:
        """Build a motion from plain values, checking names and types.

        Raises:
            InvalidInputError: A key is unknown, or a value is not valid.
        """
        of_kind(values, Mapping, "motion", "an object")
        chosen: dict[str, Any] = dict(values)
        for name, kind in (("sway", Sway), ("drift", Drift)):
            given = listed(chosen.get(name, ()), f"motion: {name}", "a list of objects")
            if len(given) > MOST:
                raise InvalidInputError(f"motion: {len(given)} of {name}, valid is up to {MOST}")
            chosen[name] = [_from_plain(kind, one, name) for one in given]
        if chosen.get("compliance") is not None:
            chosen["compliance"] = from_plain(Compliance, chosen["compliance"])
        return from_plain(cls, chosen)


def _keep(config: Sway | Drift | Motion, **limits: tuple[float, float]) -> None:
    """Numbers of a configuration as floats, once each is within its limits."""
    for name, (low, high) in limits.items():
        told = f"{type(config).__name__.lower()}: {name}"
        object.__setattr__(config, name, real_number(getattr(config, name), told, low, high))


def _from_plain(kind: type[T], values: Mapping[str, Any], name: str) -> T:
    try:
        return from_plain(kind, values)
    except TypeError as error:  # what must be there is not
        raise InvalidInputError(f"motion: {name}: {shown(values)} has too few keys") from error


def _plain(values: Sequence[Sway | Drift]) -> list[dict[str, Any]]:
    return [to_plain(value) for value in values]
