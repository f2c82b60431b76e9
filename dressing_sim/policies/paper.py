"""The paper's dressing policies: what it says of them, and what it leaves open.

J. Zhu, M. Gienger and J. Kober, *Learning Task-Parameterized Skills from Few Demonstrations*, IEEE
Robotics and Automation Letters (2022), section VI.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Literal, get_args, get_type_hints

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    BoundsSampler,
    DemonstrationLike,
    FusionOrder,
    Method,
    Policy,
    SituationSampler,
    TrajectoryTPGMM,
)
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.policies.situations import ArmPlanePolicy, ArmSampler, InArmPlane, in_arm_planes

FreeAxes = Literal["gravity", "arm-plane"]
Situations = Literal["frames", "arms"]

#: Settings that the paper has values for; it leaves the others open.
GIVEN = frozenset({"n_components", "max_demonstrations", "max_iterations", "snr_db"})


@dataclass(frozen=True, slots=True)
class PaperSettings:
    """Settings of all built-in policies, the same for every row of a table.

    What the paper leaves open follows the authors' code where that has an answer; the rest was
    settled on the suite ``val50``, on no test posture.
    """

    n_components: int = 4
    """K; the paper's."""
    max_demonstrations: int = 7
    """M; the paper's."""
    max_iterations: int = 100
    """L; the paper's."""
    snr_db: float = 30.0
    """Of the white noise [dB]; the paper's."""
    fusion: FusionOrder = "regression-then-product"
    """The paper's text and the authors' code differ; see ``docs/learning.md``."""
    position_floor: float = 1e-4
    """Added to the positions' variance: the value of the authors' code. Not in the paper, as all
    that follows."""
    displacement_floor: float = 1e-4
    """Added to the displacements' variance: the value of the authors' code. How displacements are
    scaled against positions matters through the floors alone: the rest does not depend on units."""
    relative_floor: bool = False
    """Whether floors are fractions of the data's variance in each frame, or in [m^2]."""
    samples: int = 200
    """In a demonstration of mean duration, resampled; it sets the time a displacement spans."""
    shrinkage: bool = False
    """Whether covariances are shrunk for few demonstrations; not the paper's method."""
    end_radius: float = 0.2
    """How far from the predicted end a motion may end, as a fraction of the demonstrated length;
    with 0 it ends at rest only, and creeps past the shoulder."""
    free_axes: FreeAxes = "gravity"
    """What the frames' z axes follow: up, or the normal of the arm's plane."""
    situations: Situations = "arms"
    """Random situations: each frame on its own within bounds, or both frames of a possible arm, as
    frames that satisfy "task constraints such as kinematic limits" are."""
    angle_margin_deg: float = 10.0
    """Random situations may be turned by this much more than the demonstrated ones [deg]."""
    translation_margin: float = 0.25
    """They may be shifted by this much more, as a fraction of the demonstrated range."""

    def __post_init__(self) -> None:
        for name, hint in get_type_hints(PaperSettings).items():
            value, valid = getattr(self, name), get_args(hint)
            if valid and value not in valid:
                raise InvalidInputError(f"{name} is {value!r}, valid is one of {', '.join(valid)}")
            if hint is float and not (np.isfinite(value) and value >= 0.0):
                raise InvalidInputError(f"{name} is {value}, valid is >= 0")
            if hint is int and value < 0:
                raise InvalidInputError(f"{name} is {value}, valid is >= 0")

    @property
    def left_open(self) -> str:
        """What the paper leaves open: ``name=value, name=value``, each as `settings_from_text`."""
        values = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in GIVEN}
        return ", ".join(f"{name}={str(value).lower()}" for name, value in values.items())

    def policy(self, method: Method | None = None, seed: int = 0) -> Policy:
        """A new policy: of the expert's demonstrations alone, or improved by Algorithm 1.

        Args:
            method: How synthetic demonstrations are made; None for the initial policy.
            seed: Of Algorithm 1.

        Raises:
            InvalidInputError: Settings that no policy can have.
        """
        policy: Policy = self._initial() if method is None else self.augmented(method, seed)
        return ArmPlanePolicy(policy) if self.free_axes == "arm-plane" else policy

    def augmented(self, method: Method, seed: int = 0) -> AugmentedTPGMM:
        """A new policy that Algorithm 1 improves, for demonstrations in frames as `seen`."""
        return AugmentedTPGMM(
            method,
            seed=seed,
            policy=self._initial(),
            sampler=SamplerOf(self),
            max_demonstrations=self.max_demonstrations,
            max_iterations=self.max_iterations,
            snr_db=self.snr_db,
        )

    def seen(self, demonstrations: Sequence[DemonstrationLike]) -> list[DemonstrationLike]:
        """The demonstrations in the frames whose free axes the settings choose."""
        return in_arm_planes(demonstrations) if self.free_axes == "arm-plane" else [*demonstrations]

    def _initial(self) -> TrajectoryTPGMM:
        return TrajectoryTPGMM(
            self.n_components,
            fusion=self.fusion,
            position_floor=self.position_floor,
            displacement_floor=self.displacement_floor,
            relative_floor=self.relative_floor,
            samples=self.samples,
            shrinkage=self.shrinkage,
            end_radius=self.end_radius,
        )


@dataclass(frozen=True, slots=True)
class SamplerOf:
    """Makes the sampler of random situations that the settings ask for."""

    settings: PaperSettings

    def __call__(self, demonstrations: Sequence[DemonstrationLike]) -> SituationSampler:
        """A sampler around the demonstrations' situations."""
        settings = self.settings
        kind = ArmSampler if settings.situations == "arms" else BoundsSampler
        sampler: SituationSampler = kind.around(
            demonstrations, np.deg2rad(settings.angle_margin_deg), settings.translation_margin
        )
        if settings.free_axes == "arm-plane" and settings.situations == "arms":
            return InArmPlane(sampler)
        return sampler


def split_settings(policy: str) -> tuple[str, str | None]:
    """A policy's name, and the text of the settings after its ``?``; None if there is none."""
    name, mark, text = policy.partition("?")
    return name, text if mark else None


def settings_from_text(text: str) -> PaperSettings:
    """Settings from ``name=value&name=value``; what is not named keeps its default.

    Raises:
        InvalidInputError: An unknown or repeated name, or a value of the wrong kind.
    """
    hints = get_type_hints(PaperSettings)
    values: dict[str, object] = {}
    for part in text.split("&"):
        name, equals, value = part.partition("=")
        if not equals:
            raise InvalidInputError(f"{part!r} is no setting; valid is name=value&name=value")
        if name not in hints:
            raise InvalidInputError(f"unknown setting {name!r}; valid is one of {', '.join(hints)}")
        if name in values:
            raise InvalidInputError(f"setting {name} is given twice")
        values[name] = _value(name, value, hints[name])
    return PaperSettings(**values)  # type: ignore[arg-type]  # converted to the fields' types


def _value(name: str, text: str, hint: object) -> object:
    if hint is bool:
        if text not in ("true", "false"):
            raise InvalidInputError(f"{name} is {text!r}, valid is true or false")
        return text == "true"
    if hint is int or hint is float:
        try:
            return hint(text)
        except ValueError as error:
            kind = "a whole number" if hint is int else "a number"
            raise InvalidInputError(f"{name} is {text!r}, valid is {kind}") from error
    return text
