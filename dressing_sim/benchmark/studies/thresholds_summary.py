"""How success rates hang on the thresholds of success, and whether their ranking does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import permutations
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.analysis.statistics import Row, compare
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.studies.thresholds_verdicts import (
    FACTORS,
    NAMES,
    TOLERATED,
    scaled,
    verdict_of,
)
from dressing_sim.episode.thresholds import Thresholds, threshold_sources, threshold_units
from dressing_sim.provenance import versions

#: Seed of the bootstrap: the same episodes give the same summary.
_BOOTSTRAP_SEED = 0


def summarise(
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    rules: Thresholds,
    settings: Mapping[str, Any],
) -> dict[str, Any]:
    """Success rates under every variant of the rules, and pairs of rows whose order turns.

    A pair turns if one row is above the other with the threshold as it is, and below it with the
    threshold multiplied; beyond their intervals, if the 95 % bootstrap intervals of both
    differences, posture by posture, exclude zero.

    Args:
        protocol: What was measured.
        results: Its episodes, as from `dress_job`, in any order.
        rules: The thresholds they were recorded with.
        settings: What else is to be told of the run.

    Returns:
        ``{"factors": [...], "thresholds": [{"name", "value", "unit", "source", "values": [...],
        "rows": [...], "turned": [...], "acceptable"}], "n_void", "versions", "config"}``; a row
        has policy, demonstrations, variation, n_episodes, and a list over the factors for each of
        n_success, pc_success and pc_success_ci95 (Wilson), percentages from 0 to 100; what turned
        has factor, above and below (as at factor 1), beyond_intervals, and before and after, as
        from `dressing_sim.benchmark.analysis.statistics.Paired`.
    """
    ordered = sorted(results, key=lambda result: result.index)
    episodes = EpisodeTable.of(ordered)
    told, units = threshold_sources(), threshold_units()
    return {
        "factors": list(FACTORS),
        "thresholds": [
            {
                "name": name,
                "value": getattr(rules, name),
                "unit": units[name],
                "source": told[name],
                "values": [getattr(scaled(rules, name, factor), name) for factor in FACTORS],
                **_sensitivity(protocol, episodes, ordered, name),
            }
            for name in NAMES
        ],
        "n_void": episodes.rate.n_void,
        "versions": versions(),
        "config": {"protocol": protocol.name, "suite": protocol.suite, **settings},
    }


def _sensitivity(
    protocol: Protocol, episodes: EpisodeTable, results: Sequence[EpisodeResult], name: str
) -> dict[str, Any]:
    """What of the summary is about one threshold; `episodes` are the results as a table."""
    by_factor = {
        factor: episodes.judged([verdict_of(result, name, factor) for result in results]).rows
        for factor in FACTORS
    }
    turned = [
        {"factor": factor, **turn}
        for factor, rows in by_factor.items()
        for turn in _turned(by_factor[1.0], rows)
    ]
    low, high = TOLERATED
    return {
        "rows": [
            _rates(entry, [rows.get(entry, {}) for rows in by_factor.values()])
            for entry in protocol.entries
        ],
        "turned": turned,
        "acceptable": not any(
            turn["beyond_intervals"] and low <= turn["factor"] <= high for turn in turned
        ),
    }


def _rates(entry: Entry, rows: Sequence[Row]) -> dict[str, Any]:
    """Success rates of an entry, given its row for each factor."""
    rates = [Rate.of(row.values()) for row in rows]
    return {
        **entry.to_dict(),
        "n_episodes": max(rate.n for rate in rates),
        "n_success": [rate.n_success for rate in rates],
        "pc_success": [rate.percent for rate in rates],
        "pc_success_ci95": [list(rate.interval) for rate in rates],
    }


def _turned(before: Mapping[Entry, Row], after: Mapping[Entry, Row]) -> list[dict[str, Any]]:
    """Pairs of rows of which the first is above before and below after."""
    found = []
    for a, b in permutations(before, 2):
        if not (_lead(before[a], before[b]) > 0 > _lead(after[a], after[b])):
            continue
        first, second = (
            compare(rows[a], rows[b], np.random.default_rng(_BOOTSTRAP_SEED))
            for rows in (before, after)
        )
        found.append(
            {
                "above": a.to_dict(),
                "below": b.to_dict(),
                "beyond_intervals": first.interval[0] > 0.0 > second.interval[1],
                "before": first.to_dict(),
                "after": second.to_dict(),
            }
        )
    return found


def _lead(a: Row, b: Row) -> int:
    """Successes of the first less those of the second, over the episodes that both have."""
    pairs = [(a[key], b[key]) for key in a if key in b]
    return sum(int(x) - int(y) for x, y in pairs if x is not None and y is not None)
