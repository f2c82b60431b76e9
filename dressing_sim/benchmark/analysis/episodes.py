"""Episodes as a table of columns, and the one place where successes are counted."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.benchmark.analysis.statistics import Row, wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, Failure, in_order
from dressing_sim.errors import InvalidInputError


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
    """Episodes as columns, each with n elements, one an episode.

    Attributes:
        index: Place in the protocol, shape (n,).
        entries: Row of the protocol.
        postures: Name of the posture.
        elbow_deg: Its elbow flexion after variation, shape (n,) [deg].
        sets: Demonstration set that the policy learned from, shape (n,).
        valid: Whether the episode counts, shape (n,).
        success: Whether the arm was dressed, shape (n,); False where invalid.
        failures: What went wrong.
        metrics: Measurements by name, each of shape (n,), SI units; NaN where not measured.
    """

    index: NDArray[np.int64]
    entries: tuple[Entry, ...]
    postures: tuple[str, ...]
    elbow_deg: NDArray[np.float64]
    sets: NDArray[np.int64]
    valid: NDArray[np.bool_]
    success: NDArray[np.bool_]
    failures: tuple[tuple[Failure, ...], ...]
    metrics: dict[str, NDArray[np.float64]]

    @classmethod
    def of(cls, results: Iterable[EpisodeResult]) -> EpisodeTable:
        """The table of a run's episodes, in the order of the protocol."""
        ordered = sorted(results, key=lambda result: result.index)
        outcomes = [result.outcome for result in ordered]
        names = dict.fromkeys(name for outcome in outcomes for name in outcome.metrics)
        return cls(
            index=np.array([r.index for r in ordered], dtype=np.int64),
            entries=tuple(r.entry for r in ordered),
            postures=tuple(r.posture.name for r in ordered),
            elbow_deg=np.array([r.posture.elbow_deg for r in ordered], dtype=np.float64),
            sets=np.array([r.demonstration_set for r in ordered], dtype=np.int64),
            valid=np.array([o.invalid is None for o in outcomes], dtype=np.bool_),
            success=np.array([o.success and o.invalid is None for o in outcomes], dtype=np.bool_),
            failures=tuple(o.failures for o in outcomes),
            metrics={
                name: np.array([float(o.metrics.get(name, np.nan)) for o in outcomes])
                for name in names
            },
        )

    def __len__(self) -> int:
        return len(self.entries)

    def where(self, chosen: ArrayLike) -> EpisodeTable:
        """The episodes for which a mask of shape (n,) is true, in the same order."""
        places = np.flatnonzero(chosen)
        return EpisodeTable(
            index=self.index[places],
            entries=tuple(self.entries[place] for place in places),
            postures=tuple(self.postures[place] for place in places),
            elbow_deg=self.elbow_deg[places],
            sets=self.sets[places],
            valid=self.valid[places],
            success=self.success[places],
            failures=tuple(self.failures[place] for place in places),
            metrics={name: values[places] for name, values in self.metrics.items()},
        )

    def judged(self, successes: Sequence[bool | None]) -> EpisodeTable:
        """The same episodes with other verdicts, None where there is none."""
        return replace(
            self,
            valid=np.array([success is not None for success in successes], dtype=np.bool_),
            success=np.array([success is True for success in successes], dtype=np.bool_),
        )

    @cached_property
    def by_entry(self) -> dict[Entry, EpisodeTable]:
        """The episodes of each row of the protocol."""
        places: dict[Entry, list[bool]] = {
            entry: [one == entry for one in self.entries] for entry in dict.fromkeys(self.entries)
        }
        return {entry: self.where(chosen) for entry, chosen in places.items()}

    def of_entry(self, entry: Entry) -> EpisodeTable:
        """The episodes of one row; none if there are none."""
        return self.by_entry.get(entry) or self.where(np.zeros(len(self), dtype=np.bool_))

    @property
    def successes(self) -> list[bool | None]:
        """Success of each episode, None where it is invalid."""
        return [
            bool(success) if valid else None
            for success, valid in zip(self.success, self.valid, strict=True)
        ]

    @property
    def rate(self) -> Rate:
        """How many succeeded."""
        return Rate.of(self.successes)

    @property
    def reasons(self) -> dict[str, int]:
        """Episodes that count by what went wrong in them, in the order of the rules."""
        told = [
            {failure.reason for failure in failures}
            for failures, valid in zip(self.failures, self.valid, strict=True)
            if valid
        ]
        order = in_order({reason for one in told for reason in one})
        return {reason: sum(reason in one for one in told) for reason in order}

    @property
    def row(self) -> Row:
        """Success by demonstration set and posture, of the episodes of one row of the protocol.

        Raises:
            InvalidInputError: Two episodes have the same posture and set.
        """
        found: dict[tuple[int, str], bool | None] = {}
        keys = zip(self.sets.tolist(), self.postures, strict=True)
        for key, success, entry in zip(keys, self.successes, self.entries, strict=True):
            if key in found:
                raise InvalidInputError(
                    f"row {entry.label}: posture {key[1]!r} with demonstration set {key[0]} "
                    "occurs twice; valid is once"
                )
            found[key] = success
        return found

    @property
    def rows(self) -> dict[Entry, Row]:
        """`row` of each row of the protocol."""
        return {entry: episodes.row for entry, episodes in self.by_entry.items()}


def count(results: Sequence[EpisodeResult]) -> Rate:
    """How many of some episodes succeeded."""
    return Rate.of(None if r.outcome.invalid is not None else r.outcome.success for r in results)
