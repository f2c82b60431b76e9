"""The policy that Algorithm 1 ends with, as a policy like any other."""

from collections.abc import Callable, Sequence
from copy import deepcopy
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.augment import METHODS, Augmentation, Method, augment
from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.noise import NoiseReference
from dressing_sim.learning.sampling import BoundsSampler, SituationSampler
from dressing_sim.learning.trajectory import TrajectoryTPGMM

#: Makes the source of random situations from the expert demonstrations.
SamplerFactory = Callable[[Sequence[DemonstrationLike]], SituationSampler]

_SETTINGS = ("method", "seed", "max_demonstrations", "max_iterations", "snr_db", "noise_reference")
_LEARNED = ("costs", "tried")


class AugmentedTPGMM:
    """Trajectory-based TP-GMM that Algorithm 1 improves with synthetic demonstrations when fitted.

    Args:
        method: how synthetic demonstrations are made, see ``augment``.
        seed: of all randomness of a fit; two fits to the same demonstrations are the same.
        policy: settings of the policy that is improved; it is copied, and every fit starts from
            it. ``TrajectoryTPGMM()`` by default.
        sampler: makes the sampler of new situations; ``BoundsSampler.around`` by default.
        max_demonstrations: M, expert and synthetic demonstrations together.
        max_iterations: L, candidates that are tried.
        snr_db: signal-to-noise ratio of white noise in [dB].
        noise_reference: the signal that the ratio refers to, see ``noise_deviation``.

    Attributes:
        policy: the improved policy once fitted; before, a copy of what was given. To change what
            a fit starts from, make another ``AugmentedTPGMM``.
        costs: the cost with 0, 1, 2, ... synthetic demonstrations accepted, once fitted.
        tried: the number of candidates tried until each of these was accepted, 0 for the first.

    Raises:
        InvalidInputError: an unknown method, or a policy of another kind.
    """

    def __init__(
        self,
        method: Method = "rf",
        *,
        seed: int = 0,
        policy: TrajectoryTPGMM | None = None,
        sampler: SamplerFactory = BoundsSampler.around,
        max_demonstrations: int = 7,
        max_iterations: int = 100,
        snr_db: float = 30.0,
        noise_reference: NoiseReference = "centred",
    ) -> None:
        if method not in METHODS:
            raise InvalidInputError(f"method must be one of {', '.join(METHODS)}, not {method!r}")
        self.method = method
        self.seed = seed
        if not isinstance(policy, TrajectoryTPGMM | None):
            raise InvalidInputError(
                f"policy is a {type(policy).__name__}, valid is a TrajectoryTPGMM or None"
            )
        self.policy = deepcopy(policy) if policy is not None else TrajectoryTPGMM()
        self._initial = deepcopy(self.policy)
        self.sampler = sampler
        self.max_demonstrations = max_demonstrations
        self.max_iterations = max_iterations
        self.snr_db = snr_db
        self.noise_reference = noise_reference
        self.costs: tuple[float, ...] = ()
        self.tried: tuple[int, ...] = ()

    @property
    def dt(self) -> float | None:
        """Time between the samples of a generated path in [s], once fitted."""
        return self.policy.dt

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Learn from the expert demonstrations and improve with synthetic ones.

        Raises:
            InvalidInputError: a setting out of range, or demonstrations that cannot be learned
                from.
        """
        result = self.augment(demonstrations)
        assert isinstance(result.policy, TrajectoryTPGMM)
        self.policy = result.policy
        self.costs = (result.initial_cost, *(candidate.cost for candidate in result.accepted))
        self.tried = (0, *(candidate.iteration for candidate in result.accepted))
        return self

    def augment(self, demonstrations: Sequence[DemonstrationLike]) -> Augmentation:
        """Run Algorithm 1 with these settings and keep nothing: for its whole history."""
        return augment(
            demonstrations,
            rng=np.random.default_rng(self.seed),
            method=self.method,
            policy=self._initial,
            sampler=None if self.method == "noise" else self.sampler(demonstrations),
            max_demonstrations=self.max_demonstrations,
            max_iterations=self.max_iterations,
            snr_db=self.snr_db,
            noise_reference=self.noise_reference,
        )

    def generate(self, frames: Sequence[Frame], start: ArrayLike) -> FloatArray:
        """The improved policy's motion (T, p) for a situation, see ``TrajectoryTPGMM.generate``."""
        return self.policy.generate(frames, start)

    def state(self) -> tuple[dict[str, Any], dict[str, FloatArray]]:
        """Settings and arrays for ``storage``; without the sampler, which only ``fit`` needs."""
        policy, arrays = self.policy.state()
        settings = {
            "policy": policy,
            "settings": {name: getattr(self, name) for name in _SETTINGS},
            "learned": {name: list(getattr(self, name)) for name in _LEARNED},
        }
        return settings, arrays

    @classmethod
    def from_state(cls, settings: dict[str, Any], arrays: dict[str, FloatArray]) -> Self:
        """The policy that ``state`` came from."""
        policy = TrajectoryTPGMM.from_state(settings["policy"], arrays)
        augmented = cls(policy=policy, **{name: settings["settings"][name] for name in _SETTINGS})
        for name in _LEARNED:
            setattr(augmented, name, tuple(settings["learned"][name]))
        return augmented
