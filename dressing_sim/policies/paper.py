"""The paper's dressing policies: what it says of them, and what it leaves open.

J. Zhu, M. Gienger and J. Kober, *Learning Task-Parameterized Skills from Few Demonstrations*, IEEE
Robotics and Automation Letters (2022), section VI.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Literal, get_args, get_type_hints

import numpy as np

from dressing_sim.checks import one_of
from dressing_sim.config import check_kinds, to_plain
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    AugmentOptions,
    BoundsSampler,
    DemonstrationLike,
    FusionOrder,
    Method,
    Policy,
    SituationSampler,
    TrajectoryTPGMM,
)
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.learning.phases import Alignment
from dressing_sim.policies.cleared import ClearPolicy
from dressing_sim.policies.hyperparameters import split_name
from dressing_sim.policies.situations import ArmPlanePolicy, ArmSampler, InArmPlane, in_arm_planes

FreeAxes = Literal["gravity", "arm-plane"]
Situations = Literal["frames", "arms"]

#: Hyper-parameters that the paper has values for; it leaves the others open.
GIVEN = ("n_components", "max_demonstrations", "max_iterations", "snr_db")

#: What is told of Algorithm 1 besides these; the rest of its options is the paper's text.
_OPTIONS = frozenset(GIVEN[1:])


@dataclass(frozen=True, slots=True)
class TPGMMConfig:
    """Hyper-parameters of the initial policy, learned from the expert's demonstrations alone.

    What the paper leaves open follows the authors' code where that has an answer; the rest was
    settled on the suite ``val50``, on no test posture.

    Raises:
        InvalidInputError: A value that no policy can have.
    """

    n_components: int = 4
    """K; the paper's."""
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
    aligned: bool = False
    """Whether demonstrations are brought onto one clock before the fit, synthetic ones too (see
    `dressing_sim.learning.phases`); not the paper's method."""
    clearance: bool = False
    """Whether the answer is kept as clear of the arm, phase by phase, as the demonstrations were
    (see `dressing_sim.policies.cleared`); Algorithm 1 does not know. Not the paper's method."""

    def __post_init__(self) -> None:
        check_kinds(self, "policy")
        for name, hint in get_type_hints(type(self)).items():
            if name == "fixed":
                continue
            value, valid = getattr(self, name), get_args(hint)
            if valid:
                one_of(value, name, valid)
            if hint in (int, float) and not 0.0 <= value < np.inf:  # NaN fails too
                raise InvalidInputError(f"{name} is {value}, valid is >= 0")

    def make(self, seed: int = 0) -> Policy:
        """A new policy, not yet fitted.

        Args:
            seed: Of the randomness of learning, of which the initial policy has none.
        """
        return self._outside(self._initial())

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
            alignment=Alignment() if self.aligned else None,
        )

    def _outside(self, policy: Policy) -> Policy:
        """The policy with what surrounds it."""
        seen = ArmPlanePolicy(policy) if self.free_axes == "arm-plane" else policy
        return ClearPolicy(seen) if self.clearance else seen


@dataclass(frozen=True, slots=True)
class AugmentedTPGMMConfig(TPGMMConfig):
    """Hyper-parameters of a policy that Algorithm 1 improves."""

    fixed: ClassVar[frozenset[str]] = frozenset({"method"})

    options: AugmentOptions = field(default_factory=AugmentOptions)
    """Of Algorithm 1; the method is what the policy's name says."""
    situations: Situations = "arms"
    """Random situations: each frame on its own within bounds, or both frames of a possible arm, as
    frames that satisfy "task constraints such as kinematic limits" are."""
    angle_margin_deg: float = 10.0
    """Random situations may be turned by this much more than the demonstrated ones [deg]."""
    translation_margin: float = 0.25
    """They may be shifted by this much more, as a fraction of the demonstrated range."""

    def __post_init__(self) -> None:
        TPGMMConfig.__post_init__(self)
        if self.options.max_demonstrations < 1:
            raise InvalidInputError(
                f"max_demonstrations is {self.options.max_demonstrations}, valid is 1 or more"
            )

    def make(self, seed: int = 0) -> Policy:
        """A new policy, not yet fitted.

        Args:
            seed: Of Algorithm 1.
        """
        return self._outside(self.augmented(seed))

    def augmented(self, seed: int = 0) -> AugmentedTPGMM:
        """A new policy for demonstrations in frames as `seen`."""
        return AugmentedTPGMM(
            self.options, seed=seed, policy=self._initial(), sampler=SamplerOf(self)
        )

    def seen(self, demonstrations: Sequence[DemonstrationLike]) -> list[DemonstrationLike]:
        """The demonstrations in the frames whose free axes were chosen."""
        return in_arm_planes(demonstrations) if self.free_axes == "arm-plane" else [*demonstrations]

    def with_method(self, method: Method) -> AugmentedTPGMMConfig:
        """The same with another way to make synthetic demonstrations."""
        return replace(self, options=replace(self.options, method=method))


@dataclass(frozen=True, slots=True)
class SamplerOf:
    """Makes the sampler of random situations that a configuration asks for."""

    config: AugmentedTPGMMConfig

    def __call__(self, demonstrations: Sequence[DemonstrationLike]) -> SituationSampler:
        """A sampler around the demonstrations' situations."""
        config = self.config
        kind = ArmSampler if config.situations == "arms" else BoundsSampler
        sampler: SituationSampler = kind.around(
            demonstrations, np.deg2rad(config.angle_margin_deg), config.translation_margin
        )
        if config.free_axes == "arm-plane" and config.situations == "arms":
            return InArmPlane(sampler)
        return sampler


#: The paper's policies; how Algorithm 1 makes synthetic demonstrations is in their names.
POLICIES: Mapping[str, TPGMMConfig] = {
    "tp-gmm": TPGMMConfig(),
    "tp-gmm-noise": AugmentedTPGMMConfig(options=AugmentOptions("noise")),
    "tp-gmm-rf": AugmentedTPGMMConfig(options=AugmentOptions("rf")),
    "tp-gmm-rf-noise": AugmentedTPGMMConfig(options=AugmentOptions("rf+noise")),
}

#: Those that Algorithm 1 makes, and how.
AUGMENTED: Mapping[str, Method] = {
    name: config.options.method
    for name, config in POLICIES.items()
    if isinstance(config, AugmentedTPGMMConfig)
}


def plain_config(config: AugmentedTPGMMConfig | None = None) -> dict[str, Any]:
    """Hyper-parameters of all the paper's policies as plain values, what the paper gives first.

    Args:
        config: What is not as by default.
    """
    values = to_plain(config or AugmentedTPGMMConfig())
    options = values.pop("options")
    values = {**values, **{name: options[name] for name in _OPTIONS}}
    return {name: values[name] for name in dict.fromkeys([*GIVEN, *values])}


def left_open() -> str:
    """What the paper leaves open: ``name=value, name=value``, each as after a policy's ``?``."""
    values = {name: value for name, value in plain_config().items() if name not in GIVEN}
    return ", ".join(f"{name}={str(value).lower()}" for name, value in values.items())


def any_of_the_paper(names: Iterable[str]) -> bool:
    """Whether a name, perhaps with hyper-parameters after it, is of a policy of the paper."""
    return any(split_name(name)[0] in POLICIES for name in names)
