"""Suites of postures: frozen lists in ``assets/suites/``, files of the user, random draws."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from dressing_sim.arm import ARM_SIZES, DEFAULT_SHOULDER, Posture
from dressing_sim.assets_path import assets
from dressing_sim.control import PandaKinematics, TrackingConfig, configuration_at, track_path
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.scene import WorldConfig, grip_start


@dataclass(frozen=True, slots=True)
class PostureDistribution:
    """Where random postures come from: uniform in each range, then kept if possible.

    The arm is held out forwards and sideways, within the anatomical limits, the forearm not far
    from horizontal, as somebody does who is helped into a sleeve. Own choice.
    """

    flexion_deg: tuple[float, float] = (52.0, 90.0)
    abduction_deg: tuple[float, float] = (0.0, 55.0)
    rotation_deg: tuple[float, float] = (10.0, 70.0)
    elbow_deg: tuple[float, float] = (5.0, 70.0)
    shoulder_displacement: float = 0.03
    """The shoulder is moved by up to this much in each coordinate [m]."""
    max_forearm_slope_deg: float = 25.0
    """The forearm may slope up or down by at most this."""
    min_wrist_distance: float = 0.32
    """The wrist is at least this far from the axis of the robot's base [m]; nearer, the hand would
    be among the robot's own links."""
    shoulder_clearance: float = 0.09
    """The robot must be able to bring the gripper this far above the shoulder [m]."""


def sample_postures(
    n: int, rng: np.random.Generator, distribution: PostureDistribution | None = None
) -> list[Posture]:
    """Random postures that the robot can dress as far as its reach goes.

    Args:
        n: How many.
        rng: Source of randomness.
        distribution: Ranges and what is kept.

    Returns:
        Postures named ``random0``, ``random1``, ...
    """
    distribution = distribution or PostureDistribution()
    kinematics = PandaKinematics()
    sizes = tuple(ARM_SIZES)
    postures: list[Posture] = []
    while len(postures) < n:
        shift = rng.uniform(-1.0, 1.0, 3) * distribution.shoulder_displacement
        posture = Posture(
            name=f"random{len(postures)}",
            flexion_deg=rng.uniform(*distribution.flexion_deg),
            abduction_deg=rng.uniform(*distribution.abduction_deg),
            rotation_deg=rng.uniform(*distribution.rotation_deg),
            elbow_deg=rng.uniform(*distribution.elbow_deg),
            size=sizes[rng.integers(len(sizes))],
            shoulder_position=tuple(np.add(DEFAULT_SHOULDER, shift).tolist()),
        )
        slope = posture.elbow - posture.wrist
        slope_deg = np.rad2deg(np.arcsin(abs(slope[2]) / posture.arm_size.forearm_length))
        if (
            slope_deg <= distribution.max_forearm_slope_deg
            and np.hypot(*posture.wrist[:2]) >= distribution.min_wrist_distance
            and reachable(posture, kinematics, distribution.shoulder_clearance)
        ):
            postures.append(posture)
    return postures


def reachable(posture: Posture, kinematics: PandaKinematics, clearance: float) -> bool:
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


def suite_names() -> list[str]:
    """Names of the suites that come with the package."""
    return sorted(path.stem for path in (assets() / "suites").glob("*.json"))


def load_suite(name_or_file: str) -> list[Posture]:
    """The postures of a suite.

    Args:
        name_or_file: A built-in name, a JSON file, or ``random:N`` / ``random:N:SEED`` for N
            random postures (seed 0 unless given).

    Raises:
        InvalidInputError: No such suite, or the file is not a valid one.
    """
    if name_or_file.startswith("random:"):
        return _random_suite(name_or_file)
    builtin = assets() / "suites" / f"{name_or_file}.json"
    path = builtin if _is_file(builtin) else Path(name_or_file)
    if not _is_file(path):
        raise InvalidInputError(
            f"unknown suite {name_or_file!r}; valid is one of {', '.join(suite_names())}, a JSON "
            "file, or random:N[:SEED]"
        )
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise InvalidInputError(f"suite {path}: not JSON ({error})") from error
    return _postures(content, str(path))


def _is_file(path: Path) -> bool:
    try:
        return path.is_file()
    except OSError:  # a name too long for a file, for instance
        return False


def _random_suite(text: str) -> list[Posture]:
    parts = text.split(":")[1:]
    if not (1 <= len(parts) <= 2 and all(part.isdecimal() for part in parts) and int(parts[0]) > 0):
        raise InvalidInputError(f"suite {text!r}: valid is random:N or random:N:SEED, N above zero")
    seed = int(parts[1]) if len(parts) == 2 else 0
    return sample_postures(int(parts[0]), np.random.default_rng(seed))


def _postures(content: Any, source: str) -> list[Posture]:
    entries = content.get("postures") if isinstance(content, Mapping) else None
    if not isinstance(entries, list) or not entries:
        raise InvalidInputError(
            f"suite {source}: no postures; valid is an object with a list 'postures'"
        )
    postures = [Posture.from_dict(entry if isinstance(entry, Mapping) else {}) for entry in entries]
    names = [posture.name for posture in postures]
    twice = {name for name in names if names.count(name) > 1}
    if twice:
        raise InvalidInputError(f"suite {source}: the name {sorted(twice)[0]!r} occurs twice")
    return postures


def find_posture(name: str) -> Posture:
    """A posture of a built-in suite by its name, or one given by its angles.

    Args:
        name: A name such as ``bent40``, or ``FLEXION,ABDUCTION,ROTATION,ELBOW`` in degrees, with
            ``,male`` or ``,female`` after it if wanted.

    Raises:
        InvalidInputError: No posture has this name, or an angle is impossible.
    """
    if "," in name:
        parts = name.split(",")
        try:
            angles = [float(part) for part in parts[:4]]
        except ValueError:
            angles = []
        if len(angles) != 4 or len(parts) > 5:
            raise InvalidInputError(
                f"posture {name!r}: valid is FLEXION,ABDUCTION,ROTATION,ELBOW[,SIZE] in degrees"
            )
        flexion, abduction, rotation, elbow = angles
        size = parts[4] if len(parts) == 5 else "male"
        return Posture(name, flexion, abduction, rotation, elbow, size)
    known = {posture.name: posture for suite in suite_names() for posture in load_suite(suite)}
    if name not in known:
        raise InvalidInputError(
            f"unknown posture {name!r}; valid is one of {', '.join(sorted(known))}, or "
            "FLEXION,ABDUCTION,ROTATION,ELBOW in degrees"
        )
    return known[name]
