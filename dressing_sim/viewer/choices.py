"""What a user of the page has chosen: an arm, what is put on it, and who dresses it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from dressing_sim.arm import ANGLE_LIMITS_DEG, ARM_SIZES, Posture
from dressing_sim.checks import one_of, real_number, whole_number
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.policies.expert import EXPERT
from dressing_sim.policies.paper import AUGMENTED
from dressing_sim.policies.registry import DEFAULT, built_in
from dressing_sim.suites.suites import find_posture, load_suite
from dressing_sim.suites.wardrobe import world_with
from dressing_sim.world.garment import GARMENTS

#: The policy that Algorithm 1 may improve.
PLAIN = "tp-gmm"

#: How it may, by what the page calls it.
AUGMENTATIONS: Mapping[str, str] = {
    "none": PLAIN,
    **{method: name for name, method in AUGMENTED.items()},
}

#: Suites that policies can learn from, and the user's own takes.
TAKES = "my takes"
SUITES = ("case_a", "case_b", "baseline7")

#: Arms to teach and to try, in this order: two that differ, then others.
TAUGHT = (*load_suite("case_a"), *load_suite("paper5"))

#: Friction that can be chosen: of silk, to more than sweaty skin.
FRICTION = (0.05, 1.5)

#: A dragged joint is worth so many metres for each degree that the angles change.
_EASE = 1e-4


def policies() -> tuple[str, ...]:
    """Names of the policies, the default one first; augmentation is asked for apart."""
    others = [name for name in built_in() if name not in AUGMENTED]
    return tuple(dict.fromkeys([DEFAULT, PLAIN, EXPERT, *others]))


@dataclass(frozen=True)
class Choices:
    """What is dressed, with what, by whom.

    Attributes:
        posture: The arm.
        garment: One of `GARMENTS`.
        friction: Sliding friction of cloth on skin; None for the garment's own.
        policy: One of `policies`.
        augmentation: One of `AUGMENTATIONS`; it matters to the policy `PLAIN` alone.
        demonstrations: What the policy learns from: one of `SUITES`, or `TAKES`.
        seed: Of an episode, as of ``dressing-sim dress``.

    Raises:
        InvalidInputError: Something that cannot be chosen.
    """

    posture: Posture = field(default_factory=lambda: find_posture("bent40"))
    garment: str = "tshirt-m"
    friction: float | None = None
    policy: str = DEFAULT
    augmentation: str = "none"
    demonstrations: str = SUITES[0]
    seed: int = 0

    def __post_init__(self) -> None:
        one_of(self.garment, "garment", GARMENTS)
        one_of(self.policy, "policy", policies())
        one_of(self.augmentation, "augmentation", AUGMENTATIONS)
        one_of(self.demonstrations, "demonstrations", (*SUITES, TAKES))
        if self.friction is not None:
            real_number(self.friction, "friction", *FRICTION)
        whole_number(self.seed, "seed", 0, 2**63 - 1)

    @property
    def policy_name(self) -> str:
        """The policy as the command line calls it."""
        return AUGMENTATIONS[self.augmentation] if self.policy == PLAIN else self.policy

    @property
    def own_friction(self) -> float:
        """The friction that is chosen, or the garment's own."""
        return GARMENTS[self.garment].fabric.friction if self.friction is None else self.friction

    def nominal(self) -> EpisodeConfig:
        """The world that demonstrations are recorded in: the garment with its own friction."""
        return world_with(self.garment)

    def config(self) -> EpisodeConfig:
        """The world of an episode."""
        config = self.nominal()
        if self.friction is None:
            return config
        sleeve = config.world.sleeve
        fabric = replace(sleeve.garment.fabric, friction=self.friction)
        sleeve = replace(sleeve, garment=replace(sleeve.garment, fabric=fabric))
        return replace(config, world=replace(config.world, sleeve=sleeve))

    def bent(self, **angles_deg: float) -> Choices:
        """The same with other angles, kept within anatomical limits; the posture gets no name."""
        kept = {}
        for name, value in angles_deg.items():
            low, high = ANGLE_LIMITS_DEG[name]
            kept[name] = float(np.clip(real_number(value, name), low, high))
        angles = {name: getattr(self.posture, name) for name in ANGLE_LIMITS_DEG} | kept
        if angles == {name: getattr(self.posture, name) for name in ANGLE_LIMITS_DEG}:
            return self
        name = ",".join(f"{value:g}" for value in angles.values())
        return replace(self, posture=replace(self.posture, name=name, **angles))

    def sized(self, size: str) -> Choices:
        """The same with an arm of `ARM_SIZES`."""
        one_of(size, "size", ARM_SIZES)
        return replace(self, posture=replace(self.posture, size=size))

    def dragged(self, joint: str, place: NDArray[np.float64]) -> Choices:
        """The same with the elbow or the wrist as near to a place as the arm's angles allow.

        Of the angles that reach it, those that change least: a damped least-squares fit.

        Args:
            joint: ``"elbow"`` or ``"wrist"``.
            place: Where it was dragged to, (3,), in the robot's base frame [m].
        """
        one_of(joint, "joint", ("elbow", "wrist"))
        names = ["flexion_deg", "abduction_deg"]
        names += ["rotation_deg", "elbow_deg"] if joint == "wrist" else []
        before = np.array([getattr(self.posture, name) for name in names])
        low, high = np.transpose([ANGLE_LIMITS_DEG[name] for name in names])

        def off(angles: NDArray[np.float64]) -> NDArray[np.float64]:
            bent = replace(self.posture, **dict(zip(names, angles.tolist(), strict=True)))
            return np.concatenate([getattr(bent, joint) - place, _EASE * (angles - before)])

        inside = np.clip(before, low + 1e-6, high - 1e-6)
        found = least_squares(off, inside, bounds=(low, high), x_scale=30.0, max_nfev=20)
        return self.bent(**dict(zip(names, np.round(found.x, 1).tolist(), strict=True)))
