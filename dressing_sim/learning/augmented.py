"""The policy that Algorithm 1 ends with, as a policy like any other."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import asdict, fields
from types import NoneType
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import of_kind, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.augment import Augmentation, AugmentOptions, augment
from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.motion import Motion
from dressing_sim.learning.sampling import BoundsSampler, SituationSampler
from dressing_sim.learning.trajectory import TrajectoryTPGMM

#: Makes the source of random situations from the expert demonstrations.
SamplerFactory = Callable[[Sequence[DemonstrationLike]], SituationSampler]

#: Options that files did not hold at first; they were as by default.
_LATER = frozenset({"termination", "retrain", "grow", "discarded"})
_LEARNED = ("costs", "tried")


class AugmentedTPGMM:
    """Trajectory-based TP-GMM that Algorithm 1 improves with synthetic demonstrations when fitted.

    Args:
        options: the choices of Algorithm 1; ``AugmentOptions()`` by default.
        seed: of all randomness of a fit; two fits to the same demonstrations are the same.
        policy: the policy that is improved; it is copied, and every fit starts from
            it. ``TrajectoryTPGMM()`` by default.
        sampler: makes the sampler of new situations; ``BoundsSampler.around`` by default.

    Attributes:
        policy: the improved policy once fitted; before, a copy of what was given. To change what
            a fit starts from, make another ``AugmentedTPGMM``.
        costs: the cost with 0, 1, 2, ... synthetic demonstrations accepted, once fitted.
        tried: the number of candidates tried until each of these was accepted, 0 for the first.

    Raises:
        InvalidInputError: a policy of another kind.
    """

    def __init__(
        self,
        options: AugmentOptions | None = None,
        *,
        seed: int = 0,
        policy: TrajectoryTPGMM | None = None,
        sampler: SamplerFactory = BoundsSampler.around,
    ) -> None:
        of_kind(options, (AugmentOptions, NoneType), "options", "AugmentOptions or None")
        whole_number(seed, "seed")
        self.options = options or AugmentOptions()
        self.seed = seed
        if not isinstance(policy, TrajectoryTPGMM | None):
            raise InvalidInputError(
                f"policy is a {type(policy).__name__}, valid is a TrajectoryTPGMM or None"
            )
        self.policy = deepcopy(policy) if policy is not None else TrajectoryTPGMM()
        self._initial = deepcopy(self.policy)
        self.sampler = sampler
        self.costs: tuple[float, ...] = ()
        self.tried: tuple[int, ...] = ()

    @property
    def dt(self) -> float | None:
        """Time between the samples of a generated path in [s], once fitted."""
        return self.policy.dt

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from the expert demonstrations and improve with synthetic ones.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from.
        """
        result = self.augment(demonstrations)
        assert isinstance(result.policy, TrajectoryTPGMM)
        self.policy = result.policy
        self.costs = (result.initial_cost, *(candidate.cost for candidate in result.accepted))
        self.tried = (0, *(candidate.iteration for candidate in result.accepted))
        return self

    def augment(self, demonstrations: Sequence[DemonstrationLike]) -> Augmentation:
        """Run Algorithm 1 with these options and keep nothing: for its whole history."""
        return augment(
            demonstrations,
            rng=np.random.default_rng(self.seed),
            options=self.options,
            policy=self._initial,
            sampler=self.sampler(demonstrations) if self.options.method.startswith("rf") else None,
        )

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> FloatArray:
        """The improved policy's motion (T, p) for a situation, see ``TrajectoryTPGMM.generate``."""
        return self.policy.generate(frames, start)

    def motion(self, frames: Sequence[Frame], start: ArrayLike) -> Motion:
        """The improved policy's motion with why it ended, see ``TrajectoryTPGMM.motion``."""
        return self.policy.motion(frames, start)

    def log_density(self, frames: Sequence[Frame], points: ArrayLike) -> FloatArray:
        """How sure the improved policy is at positions, see ``TrajectoryTPGMM.log_density``."""
        return self.policy.log_density(frames, points)

    def sample(
        self,
        frames: Sequence[Frame],
        start: ArrayLike,
        rng: np.random.Generator,
        count: int = 1,
    ) -> FloatArray:
        """Paths drawn from the improved policy, see ``TrajectoryTPGMM.sample``."""
        return self.policy.sample(frames, start, rng, count)

    def state(self) -> tuple[dict[str, Any], dict[str, FloatArray]]:
        """Settings and arrays for ``storage``; without the sampler, which only ``fit`` needs."""
        policy, arrays = self.policy.state()
        settings = {
            "policy": policy,
            "settings": {**asdict(self.options), "seed": self.seed},
            "learned": {name: list(getattr(self, name)) for name in _LEARNED},
        }
        return settings, arrays

    @classmethod
    def from_state(cls, settings: dict[str, Any], arrays: dict[str, FloatArray]) -> Self:
        """The policy that ``state`` came from."""
        policy = TrajectoryTPGMM.from_state(settings["policy"], arrays)
        kept = settings["settings"]
        names = [f.name for f in fields(AugmentOptions) if f.name in kept or f.name not in _LATER]
        options = AugmentOptions(**{name: kept[name] for name in names})
        augmented = cls(options, seed=kept["seed"], policy=policy)
        for name in _LEARNED:
            setattr(augmented, name, tuple(settings["learned"][name]))
        return augmented
