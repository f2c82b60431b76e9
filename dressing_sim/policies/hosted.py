"""Policies that cost no more than their own episodes, whatever they do."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path as File
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.errors import PolicyError
from dressing_sim.inputs import fit
from dressing_sim.learning import DemonstrationLike, Situation
from dressing_sim.learning.policy import Inputs
from dressing_sim.path import Path, checked_path, takes_seed
from dressing_sim.policies.host import Host, PolicyLimits, described_error
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

    def generate(
        self, frames: Situation | Posture, start: NDArray[np.float64], seed: int = 0
    ) -> Path:
        """A path for a situation.

        Raises:
            PolicyError: It raised, took too long, ended its process, or made no path.
        """
        arguments = self.fitted, frames, start, seed
        positions, dt = self._host().ask(self.limits.generate_time, "generate", *arguments)
        return Path(positions, dt)

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
    """

    def __init__(self, name: str, policy: Any) -> None:
        self.name = name
        self._policy = policy
        self.inputs = getattr(policy, "inputs", "frames")
        self.stream = getattr(policy, "stream", type(policy).__qualname__)

    @property
    def dt(self) -> float | None:
        """Time between two samples of its path, if it says so [s]."""
        return getattr(self._policy, "dt", None)

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Guarded:
        """Learn, and return the policy itself."""
        self._policy = _answered(lambda: fit(self._policy, demonstrations))
        return self

    def generate(
        self, frames: Situation | Posture, start: NDArray[np.float64], seed: int = 0
    ) -> Path:
        """A path for a situation."""
        own = {"seed": seed} if takes_seed(self._policy.generate) else {}
        return _answered(lambda: checked_path(self._policy.generate(frames, start, **own), "it"))


class GuardedActor(Guarded):
    """The same of a policy in closed loop."""

    def reset(self, seed: int = 0) -> None:
        """Begin an episode."""
        reset = getattr(self._policy, "reset", None)
        if callable(reset):
            _answered(lambda: reset(**({"seed": seed} if takes_seed(reset) else {})))

    def act(self, observation: Any) -> Any:
        """The next target (3,) [m], or None at the end."""
        return _answered(lambda: self._policy.act(observation))


def _answered(call: Callable[[], T]) -> T:
    try:
        return call()
    except Exception as error:  # whatever a policy raises is its own
        raise PolicyError(described_error(error)) from error


def hosted_policy(
    name: str, seed: int = 0, limits: PolicyLimits | None = None, log: File | None = None
) -> Hosted | Guarded:
    """A new policy by its name, not yet fitted, that raises `PolicyError` and nothing else.

    Args:
        name: As of `make_policy`. Policies of this package answer in this process.
        seed: Of the randomness of learning.
        limits: What other people's policies may use.
        log: File for what they print.

    Raises:
        InvalidInputError: There is no such policy or hyper-parameter, or it is none.
    """
    stem, _ = split_name(known_name(name))
    if stem in built_in():
        policy = make_policy(name, seed)
        return (GuardedActor if callable(getattr(policy, "act", None)) else Guarded)(name, policy)
    chosen = limits or PolicyLimits()
    found = _host(chosen, log).ask(chosen.fit_time, "describe", name)
    kind = HostedActor if found["acts"] else Hosted
    return kind(name, seed, found["inputs"], found["stream"], chosen, log)
