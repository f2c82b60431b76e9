"""Policies that cost no more than their own episodes, whatever they do."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path as File
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.arm import Posture
from dressing_sim.errors import Abstained, PolicyError
from dressing_sim.inputs import fit
from dressing_sim.learning import DemonstrationLike, Policy, Situation
from dressing_sim.learning.policy import Inputs
from dressing_sim.path import Path, checked_path, reset_policy, seed_argument
from dressing_sim.policies.host import START, Host, PolicyLimits, described_error
from dressing_sim.policies.hyperparameters import split_name
from dressing_sim.policies.registry import built_in, known_name, make_policy

T = TypeVar("T")


@lru_cache(maxsize=1)
def _host(limits: PolicyLimits, log: File | None) -> Host:
    """The process that answers for this one."""
    return Host(limits, log)


@dataclass(frozen=True)
class Hosted:
    """A policy of other people, which lives in a process of its own.

    Attributes:
        name: As it was asked for, with its hyper-parameters.
        seed: Of the randomness of learning.
        inputs: Its class of inputs.
        stream: Name of its own randomness.
        limits: What it may use.
        log: File for what it prints.
        dt: Time between two samples of its path, once it has learned, if it says so [s].
        fitted: What it has learned.
    """

    name: str
    seed: int
    inputs: Inputs
    stream: str
    limits: PolicyLimits
    log: File | None = None
    dt: float | None = None
    fitted: bytes | None = None

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Hosted:
        """Another one, which has learned.

        Raises:
            PolicyError: It raised, took too long, or ended its process.
        """
        arguments = self.name, self.seed, list(demonstrations)
        fitted, dt = self._host().ask(self.limits.fit_time, "fit", *arguments)
        return replace(self, fitted=fitted, dt=dt)

    def generate(self, frames: Situation | Posture, start: ArrayLike, seed: int = 0) -> Path:
        """A path for a situation.

        Raises:
            PolicyError: It raised, took too long, ended its process, or made no path.
        """
        arguments = self.fitted, frames, start, seed
        return Path(*self._host().ask(self.limits.generate_time, "generate", *arguments))

    def _host(self) -> Host:
        return _host(self.limits, self.log)


class HostedActor(Hosted):
    """The same of a policy in closed loop."""

    def reset(self, seed: int = 0) -> None:
        """Begin an episode."""
        self._host().ask(self.limits.fit_time, "begin", self.fitted, seed)

    def act(self, observation: Any) -> NDArray[np.float64] | None:
        """The next target (3,) [m], or None at the end."""
        target: NDArray[np.float64] | None = self._host().ask(
            self.limits.generate_time, "act", observation
        )
        return target


class Guarded:
    """A policy of this package, whose errors are told as those of any other policy.

    Args:
        name: As it was asked for.
        policy: It answers in this process.

    Attributes:
        policy: What answers, once fitted what has learned.
    """

    def __init__(self, name: str, policy: Any) -> None:
        self.name = name
        self.policy = policy
        self.inputs = getattr(policy, "inputs", "frames")
        self.stream = getattr(policy, "stream", type(policy).__qualname__)

    @property
    def dt(self) -> float | None:
        """Time between two samples of its path, if it says so [s]."""
        return getattr(self.policy, "dt", None)

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Guarded:
        """Learn, and return the policy itself."""
        self.policy = _answered(lambda: fit(self.policy, demonstrations))
        return self

    def generate(self, frames: Situation | Posture, start: ArrayLike, seed: int = 0) -> Path:
        """A path for a situation."""
        drawn = seed_argument(self.policy.generate, seed)
        generate = self.policy.generate
        return _answered(lambda: checked_path(generate(frames, start, **drawn), "the policy"))


class GuardedActor(Guarded):
    """The same of a policy in closed loop."""

    def reset(self, seed: int = 0) -> None:
        """Begin an episode."""
        _answered(lambda: reset_policy(self.policy, seed))

    def act(self, observation: Any) -> Any:
        """The next target (3,) [m], or None at the end."""
        return _answered(lambda: self.policy.act(observation))


def _answered(call: Callable[[], T]) -> T:
    try:
        return call()
    except Abstained:
        raise
    except Exception as error:  # whatever a policy raises is its own
        raise PolicyError(described_error(error)) from error


class Unfit:
    """What is left of a policy that could not learn: whatever it is asked for, it says why.

    Args:
        name: As it was asked for.
        why: What went wrong.
    """

    inputs: Inputs = "frames"

    def __init__(self, name: str, why: str) -> None:
        self.name = name
        self._why = why

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Unfit:
        """No more than before."""
        return self

    def generate(self, frames: Situation | Posture, start: ArrayLike) -> Path:
        """Raises PolicyError."""
        raise PolicyError(self._why)


def _described(name: str, limits: PolicyLimits, log: File | None = None) -> Mapping[str, Any]:
    """What a policy of other people says of itself before it learns."""
    # Its module is imported meanwhile, which is no learning.
    found: Mapping[str, Any] = _host(limits, log).ask(max(START, limits.fit_time), "describe", name)
    return found


def is_ours(name: str) -> bool:
    """Whether a policy of this name, perhaps with hyper-parameters, comes with this package."""
    return split_name(known_name(name))[0] in built_in()


def hosted_policy(
    name: str, seed: int = 0, limits: PolicyLimits | None = None, log: File | None = None
) -> Policy:
    """A new policy by its name, not yet fitted, that raises `PolicyError` and nothing else.

    Args:
        name: As of `make_policy`. Policies of this package answer in this process.
        seed: Of the randomness of learning.
        limits: What other people's policies may use.
        log: File for what they print.

    Raises:
        InvalidInputError: There is no such policy or hyper-parameter, or it is none.
    """
    if is_ours(name):
        policy = make_policy(name, seed)
        return (GuardedActor if callable(getattr(policy, "act", None)) else Guarded)(name, policy)
    chosen = limits or PolicyLimits()
    found = _described(name, chosen, log)
    kind = HostedActor if found["acts"] else Hosted
    return kind(name, seed, found["inputs"], found["stream"], chosen, log)


def policy_origins(
    names: Iterable[str], limits: PolicyLimits | None = None
) -> dict[str, Mapping[str, str | None]]:
    """Where other people's policies among names of policies come from.

    Returns:
        By name without hyper-parameters: ``{"sha256": ..., "version": ...}``, the hash of its
        source and the version of its distribution, None where it has none.
    """
    chosen = limits or PolicyLimits()
    theirs = {split_name(known_name(name))[0]: name for name in names if not is_ours(name)}
    return {stem: _described(name, chosen)["origin"] for stem, name in theirs.items()}
