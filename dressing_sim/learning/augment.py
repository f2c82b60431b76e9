"""Algorithm 1 of the paper: learning from few demonstrations and the synthetic ones that help.

Each iteration makes one synthetic demonstration, retrains with it, and keeps it where the cost on
the expert demonstrations falls (Zhu, Gienger and Kober 2022, Algorithm 1):

* ``"noise"``: an expert demonstration, drawn at random, with white noise;
* ``"rf"``: what the current policy does in a random new situation (random frames);
* ``"rf+noise"``: the same with white noise;
* ``"copies"``: an expert demonstration, drawn at random, as it is. This is not the paper's but a
  control: it adds no data, so that what it gains is expectation-maximisation going on, and
  experts' weights.
"""

from collections.abc import Callable, Sequence
from copy import deepcopy
from dataclasses import dataclass
from types import NoneType
from typing import Literal, Protocol, Self, get_args

import numpy as np

from dressing_sim.checks import (
    function_or_none,
    of_kind,
    one_of,
    real_number,
    shown,
    truth_value,
    whole_number,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    SyntheticDemonstration,
    check_demonstrations,
)
from dressing_sim.learning.frame import Frame
from dressing_sim.learning.noise import LARGEST_SNR_DB, NoiseReference, add_white_noise
from dressing_sim.learning.policy import Policy
from dressing_sim.learning.refinements import Refinable, grown, with_discarded
from dressing_sim.learning.sampling import BoundsSampler, SituationSampler
from dressing_sim.learning.trajectory import TrajectoryTPGMM

Method = Literal["noise", "rf", "rf+noise", "copies"]
METHODS: tuple[Method, ...] = get_args(Method)
Termination = Literal["first", "both"]
Retraining = Literal["warm", "cold"]

#: More iterations, and more demonstrations, are not meant.
MOST_ITERATIONS = 100_000

#: What Algorithm 1 calls of a policy.
_NEEDED = ("fit", "refit", "synthesise", "cost")

#: Those that make demonstrations of the experts' own situations.
_OF_EXPERTS = ("noise", "copies")

PRINTED_LOOP_LIMIT = 20  # times max_iterations, see ``termination``


class Augmentable(Policy, Protocol):
    """What Algorithm 1 needs of a policy beyond ``fit`` and ``generate``."""

    def refit(self, demonstrations: Sequence[DemonstrationLike], warm: bool = True) -> Self:
        """A new policy learned from other demonstrations, warm-started from this one or not."""

    def synthesise(self, frames: Sequence[Frame]) -> SyntheticDemonstration:
        """The motion for a new situation, from where it should start there."""

    def cost(self, demonstrations: Sequence[DemonstrationLike]) -> float:
        """Reproduction cost J: how far the policy is from these demonstrations."""


@dataclass(frozen=True, eq=False)
class Candidate:
    """One iteration of Algorithm 1.

    Attributes:
        iteration: counted from 1.
        demonstration: the synthetic demonstration that was tried; None where making it failed.
        cost: cost after retraining with it; infinite where that failed.
        accepted: whether the cost fell, and the demonstration stayed.
        n_demonstrations: number of demonstrations in the training set after the decision.
        policy: the policy retrained with it, where it was accepted.
        fault: why making it or retraining with it failed, where that was so.
    """

    iteration: int
    demonstration: SyntheticDemonstration | None
    cost: float
    accepted: bool
    n_demonstrations: int
    policy: Augmentable | None = None
    fault: str | None = None


@dataclass(frozen=True, eq=False)
class Augmentation:
    """What Algorithm 1 gives back.

    Attributes:
        initial_policy: learned from the expert demonstrations alone.
        initial_cost: its cost by the criterion of selection.
        policy: the final policy.
        cost: its cost by the criterion of selection.
        demonstrations: the final training set, the expert demonstrations first.
        history: every candidate, in order.
    """

    initial_policy: Augmentable
    initial_cost: float
    policy: Augmentable
    cost: float
    demonstrations: tuple[DemonstrationLike, ...]
    history: tuple[Candidate, ...]

    @property
    def accepted(self) -> tuple[Candidate, ...]:
        """The candidates that were kept."""
        return tuple(candidate for candidate in self.history if candidate.accepted)


@dataclass(frozen=True, slots=True)
class AugmentOptions:
    """The choices of Algorithm 1.

    Raises:
        InvalidInputError: a choice that there is not, or a number out of range.
    """

    method: Method = "rf"
    """How synthetic demonstrations are made."""
    max_demonstrations: int = 7
    """M, expert and synthetic ones together, at which the loop may end."""
    max_iterations: int = 100
    """L, the number of candidates at which the loop may end."""
    snr_db: float = 30.0
    """Signal-to-noise ratio of the white noise in [dB]."""
    noise_reference: NoiseReference = "centred"
    """The signal that the ratio refers to, see ``noise_deviation``."""
    termination: Termination = "first"
    """``"first"`` ends at M or at L, whichever comes first (the paper's text and the authors'
    code). ``"both"`` ends once both are reached, which is nearly what Algorithm 1 prints (there the
    loop goes on at ``n_d <= M``, one demonstration further); it gives up after 20 L iterations, for
    nothing else would end it where no candidate is accepted."""
    retrain: Retraining = "warm"
    """``"warm"`` starts expectation-maximisation from the current model, ``"cold"`` from its
    initialisation."""
    grow: bool = False
    """Whether one component more is tried for every demonstration that is kept, see
    ``refinements``; not in the paper."""
    discarded: float = 0.0
    """What the demonstrations that were not kept count in the end, as a fraction of those that
    were, see ``refinements``; 0 leaves them out, as the paper does."""

    def __post_init__(self) -> None:
        choices = (
            ("method", self.method, METHODS),
            ("noise_reference", self.noise_reference, get_args(NoiseReference)),
            ("termination", self.termination, get_args(Termination)),
            ("retrain", self.retrain, get_args(Retraining)),
        )
        for name, value, valid in choices:
            one_of(value, name, valid)
        truth_value(self.grow, "grow")
        real_number(self.discarded, "discarded", 0.0, 100.0)
        for name in ("max_iterations", "max_demonstrations"):
            whole_number(getattr(self, name), name, 0, MOST_ITERATIONS)
        real_number(self.snr_db, "snr_db", -LARGEST_SNR_DB, LARGEST_SNR_DB)

    def goes_on(self, n_demonstrations: int, iteration: int) -> bool:
        """Whether the loop has another iteration with so many demonstrations and candidates."""
        if self.termination == "first":
            return n_demonstrations < self.max_demonstrations and iteration < self.max_iterations
        if iteration >= PRINTED_LOOP_LIMIT * self.max_iterations:
            return False
        return n_demonstrations < self.max_demonstrations or iteration < self.max_iterations


def augment(
    demonstrations: Sequence[DemonstrationLike],
    *,
    rng: np.random.Generator,
    options: AugmentOptions | None = None,
    policy: Augmentable | None = None,
    sampler: SituationSampler | None = None,
    validation: Sequence[DemonstrationLike] | None = None,
    on_iteration: Callable[[Candidate], None] | None = None,
) -> Augmentation:
    """Run Algorithm 1.

    Args:
        demonstrations: the expert ones; the paper asks for two at least.
        rng: where all randomness comes from; the same state gives the same result, bit for bit.
        options: the choices of a run; ``AugmentOptions()`` by default.
        policy: what is learned; it is copied, not changed. ``TrajectoryTPGMM()`` by default.
        sampler: draws the new situations; by default ``BoundsSampler.around(demonstrations)``.
        validation: with None, the cost is that on the expert demonstrations (the paper's original
            selection); with demonstrations of their own, the cost is that on them (generalisation
            selection).
        on_iteration: called with each candidate as it is decided, for progress.

    Raises:
        InvalidInputError: demonstrations that cannot be learned from.
    """
    _check_arguments(rng, options, policy, sampler, on_iteration)
    options = options or AugmentOptions()
    experts = check_demonstrations(demonstrations)
    criterion = experts if validation is None else check_demonstrations(validation)
    if sampler is None and options.method not in _OF_EXPERTS:
        sampler = BoundsSampler.around(experts)
    initial = deepcopy(policy) if policy is not None else TrajectoryTPGMM()
    if (options.grow or options.discarded > 0.0) and not isinstance(initial, Refinable):
        raise InvalidInputError(
            f"policy is {shown(policy)}, valid for grow and discarded is one with larger too"
        )
    current: Augmentable = initial.fit(experts)
    cost = initial_cost = current.cost(criterion)
    training: tuple[DemonstrationLike, ...] = experts
    history: list[Candidate] = []
    while options.goes_on(len(training), len(history)):
        synthetic: SyntheticDemonstration | None = None
        retrained, new_cost, fault = current, np.inf, None
        try:
            synthetic = _synthetic(experts, current, sampler, options, rng)
            retrained = current.refit((*training, synthetic), warm=options.retrain == "warm")
            new_cost = retrained.cost(criterion)
        except InvalidInputError as error:
            fault = str(error)
        accepted = bool(new_cost < cost)
        if accepted:
            assert synthetic is not None
            training = *training, synthetic
            if options.grow and isinstance(retrained, Refinable):
                retrained, new_cost = grown(retrained, new_cost, training, criterion)
            current, cost = retrained, new_cost
        candidate = Candidate(
            iteration=len(history) + 1,
            demonstration=synthetic,
            cost=new_cost,
            accepted=accepted,
            n_demonstrations=len(training),
            policy=retrained if accepted else None,
            fault=fault,
        )
        history.append(candidate)
        if on_iteration is not None:
            on_iteration(candidate)
    if options.discarded > 0.0 and isinstance(current, Refinable):
        others = [
            (one.demonstration, one.cost)
            for one in history
            if one.demonstration is not None and not one.accepted and np.isfinite(one.cost)
        ]
        current, cost = with_discarded(
            current, cost, training, others, options.discarded, criterion
        )
    return Augmentation(initial, initial_cost, current, cost, training, tuple(history))


def _check_arguments(
    rng: object, options: object, policy: object, sampler: object, on_iteration: object
) -> None:
    """Raise InvalidInputError unless the arguments of `augment` are of the right kinds."""
    of_kind(rng, np.random.Generator, "rng", "a random generator of numpy's")
    of_kind(options, (AugmentOptions, NoneType), "options", "AugmentOptions or None")
    if not all(callable(getattr(policy, name, None)) for name in _NEEDED if policy is not None):
        raise InvalidInputError(
            f"policy is {shown(policy)}, valid is None or something with {', '.join(_NEEDED)}"
        )
    of_kind(sampler, (SituationSampler, NoneType), "sampler", "something with sample, or None")
    function_or_none(on_iteration, "on_iteration")


def _synthetic(
    experts: Sequence[DemonstrationLike],
    policy: Augmentable,
    sampler: SituationSampler | None,
    options: AugmentOptions,
    rng: np.random.Generator,
) -> SyntheticDemonstration:
    """One synthetic demonstration, by the method of the options."""
    if options.method in _OF_EXPERTS:
        expert = experts[int(rng.integers(len(experts)))]
        made = SyntheticDemonstration(np.asarray(expert.positions), expert.dt, expert.frames)
    else:
        assert sampler is not None
        made = policy.synthesise(sampler.sample(rng))
    if options.method in ("rf", "copies"):
        return made
    noisy = add_white_noise(made.positions, options.snr_db, rng, options.noise_reference)
    return SyntheticDemonstration(noisy, made.dt, made.frames)
