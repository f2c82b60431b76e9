"""Success rates over a quantity: over the elbow's bend, over the number of demonstrations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from dressing_sim.benchmark.analysis.failures import valid
from dressing_sim.benchmark.analysis.statistics import wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol

#: Widths of a bin of elbow flexion that are tried, the finest first [deg].
_BIN_WIDTHS_DEG = (5, 10, 15, 30)
_MOST_BINS = 6


@dataclass(frozen=True, slots=True)
class Point:
    """A success rate at a place on the horizontal axis.

    Attributes:
        x: Place, in the axis' unit.
        successes: Number of successes.
        trials: Number of trials, above zero.
    """

    x: float
    successes: int
    trials: int

    @property
    def rate(self) -> float:
        """Success rate [%]."""
        return 100.0 * self.successes / self.trials

    @property
    def interval(self) -> tuple[float, float]:
        """The rate's 95 % Wilson interval [%]."""
        low, high = wilson_interval(self.successes, self.trials)
        return 100.0 * low, 100.0 * high


def rate_at(x: float, results: Sequence[EpisodeResult]) -> Point:
    """The success rate of results, of which there are some and none is void."""
    return Point(x, sum(result.outcome.success for result in results), len(results))


def elbow_bins(results: Sequence[EpisodeResult]) -> tuple[int, ...]:
    """Edges of bins of elbow flexion [deg], at most six where possible, of all valid results."""
    bends = [result.posture.elbow_deg for result in valid(results)] or [0.0]

    def edges(width: int) -> range:
        first = math.floor(min(bends) / width)
        last = max(math.ceil(max(bends) / width), first + 1)
        return range(first * width, last * width + 1, width)

    found = map(edges, _BIN_WIDTHS_DEG)
    return tuple(next((e for e in found if len(e) <= _MOST_BINS + 1), edges(_BIN_WIDTHS_DEG[-1])))


def elbow_points(results: Sequence[EpisodeResult], bins: Sequence[int]) -> list[Point]:
    """Success in each bin of elbow flexion, at the mean flexion of its episodes.

    A flexion on an edge belongs to the bin on its right, on the last edge to the last bin. A bin
    without episodes has no point.
    """
    points = []
    for low, high in pairwise(bins):
        closed = high == bins[-1]
        inside = [
            r
            for r in valid(results)
            if low <= r.posture.elbow_deg < high or (closed and r.posture.elbow_deg == high)
        ]
        if inside:
            mean = sum(r.posture.elbow_deg for r in inside) / len(inside)
            points.append(rate_at(mean, inside))
    return points


def budget_curves(
    protocol: Protocol, results: Sequence[EpisodeResult]
) -> list[tuple[Entry, list[Point]]]:
    """Success against the number of demonstrations, a curve a policy, with the first of its rows.

    Only policies that learned from the first n postures (``NAME:n``) of a suite for several n.
    """
    groups: dict[tuple[str, str, tuple[str, ...]], list[tuple[int, Entry]]] = {}
    for entry in protocol.entries:
        demonstrated = entry.demonstrations or ""
        suite, _, number = demonstrated.rpartition(":")
        # In random:N and random:N:SEED the last number means something else.
        if suite and number.isdecimal() and not demonstrated.startswith("random:"):
            key = entry.policy, suite, entry.variation
            groups.setdefault(key, []).append((int(number), entry))
    curves = []
    for members in groups.values():
        rows = [
            (n, valid(r for r in results if r.entry == entry))
            for n, entry in sorted(members, key=lambda member: member[0])
        ]
        points = [rate_at(n, inside) for n, inside in rows if inside]
        if len(points) > 1:
            curves.append((members[0][1], points))
    return curves
