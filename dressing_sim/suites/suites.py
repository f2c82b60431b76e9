"""Suites of postures: frozen files in ``assets/suites/``, files of the user, random draws."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.archives import read_strict_json
from dressing_sim.arm import Posture
from dressing_sim.checks import clean_name, of_kind, shown
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets, is_file, write_file
from dressing_sim.learning.frame import Frame
from dressing_sim.learning.sampling import euler_angles
from dressing_sim.suites.distribution import sample_postures
from dressing_sim.suites.drawn import DRAWN_SUITES

#: Version of the form of a suite's file.
VERSION = 1

#: What a suite's file may say; of these only the postures are needed.
_KEYS = frozenset({"name", "version", "description", "distribution", "motions", "seed", "postures"})

_RANDOM = re.compile(r"random:(?P<n>[1-9]\d{0,4})(:(?P<seed>\d{1,18}))?", re.ASCII)

_FIRST = re.compile(r"(.+):(\d{1,6})", re.ASCII)


def suite_names() -> list[str]:
    """Names of the suites that come with the package."""
    return sorted(path.stem for path in (assets() / "suites").glob("*.json"))


def load_suite(name_or_file: str) -> list[Posture]:
    """The postures of a suite.

    Args:
        name_or_file: A built-in name, a JSON file, either with ``:n`` after it for its first n
            postures, or ``random:N`` / ``random:N:SEED`` for N random postures (at most 99999, seed
            0 unless given), named ``randomSEED-0`` and so on.

    Raises:
        InvalidInputError: No such suite, it has fewer postures, or the file is not a valid one.
    """
    of_kind(name_or_file, str, "a suite", "a name, a JSON file, or random:N[:SEED]")
    # In random:N and random:N:SEED the number after the colon means something else.
    if name_or_file.startswith("random:"):
        return _random_suite(name_or_file)
    part = _FIRST.fullmatch(name_or_file)
    if part is not None and not is_file(name_or_file):
        postures, count = load_suite(part[1]), int(part[2])
        if not 1 <= count <= len(postures):
            raise InvalidInputError(
                f"suite {shown(name_or_file)}: valid is 1 to {len(postures)} postures of suite "
                f"{part[1]!r}"
            )
        return postures[:count]
    builtin = assets() / "suites" / f"{name_or_file}.json"
    path = builtin if is_file(builtin) else Path(name_or_file)
    if not is_file(path):
        raise InvalidInputError(
            f"unknown suite {shown(name_or_file)}; valid is one of "
            f"{', '.join(suite_names())}, the first n of one as NAME:n, a JSON file, or "
            "random:N[:SEED]"
        )
    try:
        content = read_strict_json(path)
    except InvalidInputError as error:
        raise InvalidInputError(f"suite {error}") from error
    return _postures(content, str(path))


def _random_suite(text: str) -> list[Posture]:
    match = _RANDOM.fullmatch(text)
    if match is None:
        raise InvalidInputError(
            f"suite {text!r}: valid is random:N or random:N:SEED, N from 1 to 99999, "
            "SEED a whole number from 0"
        )
    seed = int(match["seed"] or 0)
    return sample_postures(int(match["n"]), np.random.default_rng(seed), prefix=f"random{seed}-")


def _postures(content: Any, source: str) -> list[Posture]:
    entries = content.get("postures") if isinstance(content, Mapping) else None
    if not isinstance(entries, list) or not entries:
        raise InvalidInputError(
            f"suite {source}: no postures; valid is an object with a list 'postures'"
        )
    unknown = sorted(set(content) - _KEYS)
    if unknown:
        raise InvalidInputError(
            f"suite {source}: unknown key {shown(unknown[0])}; valid are {', '.join(sorted(_KEYS))}"
        )
    if "name" in content:
        clean_name(content["name"], f"suite {source}: name")
    version = content.get("version", VERSION)
    if type(version) is not int or version != VERSION:
        raise InvalidInputError(f"suite {source}: version is {shown(version)}, valid is {VERSION}")
    try:
        postures = [Posture.from_dict(entry) for entry in entries]
        for posture in postures:
            clean_name(posture.name, "the name of a posture")
    except InvalidInputError as error:
        raise InvalidInputError(f"suite {source}: {error}") from error
    counts = Counter(posture.name for posture in postures)
    twice = sorted(name for name, count in counts.items() if count > 1)
    if twice:
        raise InvalidInputError(f"suite {source}: the name {shown(twice[0])} occurs twice")
    return postures


#: How postures of random suites are called: by their seed and their place. All before it are drawn
#: too, at 0.05 s each.
_RANDOM_NAME = re.compile(r"random(\d{1,18})-(\d{1,3})", re.ASCII)


def _named(postures: Sequence[Posture], name: str, file: str) -> Posture:
    for posture in postures:
        if posture.name == name:
            return posture
    names = ", ".join(posture.name for posture in postures[:20])
    raise InvalidInputError(f"suite {file}: no posture {shown(name)}; valid is one of {names}")


def find_posture(name: str) -> Posture:
    """A posture of a suite by its name, or one given by its angles.

    Args:
        name: A name such as ``bent40``; one of a file or a random suite as ``mine.json:NAME`` and
            ``random0-6``; or ``FLEXION,ABDUCTION,ROTATION,ELBOW`` in degrees, with the size of the
            arm after it if wanted, such as ``,female_small``.

    Raises:
        InvalidInputError: No posture has this name, or an angle is impossible.
    """
    of_kind(name, str, "a posture", "a name, or FLEXION,ABDUCTION,ROTATION,ELBOW in degrees")
    if "," in name:
        parts = name.split(",")
        try:
            angles = [float(part) for part in parts[:4]]
        except ValueError:
            angles = []
        if len(angles) != 4 or len(parts) > 5:
            raise InvalidInputError(
                f"posture {shown(name)}: valid is FLEXION,ABDUCTION,ROTATION,ELBOW[,SIZE] in "
                "degrees"
            )
        flexion, abduction, rotation, elbow = angles
        size = parts[4] if len(parts) == 5 else "male"
        return Posture(name, flexion, abduction, rotation, elbow, size)
    if (random := _RANDOM_NAME.fullmatch(name)) is not None:
        return _random_suite(f"random:{int(random[2]) + 1}:{random[1]}")[-1]
    file, _, inside = name.rpartition(":")
    if inside and is_file(file):
        return _named(load_suite(file), inside, file)
    suites = {suite: load_suite(suite) for suite in suite_names()}
    known = {posture.name: posture for postures in suites.values() for posture in postures}
    if name not in known:
        listed = ", ".join(
            f"{posture.name}"
            for suite, postures in suites.items()
            if suite not in DRAWN_SUITES
            for posture in postures
        )
        drawn = ", ".join(
            f"{suites[suite][0].name} to {suites[suite][-1].name}" for suite in DRAWN_SUITES
        )
        raise InvalidInputError(
            f"unknown posture {shown(name)}; valid is one of {listed}, {drawn}, FILE:NAME, "
            "randomSEED-N, or FLEXION,ABDUCTION,ROTATION,ELBOW in degrees"
        )
    return known[name]


def write_suite(
    path: str | Path, name: str, postures: Sequence[Posture], header: Mapping[str, Any]
) -> None:
    """Write the file of a suite, one line a posture, every number to its last digit.

    Args:
        path: File to write.
        name: Name of the suite.
        postures: The suite.
        header: What else the file says: its description and, if drawn, from where.
    """
    fields = {"name": name, "version": VERSION, **header}
    lines = [f"  {json.dumps(key)}: {json.dumps(value)}," for key, value in fields.items()]
    entries = ",\n".join(f"    {json.dumps(posture.to_dict())}" for posture in postures)
    write_file(path, "\n".join(["{", *lines, '  "postures": [', entries, "  ]", "}", ""]))


@dataclass(frozen=True, slots=True)
class SituationDistance:
    """How far two situations of P frames are apart, frame by frame.

    Attributes:
        origins: Distance (P,) of the origins [m].
        euler_deg: Difference (P, 3) of the Euler angles about the fixed x, y and z axes of the
            robot's base [deg], each from -180 to 180.
        rotation_deg: Angle (P,) of the one rotation that turns one frame into the other [deg].
    """

    origins: NDArray[np.float64]
    euler_deg: NDArray[np.float64]
    rotation_deg: NDArray[np.float64]


def situation_distance(one: Sequence[Frame], other: Sequence[Frame]) -> SituationDistance:
    """How distinct two situations are, as the paper measures it.

    "The distances between the corresponding reference frames, and difference in Euler angles that
    represents difference in orientations" (Zhu, Gienger, Kober 2022, Section IV, Inputs):
    ``|b_n - b'_n|`` and ``euler(A'_n) - euler(A_n)`` for each frame n. The paper does not say
    which Euler angles; these are the roll, pitch and yaw of `dressing_sim.learning.sampling`. The
    frames of an arm do not roll (see `gravity_frame`). The angle of ``A'_n A_n^T`` is added
    because it does not depend on that choice.

    Args:
        one: Frames whose bases A are rotations, such as those of `Posture.frames`.
        other: As many frames of the same kind.

    Raises:
        InvalidInputError: Not the same number of frames, or none.
    """
    if len(one) != len(other) or not one:
        raise InvalidInputError(
            f"two situations have {len(one)} and {len(other)} frames, valid is the same number, "
            "one or more"
        )
    pairs = list(zip(one, other, strict=True))
    turns = np.array([euler_angles(b.A) - euler_angles(a.A) for a, b in pairs])
    cosines = np.array([(np.trace(b.A @ a.A.T) - 1.0) / 2.0 for a, b in pairs])
    return SituationDistance(
        origins=np.array([np.linalg.norm(b.b - a.b) for a, b in pairs]),
        euler_deg=np.rad2deg(np.angle(np.exp(1j * turns))),
        rotation_deg=np.rad2deg(np.arccos(np.clip(cosines, -1.0, 1.0))),
    )
