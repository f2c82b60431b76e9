"""A run in numbers: what ``summary.json`` holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.claims import judge_claims
from dressing_sim.benchmark.analysis.comparisons import comparisons, rows_by_entry
from dressing_sim.benchmark.analysis.statistics import Row, rate_interval_over_sets, wilson_interval
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.episode.rules import count_reasons
from dressing_sim.provenance import versions

#: Seed of the bootstrap: the same results give the same summary.
_BOOTSTRAP_SEED = 0


def summarise(
    protocol: Protocol, results: Sequence[EpisodeResult], settings: Mapping[str, Any]
) -> dict[str, Any]:
    """Success rates by row, with Wilson intervals, and what they say of the paper's claims.

    Void episodes count neither way. With several demonstration sets, a row that learned also has
    its rates by set, ``"sets": [{"demonstration_set", "n_episodes", "n_success", "pc_success"}]``,
    and ``pc_success_ci95_sets``, see `rate_interval_over_sets`.

    Returns:
        ``{"rows": [...], "comparisons": [...], "claims": [...], "versions": {...},
        "config": {...}}``, percentages from 0 to 100; it does not depend on the order in which
        the results come.
    """
    ordered = sorted(results, key=lambda result: result.index)
    measured = rows_by_entry(ordered)
    return {
        "rows": [
            _row(
                entry,
                [r for r in ordered if r.entry == entry],
                measured.get(entry, {}),
                protocol.demonstration_sets,
            )
            for entry in protocol.entries
        ],
        "comparisons": comparisons(ordered, _generator()),
        "claims": [claim.to_dict() for claim in judge_claims(ordered, _generator())],
        "versions": versions(),
        "config": {
            "protocol": protocol.name,
            "suite": protocol.suite,
            "demonstration_sets": protocol.demonstration_sets,
            **settings,
        },
    }


def _generator() -> np.random.Generator:
    """A new one for each part of a summary, so that none depends on what else is in it."""
    return np.random.default_rng(_BOOTSTRAP_SEED)


def _row(
    entry: Entry, results: Sequence[EpisodeResult], measured: Row, n_sets: int
) -> dict[str, Any]:
    valid = [result for result in results if result.outcome.invalid is None]
    low, high = wilson_interval(_successes(valid), len(valid))
    row = {
        **entry.to_dict(),
        **_rate(valid),
        "pc_success_ci95": [100.0 * low, 100.0 * high],
        "failures": count_reasons([result.outcome for result in valid]),
        "n_void": len(results) - len(valid),
    }
    if n_sets > 1 and entry.demonstrations is not None:
        row["sets"] = [
            {"demonstration_set": i, **_rate([r for r in valid if r.demonstration_set == i])}
            for i in range(n_sets)
        ]
        over_sets = rate_interval_over_sets(measured, _generator())
        if over_sets is not None:
            row["pc_success_ci95_sets"] = [100.0 * bound for bound in over_sets]
    return {**row, "inputs": entry.inputs}


def _rate(valid: Sequence[EpisodeResult]) -> dict[str, Any]:
    successes = _successes(valid)
    return {
        "n_episodes": len(valid),
        "n_success": successes,
        "pc_success": 100.0 * successes / len(valid) if valid else None,
    }


def _successes(results: Sequence[EpisodeResult]) -> int:
    return sum(result.outcome.success for result in results)
