"""Protocols: which policies learn from which demonstrations, and where they are tested."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from dressing_sim.arm import Posture
from dressing_sim.benchmark.policies import EXPERT, known_name
from dressing_sim.benchmark.suites import load_suite
from dressing_sim.errors import InvalidInputError


@dataclass(frozen=True, slots=True)
class Entry:
    """One row of a table.

    Attributes:
        policy: Name of the policy.
        demonstrations: Suite of the postures it was shown, ``NAME:n`` for the first n of them, or
            None for the expert.
        variation: What is drawn anew for each episode, of `dressing_sim.variation.FACTORS`.
    """

    policy: str
    demonstrations: str | None = None
    variation: tuple[str, ...] = ()

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
        kind: Whether success in episodes is measured, or the cost of Algorithm 1 alone.
    """

    name: str
    suite: str
    entries: tuple[Entry, ...]
    demonstration_sets: int = 1
    kind: Literal["episodes", "cost"] = "episodes"

    def __post_init__(self) -> None:
        if self.demonstration_sets < 1:
            raise InvalidInputError(
                f"protocol {self.name!r}: demonstration_sets is {self.demonstration_sets}, "
                "valid is 1 or more"
            )

    def with_policies(self, names: Sequence[str]) -> Protocol:
        """The same test with other policies, each learning from every suite of demonstrations."""
        shown = dict.fromkeys(e.demonstrations for e in self.entries if e.demonstrations)
        variations = dict.fromkeys(e.variation for e in self.entries)
        entries = [
            Entry(name, demonstrations, variation)
            for name in dict.fromkeys(map(known_name, names))
            for demonstrations in ([None] if name == EXPERT else shown)
            for variation in variations
        ]
        return replace(self, entries=tuple(entries))

    def with_variation(self, factors: Sequence[str]) -> Protocol:
        """The same test, but these factors, and no others, are drawn anew for each episode."""
        varied = tuple(dict.fromkeys(factors))
        entries = dict.fromkeys(replace(entry, variation=varied) for entry in self.entries)
        return replace(self, entries=tuple(entries))


def shown_postures(name: str) -> list[Posture]:
    """Postures to demonstrate on: those of a suite, or with ``NAME:n`` its first n.

    Raises:
        InvalidInputError: There is no such suite, or it has fewer than n.
    """
    # In random:N and random:N:SEED the number after the colon means something else.
    match = None if name.startswith("random:") else re.fullmatch(r"(.+):(\d+)", name)
    if match is None:
        return load_suite(name)
    postures, count = load_suite(match[1]), int(match[2])
    if not 1 <= count <= len(postures):
        raise InvalidInputError(
            f"demonstrations {name!r}: valid is 1 to {len(postures)} postures of suite {match[1]!r}"
        )
    return postures[:count]


_CASES = ("case_a", "case_b")
_AUGMENTED = ("tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise")

#: The paper's rows, and the operator.
_PAPER = (
    Entry(EXPERT),
    *(Entry(policy, case) for case in _CASES for policy in ("tp-gmm", *_AUGMENTED)),
    Entry("tp-gmm", "baseline7"),
)

#: The paper's seven, and what noise alone does for the case that gains more.
_FULL = tuple(entry for entry in _PAPER[1:] if entry != Entry("tp-gmm-noise", "case_b"))

#: With and without augmentation, from two to seven demonstrations.
_BUDGET = tuple(
    Entry(policy, f"baseline7:{n}") for policy in ("tp-gmm", "tp-gmm-rf") for n in range(2, 8)
)

#: Without and with augmentation, and the baseline: what settings and worlds are compared on.
_COMPARED = (
    *(Entry(policy, case) for case in _CASES for policy in ("tp-gmm", "tp-gmm-rf-noise")),
    Entry("tp-gmm", "baseline7"),
)

#: In the nominal world, and with one factor after the other drawn anew.
_ROBUST = tuple(
    replace(entry, variation=variation)
    for entry in (Entry(EXPERT), *_COMPARED)
    for variation in ((), ("friction",), ("fabric",), ("arm",))
)

#: What the paper leaves open, one change at a time, as settings after a policy's name.
_CHANGES = (
    "relative_floor=true&position_floor=0.1&displacement_floor=0.1",
    "position_floor=1e-3",
    "displacement_floor=1e-6",
    "fusion=product-then-regression",
    "free_axes=arm-plane",
    "end_radius=0",
)

#: Of random situations; initial policies know none.
_AUGMENTED_CHANGES = ("situations=frames", "angle_margin_deg=0&translation_margin=0")

_SETTINGS = (
    *_COMPARED,
    *(
        replace(entry, policy=f"{entry.policy}?{change}")
        for change in (*_CHANGES, *_AUGMENTED_CHANGES)
        for entry in _COMPARED
        if change in _CHANGES or entry.policy in _AUGMENTED
    ),
    # Whether noise and random frames, each alone, do more than a wider floor.
    *(
        Entry(f"{policy}{change}", "case_a")
        for policy in ("tp-gmm-noise", "tp-gmm-rf")
        for change in ("", f"?{_CHANGES[0]}")
    ),
)

PROTOCOLS: Mapping[str, Protocol] = {
    protocol.name: protocol
    for protocol in (
        Protocol("paper", "paper5", _PAPER),
        Protocol(
            "paper-cost",
            "paper5",
            tuple(Entry(policy, case) for case in _CASES for policy in _AUGMENTED),
            kind="cost",
        ),
        Protocol("full", "test200", _FULL, demonstration_sets=5),
        Protocol("budget", "val50", _BUDGET, demonstration_sets=5),
        Protocol("robust", "val50", _ROBUST, demonstration_sets=5),
        Protocol("settings", "val50", _SETTINGS, demonstration_sets=5),
    )
}


def find_protocol(name: str) -> Protocol:
    """A protocol by its name.

    Raises:
        InvalidInputError: There is none of this name.
    """
    if name not in PROTOCOLS:
        raise InvalidInputError(
            f"unknown protocol {name!r}; valid is one of {', '.join(PROTOCOLS)}"
        )
    return PROTOCOLS[name]
