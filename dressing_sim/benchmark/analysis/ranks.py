"""Ranks of methods by success, and how far other demonstrations and arms would move them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from dressing_sim.benchmark.analysis.episodes import EpisodeTable

#: Fewer methods than this are compared pair by pair.
FEWEST = 8

_RESAMPLES = 2000


@dataclass(frozen=True, slots=True)
class Ranked:
    """A method among others.

    Attributes:
        policy: Its name.
        pc_success: Success rate over all demonstrations that the methods learned from [%].
        rank: Its place by that rate, 1 the best; of equals the mean of their places.
        interval: 95 % bootstrap interval of its place.
    """

    policy: str
    pc_success: float
    rank: float
    interval: tuple[float, float]

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a JSON file."""
        return {
            "policy": self.policy,
            "pc_success": self.pc_success,
            "rank": self.rank,
            "rank_ci95": list(self.interval),
        }


def ranked(episodes: EpisodeTable, rng: np.random.Generator) -> list[Ranked]:
    """The methods that learned in the nominal world, the best first.

    Methods are ranked over the demonstrations that at least half of them learned from, those that
    lack one of these are left out, and so are episodes that one of them has void. For the intervals
    sets are drawn with replacement, then within each set drawn as many episodes as it has, the same
    for all methods, and methods are ranked anew (Agarwal et al. 2021 draw ranks in this way).

    Returns:
        Nothing where there are fewer than `FEWEST` methods.
    """
    rows = {
        (entry.policy, entry.demonstrations): table.row
        for entry, table in episodes.by_entry.items()
        if entry.demonstrations is not None and not entry.variation
    }
    policies = list(dict.fromkeys(policy for policy, _ in rows))
    learned_from = Counter(demonstrations for _, demonstrations in rows)
    shown = [name for name, n in learned_from.items() if 2 * n >= len(policies)]
    policies = [policy for policy in policies if all((policy, name) in rows for name in shown)]
    if len(policies) < FEWEST:
        return []
    keys = [
        (name, key)
        for name in shown
        for key in rows[policies[0], name]
        if all(rows[policy, name].get(key) is not None for policy in policies)
    ]
    if not keys:
        return []
    success = np.array(
        [[bool(rows[policy, name][key]) for name, key in keys] for policy in policies], dtype=float
    )
    _, cluster = np.unique([number for _, (number, _) in keys], return_inverse=True)
    rates = success.mean(axis=1)
    places = rankdata(-rates)
    drawn = rankdata(-_resampled(success, cluster, rng), axis=1)
    low, high = np.quantile(drawn, [0.025, 0.975], axis=0)
    found = [
        Ranked(policy, 100.0 * float(rate), float(place), (float(least), float(most)))
        for policy, rate, place, least, most in zip(policies, rates, places, low, high, strict=True)
    ]
    return sorted(found, key=lambda one: one.rank)


def _resampled(
    success: NDArray[np.float64],
    cluster: Sequence[int] | NDArray[np.int64],
    rng: np.random.Generator,
) -> NDArray[np.float64]:
    """Rates of bootstrap samples, shape (_RESAMPLES, methods), of success (methods, episodes)."""
    inside = [np.flatnonzero(np.asarray(cluster) == one) for one in np.unique(cluster)]
    rates = np.empty((_RESAMPLES, len(success)))
    for row in rates:
        sets = rng.integers(len(inside), size=len(inside))
        chosen = np.concatenate([rng.choice(inside[one], len(inside[one])) for one in sets])
        row[:] = success[:, chosen].mean(axis=1)
    return rates
