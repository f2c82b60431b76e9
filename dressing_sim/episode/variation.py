"""Worlds other than the nominal one: factors that are drawn anew for an episode, or fixed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from dressing_sim.arm import ARM_SIZES, Posture
from dressing_sim.checks import one_of, real_number
from dressing_sim.episode.capture import CaptureConfig
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.seeds import derived_seed
from dressing_sim.world.garment import FABRICS, GARMENTS, Fabric, find_garment

#: What can vary.
FACTORS = ("friction", "fabric", "garment", "arm", "grasp", "frames")

#: Those that are one of several names.
_NAMES: Mapping[str, Mapping[str, object]] = {
    "fabric": FABRICS,
    "garment": GARMENTS,
    "arm": ARM_SIZES,
}

#: Sliding friction on forearms, dry to sweaty. Dry: 0.25 +- 0.05 sliding, 0.31 +- 0.07 at rest
#: (Temel et al. 2022). Sweat multiplies it by 1 to 1.7 on hairy forearms and by 2 to 5 on others
#: (Lyu et al. 2020).
FRICTION = (0.2, 1.0)

#: The gripper is off the armscye's top by up to this much in each coordinate [m]. Own choice.
GRASP_OFFSET = 0.015


#: How wrong the frames may be that a policy is told: standard deviation of the shoulder's place,
#: each coordinate [m], and of each of the arm's angles for each metre of that [rad/m]: half a
#: degree a millimetre. From exact to what a camera makes of an arm in a sleeve. Own choice.
FRAMES = 0.03
ANGLE_NOISE = float(np.deg2rad(500.0))


@dataclass(frozen=True, slots=True)
class Varied:
    """An episode's posture and world after variation.

    Attributes:
        posture: The arm, perhaps of another size.
        config: World, robot and rules.
        drawn: What was drawn or fixed, plain values by factor; `apply` makes the same world of it
            again.
    """

    posture: Posture
    config: EpisodeConfig
    drawn: Mapping[str, Any]


def vary(posture: Posture, config: EpisodeConfig, factors: Sequence[str], seed: int) -> Varied:
    """Draw or fix the factors asked for; the others stay as they are.

    A factor's name draws it: ``friction`` is log-uniform in `FRICTION`; ``fabric``, ``garment`` and
    ``arm`` are one of `FABRICS`, `GARMENTS` and `ARM_SIZES`, each as likely; ``grasp`` is uniform
    in a cube; ``frames``, the standard deviation of their noise, is uniform up to `FRAMES`. A
    garment brings its own fabric, with its friction, unless these are given too.
    ``NAME=VALUE`` fixes it in every episode, such as ``friction=0.6`` or ``arm=female_small``; all
    but ``grasp``.

    Args:
        posture: The arm to dress.
        config: The nominal world.
        factors: Some of `FACTORS`, or values of them, in any order: what is drawn for one depends
            on its name and the seed, not on the others.
        seed: Of the draws, a whole number.

    Raises:
        InvalidInputError: There is no such factor, or no such value of it.
    """
    asked = _asked(factors)
    values = {
        name: _drawn(name, seed) if asked[name] is None else asked[name]
        for name in FACTORS
        if name in asked
    }
    return apply(posture, config, values)


def _drawn(factor: str, seed: int) -> Any:
    """What a factor is for a seed, a plain value."""
    if factor in _NAMES:
        return _choice(_NAMES[factor], f"{seed}/{factor}")
    rng = np.random.default_rng(derived_seed(f"{seed}/{factor}"))
    if factor == "friction":
        return float(np.exp(rng.uniform(*np.log(FRICTION))))
    if factor == "frames":
        return float(rng.uniform(0.0, FRAMES))
    return [float(value) for value in rng.uniform(-GRASP_OFFSET, GRASP_OFFSET, 3)]


def _choice(names: Iterable[str], text: str) -> str:
    """One of the names, each as likely, by highest random weight (Thaler and Ravishankar 1998).

    Another name changes only the choices that fall on it.
    """
    return max(names, key=lambda name: hashlib.sha256(f"{text}/{name}".encode()).digest())


def check_factors(factors: Sequence[str]) -> None:
    """Refuse factors, or values of them, that do not exist.

    Raises:
        InvalidInputError: There is no such factor, no such value of it, or it is given twice.
    """
    _asked(factors)


def factor_names(factors: Sequence[str]) -> list[str]:
    """Names of the factors, whether drawn or fixed."""
    return [factor.partition("=")[0] for factor in factors]


def in_words(factors: Sequence[str]) -> str:
    """What is drawn and what is fixed: ``friction and arm varied, fabric=interlock``."""
    drawn = [factor for factor in factors if "=" not in factor]
    varied = [f"{' and '.join(drawn)} varied"] if drawn else []
    return ", ".join([*varied, *(factor for factor in factors if "=" in factor)])


def _asked(factors: Sequence[str]) -> dict[str, Any]:
    """The value of each factor, None if it is to be drawn."""
    asked: dict[str, Any] = {}
    for factor in factors:
        name, fixed, value = factor.partition("=")
        if name not in FACTORS:
            raise InvalidInputError(f"unknown factor {name!r}; valid is {', '.join(FACTORS)}")
        if name in asked:
            raise InvalidInputError(f"factor {name!r} is given twice; valid is once")
        asked[name] = _value(name, value) if fixed else None
    return asked


def _value(name: str, text: str) -> float | str:
    """A factor's value as it is written after its name."""
    if name in _NUMBERS:
        most, refuse = _NUMBERS[name]
        try:
            value = real_number(float(text), name, 0.0, most)
            refuse(value)
        except ValueError:
            raise InvalidInputError(
                f"{name} is {text!r}, valid is a number from 0 to {most:g}"
            ) from None
        return value
    if name not in _NAMES:
        raise InvalidInputError(f"{name} is {text!r}, valid is no value: it can only be drawn")
    one_of(text, name, _NAMES[name])
    return text


def apply(posture: Posture, config: EpisodeConfig, drawn: Mapping[str, Any]) -> Varied:
    """The posture and the world with these values, such as `Varied.drawn` holds.

    Raises:
        InvalidInputError: An unknown factor, fabric, garment or arm size.
    """
    check_factors(list(drawn))
    sleeve = config.world.sleeve
    garment = find_garment(drawn["garment"]) if "garment" in drawn else sleeve.garment
    if "fabric" in drawn:
        if drawn["fabric"] not in FABRICS:
            raise InvalidInputError(
                f"unknown fabric {drawn['fabric']!r}; valid is one of {', '.join(FABRICS)}"
            )
        garment = replace(garment, fabric=FABRICS[drawn["fabric"]])
    if "friction" in drawn:
        garment = replace(garment, fabric=replace(garment.fabric, friction=drawn["friction"]))
    offset = tuple(drawn.get("grasp", sleeve.grasp_offset))
    world = replace(config.world, sleeve=replace(sleeve, garment=garment, grasp_offset=offset))
    size = drawn.get("arm", posture.size)
    capture = _noisy(config.capture, drawn["frames"]) if "frames" in drawn else config.capture
    varied = replace(config, world=world, capture=capture)
    return Varied(replace(posture, size=size), varied, dict(drawn))


def _noisy(capture: CaptureConfig, noise: float) -> CaptureConfig:
    """An arm that is measured with noise of this standard deviation [m], though it be still.

    Noise of another size is the same noise, scaled: a posture's does not depend on what is drawn.
    """
    angles = ANGLE_NOISE * noise
    return replace(capture, still=True, position_noise=noise, angle_noise=angles)


#: Factors that are numbers, the largest that can be meant (own choice), and what refuses others.
_NUMBERS: Mapping[str, tuple[float, Callable[[float], object]]] = {
    "friction": (4.0, lambda value: Fabric(friction=value)),
    "frames": (1.0, lambda value: _noisy(CaptureConfig(), value)),
}
