"""Whether an episode that was run again is the recorded one: to the bit, or on another processor.

Where the numerics have the recorded fingerprint, and no other reason for a difference is known,
every bit must be the same. On another kind of processor the last bits of a product or of a sine
differ, and an episode carries them on: there the verdict must be the same, and numbers must be so
within `RELATIVE`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from dressing_sim.benchmark.run.differences import leaves, tell

#: Largest difference between numbers of different numerics, in relation to their size.
#: Measured: 6e-10 at worst over twenty episodes with three other numerics (docs/benchmark.md).
RELATIVE = 1e-6

#: Smaller numbers are compared as if they had this size, in their unit (m, N, s or 1): a noise of
#: rounding has no relation to its own size.
SMALL = 1e-3

#: A recorded line has them, but they are no measurements.
_NOT_MEASURED = ("versions", "provenance")


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
    """Compare two lines of ``episodes.jsonl``.

    Args:
        recorded: As it was recorded, plain values.
        now: As it is now.
        numerics: In what the numerics differ; if empty, every bit must be the same.
    """
    one, other = _measured(recorded), _measured(now)
    before, after = dict(leaves(one)), dict(leaves(other))
    unequal = [n for n in dict.fromkeys([*before, *after]) if not _same(n, before, after)]
    found = tell(before, after, unequal, "recorded", "now")
    apart = {n: _apart(n, before, after) for n in unequal}
    largest = max((value for value in apart.values() if value < math.inf), default=0.0)
    if not numerics:
        return Agreement(found, found, largest, numerics)
    far = [n for n, value in apart.items() if not value <= RELATIVE]
    return Agreement(found, tell(before, after, far, "recorded", "now"), largest, numerics)


def _measured(line: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in line.items() if name not in _NOT_MEASURED}


def _same(name: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> bool:
    return name in before and name in after and repr(before[name]) == repr(after[name])


def _apart(name: str, before: Mapping[str, Any], after: Mapping[str, Any]) -> float:
    """How far two values are apart in relation to their size; infinite if they cannot be near."""
    one, other = before.get(name), after.get(name)
    if isinstance(one, str) and isinstance(other, str) and _is_text_of_a_failure(name):
        return 0.0  # it has rounded numbers in it, which stand elsewhere in full
    # Seeds and counts are whole numbers, and exact.
    if not (isinstance(one, float) and isinstance(other, float)):
        return math.inf
    apart = abs(one - other) / max(abs(one), abs(other), SMALL)
    return apart if math.isfinite(apart) else math.inf


def _is_text_of_a_failure(name: str) -> bool:
    return name.startswith("failures.") and name.endswith(".detail")
