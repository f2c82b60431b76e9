"""Protocols: which policies learn from which demonstrations, and where they are tested."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dressing_sim.benchmark.policies import EXPERT
from dressing_sim.errors import InvalidInputError


@dataclass(frozen=True, slots=True)
class Entry:
    """One row of a table.

    Attributes:
        policy: Name of the policy.
        demonstrations: Suite of the postures it was shown, or None for the expert.
    """

    policy: str
    demonstrations: str | None = None


@dataclass(frozen=True, slots=True)
class Protocol:
    """A table to be measured.

    Attributes:
        name: What it is called.
        suite: Test postures.
        entries: Its rows.
    """

    name: str
    suite: str
    entries: tuple[Entry, ...]

    def with_policies(self, names: Sequence[str]) -> Protocol:
        """The same test with other policies, each learning from every demonstration set."""
        sets = dict.fromkeys(e.demonstrations for e in self.entries if e.demonstrations)
        entries = [
            entry
            for name in dict.fromkeys(names)
            for entry in ([Entry(name)] if name == EXPERT else [Entry(name, s) for s in sets])
        ]
        return Protocol(self.name, self.suite, tuple(entries))


PROTOCOLS: Mapping[str, Protocol] = {
    "paper": Protocol(
        "paper",
        "paper5",
        (
            Entry(EXPERT),
            Entry("tp-gmm", "case_a"),
            Entry("tp-gmm", "case_b"),
            Entry("tp-gmm", "baseline7"),
        ),
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
