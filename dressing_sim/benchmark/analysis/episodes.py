"""Episodes as a table of columns, and the one place where successes are counted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.benchmark.analysis.statistics import Row, wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, first_failure, in_order
from dressing_sim.errors import InvalidInputError

Key = TypeVar("Key", Entry, str)


@dataclass(frozen=True, slots=True)
class Rate:
    """How many episodes succeeded; invalid ones count neither way.

    Attributes:
        n_success: Successes.
        n: Episodes that count.
        n_void: Episodes that are invalid.
    """

    n_success: int
    n: int
    n_void: int = 0

    @classmethod
    def of(cls, successes: Iterable[bool | None]) -> Rate:
        """The rate of episodes that succeeded, did not, or are invalid (None)."""
        known = list(successes)
        valid = [bool(success) for success in known if success is not None]
        return cls(sum(valid), len(valid), len(known) - len(valid))

    @property
    def n_failed(self) -> int:
        """Episodes that count and are no success."""
        return self.n - self.n_success

    @property
    def percent(self) -> float | None:
        """Success rate [%]; None where no episode counts."""
        return 100.0 * self.n_success / self.n if self.n else None

    @property
    def interval(self) -> tuple[float, float]:
        """95 % Wilson interval of the rate [%]."""
        low, high = wilson_interval(self.n_success, self.n)
        return 100.0 * low, 100.0 * high


@dataclass(frozen=True, eq=False)
class EpisodeTable:
    """Episodes, of which rates, counts and groups are made.

    Attributes:
        results: The episodes.
        successes: Whether each succeeded; None where it is invalid.
    """

    results: tuple[EpisodeResult, ...]
    successes: list[bool | None]

    @classmethod
    def of(cls, results: Iterable[EpisodeResult]) -> EpisodeTable:
        """The table of a run's episodes, in the order of the protocol."""
        ordered = tuple(sorted(results, key=lambda result: result.index))
        return cls(ordered, [_success(result) for result in ordered])

    def __len__(self) -> int:
        return len(self.results)

    @cached_property
    def sets(self) -> NDArray[np.int64]:
        """Demonstration set that the policy learned from, shape (n,)."""
        return np.array([r.demonstration_set for r in self.results], dtype=np.int64)

    @cached_property
    def elbow_deg(self) -> NDArray[np.float64]:
        """Elbow flexion after variation, shape (n,) [deg]."""
        return np.array([r.posture.elbow_deg for r in self.results], dtype=np.float64)

    @cached_property
    def friction(self) -> NDArray[np.float64]:
        """Friction that was drawn for the episode, NaN where none was, shape (n,)."""
        drawn = [result.variation.get("friction", np.nan) for result in self.results]
        return np.array(drawn, dtype=np.float64)

    @cached_property
    def valid(self) -> NDArray[np.bool_]:
        """Whether the episode counts, shape (n,)."""
        return np.array([success is not None for success in self.successes], dtype=np.bool_)

    @cached_property
    def abstained(self) -> NDArray[np.bool_]:
        """Whether the policy chose not to try, shape (n,)."""
        return np.array([r.outcome.abstained is not None for r in self.results], dtype=np.bool_)

    @cached_property
    def failed(self) -> NDArray[np.bool_]:
        """Whether the episode was tried, counts and is no success, shape (n,)."""
        missed = [success is False for success in self.successes]
        return np.array(missed, dtype=np.bool_) & ~self.abstained

    def where(self, chosen: ArrayLike) -> EpisodeTable:
        """The episodes for which a mask of shape (n,) is true, in the same order."""
        return self._at(np.flatnonzero(chosen).tolist())

    def _at(self, places: Sequence[int]) -> EpisodeTable:
        return EpisodeTable(
            tuple(self.results[place] for place in places),
            [self.successes[place] for place in places],
        )

    def judged(self, successes: Iterable[bool | None]) -> EpisodeTable:
        """The same episodes with other verdicts, None where there is none."""
        return EpisodeTable(self.results, list(successes))

    @cached_property
    def by_entry(self) -> dict[Entry, EpisodeTable]:
        """The episodes of each row of the protocol."""
        return self._groups([result.entry for result in self.results])

    @cached_property
    def by_posture(self) -> dict[str, EpisodeTable]:
        """The episodes of each posture, by its name."""
        return self._groups([result.posture.name for result in self.results])

    def _groups(self, keys: Sequence[Key]) -> dict[Key, EpisodeTable]:
        places: dict[Key, list[int]] = {}
        for place, key in enumerate(keys):
            places.setdefault(key, []).append(place)
        return {key: self._at(inside) for key, inside in places.items()}

    def of_entry(self, entry: Entry) -> EpisodeTable:
        """The episodes of one row; none if there are none."""
        return self.by_entry.get(entry, EpisodeTable((), []))

    @property
    def rate(self) -> Rate:
        """How many succeeded."""
        return Rate.of(self.successes)

    @property
    def reasons(self) -> dict[str, int]:
        """Episodes that count by what went wrong in them, in the order of the rules."""
        valid = self.where(self.valid).results
        return _counted(reason for result in valid for reason in set(result.outcome.reasons))

    @property
    def first_reasons(self) -> dict[str, int]:
        """Episodes that count by what went wrong first in them, in the order of the rules."""
        firsts = [first_failure(result.outcome) for result in self.where(self.valid).results]
        return _counted(first.reason for first in firsts if first is not None)

    @property
    def row(self) -> Row:
        """Success by demonstration set and posture, of the episodes of one row of the protocol.

        Raises:
            InvalidInputError: Two episodes have the same posture and set.
        """
        found: dict[tuple[int, str], bool | None] = {}
        for result, success in zip(self.results, self.successes, strict=True):
            key = result.demonstration_set, result.posture.name
            if key in found:
                raise InvalidInputError(
                    f"row {result.entry.label}: posture {key[1]!r} with demonstration set "
                    f"{key[0]} occurs twice; valid is once"
                )
            found[key] = success
        return found

    @property
    def rows(self) -> dict[Entry, Row]:
        """`row` of each row of the protocol."""
        return {entry: episodes.row for entry, episodes in self.by_entry.items()}


def count(results: Iterable[EpisodeResult]) -> Rate:
    """How many of some episodes succeeded."""
    return Rate.of(map(_success, results))


def _success(result: EpisodeResult) -> bool | None:
    return result.outcome.success if result.outcome.invalid is None else None


def _counted(reasons: Iterable[str]) -> dict[str, int]:
    counts = Counter(reasons)
    return {reason: counts[reason] for reason in in_order(counts.keys())}
