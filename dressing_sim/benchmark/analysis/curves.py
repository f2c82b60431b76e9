"""Success rates over the elbow's bend, the skin's friction, the number of demonstrations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.records import Entry, Protocol

#: Success rates, each with its place on the horizontal axis, in the axis' unit.
Curve: TypeAlias = list[tuple[float, Rate]]

#: Widths of a bin of elbow flexion that are tried, the finest first [deg].
_BIN_WIDTHS_DEG = (5, 10, 15, 30)
_MOST_BINS = 6

#: Bins of friction.
N_FRICTION_BINS = 5


def elbow_bins(episodes: EpisodeTable) -> Sequence[int]:
    """Edges of bins of elbow flexion [deg], at most six where possible, of all that counts."""
    bends = episodes.elbow_deg[episodes.valid].tolist() or [0.0]
    edges: Sequence[int] = ()
    for width in _BIN_WIDTHS_DEG:
        first = math.floor(min(bends) / width)
        last = max(math.ceil(max(bends) / width), first + 1)
        edges = range(first * width, last * width + 1, width)
        if len(edges) <= _MOST_BINS + 1:
            break
    return edges


def elbow_curve(episodes: EpisodeTable, bins: Sequence[int]) -> Curve:
    """Success in each bin of elbow flexion, at the mean flexion of its episodes.

    A flexion on an edge belongs to the bin on its right, on the last edge to the last bin. A bin
    without episodes has no rate.
    """
    return _binned(episodes, episodes.elbow_deg, bins)


def friction_bins(episodes: EpisodeTable) -> NDArray[np.float64]:
    """Edges of `N_FRICTION_BINS` bins of friction, even in its logarithm, of all that counts.

    Empty if no friction was drawn.
    """
    drawn = episodes.friction[episodes.valid]
    drawn = drawn[np.isfinite(drawn)]
    return np.geomspace(drawn.min(), drawn.max(), N_FRICTION_BINS + 1) if len(drawn) else drawn


def friction_curve(episodes: EpisodeTable, bins: NDArray[np.float64]) -> Curve:
    """Success in each bin of friction, at the mean friction of its episodes, as `elbow_curve`."""
    drawn = episodes.where(np.isfinite(episodes.friction))
    return _binned(drawn, drawn.friction, bins)


def _binned(episodes: EpisodeTable, values: NDArray[np.float64], edges: ArrayLike) -> Curve:
    """Success in each bin of a value, at the mean of its episodes."""
    valid, inside = episodes.where(episodes.valid), values[episodes.valid]
    # Inner edges alone: what rounding leaves beyond the outer ones is in the outer bins.
    places = np.digitize(inside, np.asarray(edges)[1:-1])
    curve: Curve = []
    for place in range(np.size(edges) - 1):
        here = places == place
        if here.any():
            curve.append((sum(inside[here].tolist()) / int(here.sum()), valid.where(here).rate))
    return curve


def budget_curves(protocol: Protocol, episodes: EpisodeTable) -> list[tuple[Entry, Curve]]:
    """Success against the number of demonstrations, a curve a policy, with the first of its rows.

    Only policies that learned from the first n postures (``NAME:n``) of a suite for several n.
    """
    groups: dict[tuple[str, str, tuple[str, ...]], dict[Entry, int]] = {}
    for entry in protocol.entries:
        suite, _, number = (entry.demonstrations or "").rpartition(":")
        # In random:N and random:N:SEED the last number means something else.
        if suite.partition(":")[0] not in ("", "random") and number.isdecimal():
            key = entry.policy, suite, entry.variation
            groups.setdefault(key, {})[entry] = int(number)
    found = []
    for members in groups.values():
        rates = [(float(n), episodes.of_entry(entry).rate) for entry, n in members.items()]
        curve = sorted((one for one in rates if one[1].n), key=lambda one: one[0])
        if len(curve) > 1:
            found.append((next(iter(members)), curve))
    return found
