"""A run in numbers: what ``summary.json`` holds."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.claims import judge_claims
from dressing_sim.benchmark.analysis.comparisons import comparisons
from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.analysis.ranks import ranked
from dressing_sim.benchmark.analysis.statistics import rate_interval_over_sets
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.provenance import versions

#: Seed of the bootstrap: the same results give the same summary.
_BOOTSTRAP_SEED = 0


def summarise(
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    config: Mapping[str, Any],
    robot: str | None = None,
) -> dict[str, Any]:
    """Success rates by row, with Wilson intervals, and what they say of the paper's claims.

    Void episodes count neither way; those in which a policy abstained count as no success, and a
    row that has some also has ``n_abstained`` and, of the others, ``n_attempted``,
    ``pc_success_attempted`` and ``pc_success_attempted_ci95``. With several demonstration sets, a
    row that learned also has its rates by set,
    ``"sets": [{"demonstration_set", "n_episodes", "n_success", "pc_success"}]``,
    and ``pc_success_ci95_sets``, see `rate_interval_over_sets`. Where another robot than the
    benchmark's dressed, every row has its name as ``robot``.

    Where many methods learned they have ``ranks``, see `Ranked`.

    Returns:
        ``{"rows": [...], "comparisons": [...], "claims": [...], "versions": {...},
        "config": {...}}``, percentages from 0 to 100; it does not depend on the order in which
        the results come.
    """
    episodes = EpisodeTable.of(results)
    places = [one.to_dict() for one in ranked(episodes, _generator())]
    told = {} if robot is None else {"robot": robot}
    return {
        "rows": [{**row, **told} for row in summary_rows(protocol, episodes)],
        "comparisons": comparisons(episodes, _generator()),
        **({"ranks": places} if places else {}),
        "claims": [claim.to_dict() for claim in judge_claims(episodes, _generator())],
        "versions": versions(),
        "config": {
            "protocol": protocol.name,
            "suite": protocol.suite,
            "demonstration_sets": protocol.demonstration_sets,
            **config,
        },
    }


def summary_rows(protocol: Protocol, episodes: EpisodeTable) -> list[dict[str, Any]]:
    """The ``rows`` of `summarise`, one for each of the protocol's."""
    sets = range(protocol.demonstration_sets if protocol.demonstration_sets > 1 else 0)
    return [_row(entry, episodes.of_entry(entry), sets) for entry in protocol.entries]


def _generator() -> np.random.Generator:
    """A new one for each part of a summary, so that none depends on what else is in it."""
    return np.random.default_rng(_BOOTSTRAP_SEED)


def _row(entry: Entry, episodes: EpisodeTable, sets: Sequence[int]) -> dict[str, Any]:
    rate = episodes.rate
    row = {
        **entry.to_dict(),
        **_numbers(rate),
        "pc_success_ci95": list(rate.interval),
        "failures": episodes.reasons,
        "n_void": rate.n_void,
    }
    if sets and entry.demonstrations is not None:
        row["sets"] = [
            {"demonstration_set": i, **_numbers(episodes.where(episodes.sets == i).rate)}
            for i in sets
        ]
        over_sets = rate_interval_over_sets(episodes.row, _generator())
        if over_sets is not None:
            row["pc_success_ci95_sets"] = [100.0 * bound for bound in over_sets]
    if episodes.abstained.any():
        row |= _attempted(episodes)
    return {**row, "inputs": entry.inputs}


def _attempted(episodes: EpisodeTable) -> dict[str, Any]:
    """Of a row whose policy abstained: the rate of those that it tried, besides that of all."""
    tried = episodes.where(~episodes.abstained).rate
    return {
        "n_abstained": int(episodes.abstained.sum()),
        "n_attempted": tried.n,
        "pc_success_attempted": tried.percent,
        "pc_success_attempted_ci95": list(tried.interval),
    }


def _numbers(rate: Rate) -> dict[str, Any]:
    return {"n_episodes": rate.n, "n_success": rate.n_success, "pc_success": rate.percent}
