"""Where plain values differ, and whether an episode that was run again is the recorded one.

Where the numerics have the recorded fingerprint, and no other reason for a difference is known,
every bit must be the same. On another kind of processor the last bits of a product or of a sine
differ, and an episode carries them on: there the verdict must be the same, and numbers must be so
within `RELATIVE`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

#: Largest difference between numbers of different numerics, in relation to their size.
#: Measured: 6e-10 at worst over twenty episodes with three other numerics (docs/same_bits.md).
RELATIVE = 1e-6

#: Smaller numbers are compared as if they had this size, in their unit (m, N, s or 1): a noise of
#: rounding has no relation to its own size.
SMALL = 1e-3

#: A recorded line has them, but they say nothing of the episode; times are the machine's.
_NOT_COMPARED = ("versions", "provenance", "seconds")

#: More differences than this are counted only.
_LISTED = 12


@dataclass(frozen=True, slots=True)
class Agreement:
    """How an episode compares with its recorded line.

    Attributes:
        differences: Where they differ, a line each; none if every bit is the same.
        beyond: Those of them that are more than another processor explains.
        largest: The largest difference of two numbers in relation to their size.
        numerics: In what the numerics differ from the recorded ones; empty if they do not.
    """

    differences: list[str]
    beyond: list[str]
    largest: float
    numerics: str

    @property
    def holds(self) -> bool:
        """Whether it is the same episode, as far as these numerics can tell."""
        return not self.beyond

    def told(self) -> str:
        """In a line, if it holds."""
        if not self.differences:
            return "identical to the recorded episode, to the bit"
        return (
            f"the same verdict as recorded, numbers within {self.largest:.1g} of their size "
            f"(other numerics: {self.numerics})"
        )


def compare(recorded: Mapping[str, Any], now: Mapping[str, Any], numerics: str = "") -> Agreement:
    """Compare two lines of ``episodes.jsonl``, plain values.

    `numerics` is in what the numerics differ; if it is empty, every bit must be the same.
    """
    before, after = (
        {n: leaf for n, leaf in _leaves(line) if not set(n.split(".")) & set(_NOT_COMPARED)}
        for line in (recorded, now)
    )
    apart = {name: _apart(name, before, after) for name in _unequal(before, after)}
    beyond = [name for name, value in apart.items() if not (numerics and value <= RELATIVE)]
    return Agreement(
        _told(apart, before, after, "recorded", "now"),
        _told(beyond, before, after, "recorded", "now"),
        max((value for value in apart.values() if value < math.inf), default=0.0),
        numerics,
    )


def differences(first: Any, second: Any, here: str, there: str) -> list[str]:
    """One line for each plain value that differs, and none if all are equal to the bit.

    The first are called `here` in the text, the second `there`.
    """
    one, other = dict(_leaves(first)), dict(_leaves(second))
    return _told(_unequal(one, other), one, other, here, there)


def _leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Plain values within plain values, each with its dotted name: ``figures.strain``."""
    if not value or not isinstance(value, Mapping | list):
        yield name, value
        return
    for key, child in value.items() if isinstance(value, Mapping) else enumerate(value):
        yield from _leaves(child, f"{name}.{key}" if name else str(key))


def _unequal(one: Mapping[str, Any], other: Mapping[str, Any]) -> list[str]:
    return [n for n in dict.fromkeys([*one, *other]) if _text(one, n) != _text(other, n)]


def _told(
    names: Iterable[str], one: Mapping[str, Any], other: Mapping[str, Any], here: str, there: str
) -> list[str]:
    """A line for each name, and one that counts those beyond the twelfth."""
    lines = [f"{name}: {_text(one, name)} {here}, {_text(other, name)} {there}" for name in names]
    more = len(lines) - _LISTED
    return lines[:_LISTED] + ([f"and {more} more"] if more > 0 else [])


def _text(values: Mapping[str, Any], name: str) -> str:
    # The shortest text that gives the same number again; unlike numbers, NaN equals itself.
    return repr(values[name]) if name in values else "nothing"


def _apart(name: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> float:
    """How far two values are apart in relation to their size; infinite if they cannot be near."""
    one, other = before.get(name), after.get(name)
    of_a_failure = name.startswith("failures.") and name.endswith(".detail")
    if of_a_failure and isinstance(one, str) and isinstance(other, str):
        return 0.0  # it has rounded numbers in it, which stand elsewhere in full
    # Seeds and counts are whole numbers, and exact.
    if not (isinstance(one, float) and isinstance(other, float)):
        return math.inf
    apart = abs(one - other) / max(abs(one), abs(other), SMALL)
    return apart if math.isfinite(apart) else math.inf
