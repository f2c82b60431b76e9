"""The nouns of the benchmark: a row, a protocol, and what became of one episode."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

from dressing_sim.arm import Posture
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rules import in_order
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.variation import in_words
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Inputs
from dressing_sim.policies.hyperparameters import TUNED
from dressing_sim.policies.registry import known_name, learns

__all__ = [
    "Entry",
    "EpisodeResult",
    "Failure",
    "Json",
    "Outcome",
    "Protocol",
    "first_failure",
    "in_order",
]

#: Two times that differ by less are the same [s].
_SLACK = 1e-6

#: A value as JSON knows it.
Json: TypeAlias = "bool | int | float | str | Sequence[Json] | Mapping[str, Json] | None"


@dataclass(frozen=True, slots=True)
class Entry:
    """One row of a table.

    Attributes:
        policy: Name of the policy, with hyper-parameters after a ``?`` if others than usual.
        demonstrations: Suite of the postures it learned from, ``NAME:n`` for the first n of them,
            with the operator's style after a ``?`` if it is another; None for the expert.
        variation: What is drawn anew for each episode, or fixed, see `dressing_sim.episode.vary`.
        inputs: The policy's class of inputs; a plan says it, and rows are the same whatever it is.
    """

    policy: str
    demonstrations: str | None = None
    variation: tuple[str, ...] = ()
    inputs: Inputs = field(default="frames", compare=False)

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> Entry:
        """The inverse of `to_dict`, of a row of a summary too."""
        return cls(row["policy"], row["demonstrations"], tuple(row.get("variation", ())))

    @property
    def stem(self) -> str:
        """The policy's name without hyper-parameters."""
        return self.policy.partition("?")[0]

    @property
    def untuned(self) -> Entry:
        """The row of the same policy as published; itself if it is that."""
        stem, mark, text = self.policy.partition("?")
        return replace(self, policy=f"{stem.removesuffix(TUNED)}{mark}{text}")

    @property
    def tuned(self) -> Entry:
        """The row of the same policy with the hyper-parameters that a search found for it."""
        stem, mark, text = self.untuned.policy.partition("?")
        return replace(self, policy=f"{stem}{TUNED}{mark}{text}")

    @property
    def label(self) -> str:
        """The row in words."""
        learned = f" on {self.demonstrations}" if self.demonstrations else ""
        varied = f", {in_words(self.variation)}" if self.variation else ""
        return f"{self.policy}{learned}{varied}"

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a summary."""
        return {
            "policy": self.policy,
            "demonstrations": self.demonstrations,
            "variation": list(self.variation),
        }


@dataclass(frozen=True, slots=True)
class Protocol:
    """A table to be measured.

    With S demonstration sets, test posture i is dressed by the policy that learned from set
    ``i mod S``; each set is the same postures, demonstrated with other seeds. So all rows are
    paired by posture and set, and a row averages over the operator's variability.

    Attributes:
        name: What it is called.
        suite: Test postures.
        entries: Its rows.
        demonstration_sets: How often the demonstrated postures are demonstrated.
        study: Name of the study that measures it.
    """

    name: str
    suite: str
    entries: tuple[Entry, ...]
    demonstration_sets: int = 1
    study: str = "success"

    def __post_init__(self) -> None:
        if self.demonstration_sets < 1:
            raise InvalidInputError(
                f"protocol {self.name!r}: demonstration_sets is {self.demonstration_sets}, "
                "valid is 1 or more"
            )

    def with_policies(self, names: Sequence[str]) -> Protocol:
        """The same test with other policies, each learning from every suite of demonstrations."""
        suites = dict.fromkeys(e.demonstrations for e in self.entries if e.demonstrations)
        variations = dict.fromkeys(e.variation for e in self.entries)
        entries = [
            Entry(name, demonstrations, variation)
            for name in dict.fromkeys(map(known_name, names))
            for demonstrations in (suites if learns(name) else [None])
            for variation in variations
        ]
        return replace(self, entries=tuple(entries))

    def with_suites(self, suites: Sequence[str]) -> Protocol:
        """The same test, but every policy learns from these suites, one after the other."""
        entries = dict.fromkeys(
            replace(entry, demonstrations=suite) if entry.demonstrations else entry
            for entry in self.entries
            for suite in suites
        )
        return replace(self, entries=tuple(entries))

    def with_demonstrations(self, name: str) -> Protocol:
        """The same test, but every policy learns from these demonstrations alone."""
        return replace(self.with_suites([name]), demonstration_sets=1)

    def with_variation(self, factors: Sequence[str]) -> Protocol:
        """The same test, but these factors, and no others, are drawn anew or fixed."""
        varied = tuple(dict.fromkeys(factors))
        entries = dict.fromkeys(replace(entry, variation=varied) for entry in self.entries)
        return replace(self, entries=tuple(entries))


@dataclass(frozen=True, slots=True)
class EpisodeResult:
    """One line of ``episodes.jsonl``.

    Attributes:
        index: Its place in the protocol: all test postures of the first entry, then of the next.
        entry: Row of the protocol.
        posture: The arm that was dressed, after variation.
        demonstration_set: Which set of demonstrations the policy learned from.
        seed: Of the operator's variability.
        variation: What was drawn for this episode, by factor.
        outcome: The verdict.
        extra: What a study finds out beyond that, plain values by name; nothing in most.
    """

    index: int
    entry: Entry
    posture: Posture
    demonstration_set: int
    seed: int
    variation: Mapping[str, Any]
    outcome: Outcome
    extra: Mapping[str, Json] = field(default_factory=dict)


def first_failure(outcome: Outcome) -> Failure | None:
    """What went wrong first; what has no time was wrong from the start. None for a success.

    A caught sleeve is found out by the limit that it exceeds, a moment before it stops the robot:
    of failures as near in time as that, the first of the rules counts.
    """
    times = [failure.time or 0.0 for failure in outcome.failures]
    latest = min(times, default=0.0) + Thresholds().moment + _SLACK  # times are sums of steps
    # Failures come in the rules' order.
    pairs = zip(outcome.failures, times, strict=True)
    return next((failure for failure, time in pairs if time <= latest), None)
