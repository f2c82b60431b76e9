"""What the report's figures show, as plain numbers; how they are drawn is the template's affair."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dressing_sim.arm import Posture
from dressing_sim.benchmark.analysis.statistics import wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.episode.rules import REASONS, Failure, Outcome, Thresholds

#: Widths of a bin of elbow flexion that are tried, the finest first [deg].
_BIN_WIDTHS_DEG = (5, 10, 15, 30)
_MOST_BINS = 6

#: Two times that differ by less are the same [s].
_SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class Point:
    """A success rate at a place on the horizontal axis.

    Attributes:
        x: Place, in the axis' unit.
        successes: Number of successes.
        trials: Number of trials, above zero.
        low: Lower bound of the 95 % Wilson interval [%].
        high: Upper bound [%].
    """

    x: float
    successes: int
    trials: int
    low: float
    high: float

    @classmethod
    def of(cls, x: float, successes: int, trials: int) -> Point:
        """The rate of so many successes in so many trials."""
        low, high = wilson_interval(successes, trials)
        return cls(x, successes, trials, 100.0 * low, 100.0 * high)

    @property
    def rate(self) -> float:
        """Success rate [%]."""
        return 100.0 * self.successes / self.trials


@dataclass(frozen=True, slots=True)
class Curve:
    """One small figure: success rate against a quantity, with the episodes behind it.

    Attributes:
        entry: Row of the protocol; of a curve over several rows, the first.
        points: Rates, from left to right.
        dressed: Where single episodes succeeded.
        failed: Where single episodes failed.
    """

    entry: Entry
    points: tuple[Point, ...]
    dressed: tuple[float, ...] = ()
    failed: tuple[float, ...] = ()


@dataclass(frozen=True, slots=True)
class Axis:
    """A horizontal axis with its ticks; `place` says where a value is along it."""

    low: float
    high: float
    ticks: tuple[float, ...]

    def place(self, value: float) -> float:
        """Distance from the left end [%]."""
        return 100.0 * (value - self.low) / (self.high - self.low)


@dataclass(frozen=True, slots=True)
class Segment:
    """A part of a stacked bar: so many episodes of one reason, its start and width [%]."""

    reason: str
    n: int
    start: float
    width: float


@dataclass(frozen=True, slots=True)
class FirstFailures:
    """What went wrong first in the episodes of a row.

    Attributes:
        entry: The row.
        n_episodes: Its episodes that are not void.
        counts: Episodes by the reason that came first, in the order of `REASONS`.
    """

    entry: Entry
    n_episodes: int
    counts: dict[str, int]

    @property
    def percentage(self) -> float:
        """Failed episodes [%]; zero where there are no episodes."""
        return self.share(sum(self.counts.values()))

    def share(self, n: int) -> float:
        """So many episodes in per cent of all; zero where there are none."""
        return 100.0 * n / self.n_episodes if self.n_episodes else 0.0

    @property
    def segments(self) -> list[Segment]:
        """The parts of a bar that is as long as the percentage of failed episodes."""
        found, start = [], 0.0
        for reason, n in self.counts.items():
            found.append(Segment(reason, n, start, self.share(n)))
            start += self.share(n)
        return found


@dataclass(frozen=True, slots=True)
class HardPosture:
    """A posture that several rows failed to dress.

    Attributes:
        posture: As the pictured episode dressed it.
        failed: Its failed episodes, in the order of the protocol.
        n_episodes: All its episodes that are not void.
        pictured: The failed episode to look at: of a policy that learned, if there is one.
    """

    posture: Posture
    failed: tuple[EpisodeResult, ...]
    n_episodes: int
    pictured: EpisodeResult


def valid(results: Iterable[EpisodeResult]) -> list[EpisodeResult]:
    """Results that count: those that are not void."""
    return [result for result in results if result.outcome.invalid is None]


def elbow_axis(results: Sequence[EpisodeResult]) -> Axis:
    """Axis of elbow flexion [deg], its ticks the edges of the bins; covers all valid results."""
    bends = [result.posture.elbow_deg for result in valid(results)] or [0.0]

    def edges(width: int) -> range:
        first = math.floor(min(bends) / width)
        last = max(math.ceil(max(bends) / width), first + 1)
        return range(first * width, last * width + 1, width)

    found = next((e for e in map(edges, _BIN_WIDTHS_DEG) if len(e) <= _MOST_BINS + 1), edges(30))
    return Axis(found[0], found[-1], tuple(map(float, found)))


def elbow_curves(protocol: Protocol, results: Sequence[EpisodeResult], axis: Axis) -> list[Curve]:
    """Success against elbow flexion, a curve a row; a bin without episodes has no point.

    A point stands at the mean flexion of its bin's episodes. A flexion on an edge belongs to the
    bin on its right, on the last edge to the last bin.
    """
    return [
        _elbow_curve(entry, valid(r for r in results if r.entry == entry), axis)
        for entry in protocol.entries
    ]


def _elbow_curve(entry: Entry, results: Sequence[EpisodeResult], axis: Axis) -> Curve:
    points = []
    for low, high in zip(axis.ticks[:-1], axis.ticks[1:], strict=True):
        closed = high == axis.high
        inside = [
            r
            for r in results
            if low <= r.posture.elbow_deg < high or (closed and r.posture.elbow_deg == high)
        ]
        if inside:
            mean = sum(r.posture.elbow_deg for r in inside) / len(inside)
            points.append(Point.of(mean, sum(r.outcome.success for r in inside), len(inside)))
    return Curve(
        entry,
        tuple(points),
        tuple(r.posture.elbow_deg for r in results if r.outcome.success),
        tuple(r.posture.elbow_deg for r in results if not r.outcome.success),
    )


def budget_curves(protocol: Protocol, results: Sequence[EpisodeResult]) -> list[Curve]:
    """Success against the number of demonstrations, a curve a policy.

    Only policies that were shown the first n postures (``NAME:n``) of a suite for several n.
    """
    groups: dict[tuple[str, str, tuple[str, ...]], list[tuple[int, Entry]]] = {}
    for entry in protocol.entries:
        shown = entry.demonstrations or ""
        suite, _, number = shown.rpartition(":")
        # In random:N and random:N:SEED the last number means something else.
        if suite and number.isdecimal() and not shown.startswith("random:"):
            key = entry.policy, suite, entry.variation
            groups.setdefault(key, []).append((int(number), entry))
    curves = []
    for members in groups.values():
        points = []
        for n, entry in sorted(members, key=lambda member: member[0]):
            inside = valid(r for r in results if r.entry == entry)
            if inside:
                points.append(Point.of(n, sum(r.outcome.success for r in inside), len(inside)))
        if len(points) > 1:
            curves.append(Curve(members[0][1], tuple(points)))
    return curves


def first_failure(outcome: Outcome) -> Failure | None:
    """What went wrong first; what has no time was wrong from the start. None for a success.

    A caught sleeve is found out by the limit that it exceeds, a moment before it stops the robot:
    of failures as near in time as that, the first of `REASONS` counts.
    """
    times = [0.0 if failure.time is None else failure.time for failure in outcome.failures]
    # Failures come in the order of REASONS. Times are sums of steps, hence the slack.
    return next(
        (
            failure
            for failure, time in zip(outcome.failures, times, strict=True)
            if time <= min(times) + Thresholds().moment + _SLACK
        ),
        None,
    )


def first_failures(protocol: Protocol, results: Sequence[EpisodeResult]) -> list[FirstFailures]:
    """What went wrong first, by row: each failed episode is counted once."""
    found = []
    for entry in protocol.entries:
        inside = valid(r for r in results if r.entry == entry)
        firsts = [first_failure(r.outcome) for r in inside]
        reasons = [first.reason for first in firsts if first is not None]
        counts = {reason: reasons.count(reason) for reason in REASONS if reason in reasons}
        found.append(FirstFailures(entry, len(inside), counts))
    return found


def hardest(results: Sequence[EpisodeResult], most: int = 6) -> list[HardPosture]:
    """The postures that the largest part of the rows failed to dress, the hardest first.

    Equally hard ones come in the order of the protocol; those that every row dressed are left out.
    """
    groups: dict[str, list[EpisodeResult]] = {}
    for result in valid(results):
        groups.setdefault(result.posture.name, []).append(result)
    found = []
    for group in groups.values():
        failed = tuple(r for r in group if not r.outcome.success)
        if failed:
            learned = (r for r in failed if r.entry.demonstrations is not None)
            pictured = next(learned, failed[0])
            found.append(HardPosture(pictured.posture, failed, len(group), pictured))
    found.sort(key=lambda hard: -len(hard.failed) / hard.n_episodes)
    return found[:most]


def symmetric_axis(values: Iterable[float]) -> Axis:
    """Axis around zero that holds all values, in steps for people."""
    farthest = max(map(abs, values), default=0.0)
    reach = _first_above(farthest, (10.0, 20.0, 40.0, 60.0, 80.0, 100.0))
    return Axis(-reach, reach, tuple(reach * part for part in (-1.0, -0.5, 0.0, 0.5, 1.0)))


def share_axis(largest: float) -> Axis:
    """Axis from zero that holds a percentage, in steps for people."""
    reach = _first_above(largest, (20.0, 40.0, 60.0, 80.0, 100.0))
    return Axis(0.0, reach, tuple(reach * part for part in (0.0, 0.25, 0.5, 0.75, 1.0)))


def number_axis(curves: Sequence[Curve]) -> Axis:
    """Axis with a tick for each whole number from the first to the last point of curves."""
    numbers = [point.x for curve in curves for point in curve.points] or [0.0]
    low, high = min(numbers), max(numbers)
    return Axis(low - 0.5, high + 0.5, tuple(float(n) for n in range(int(low), int(high) + 1)))


def _first_above(value: float, steps: Sequence[float]) -> float:
    return next((step for step in steps if value <= step), steps[-1])
