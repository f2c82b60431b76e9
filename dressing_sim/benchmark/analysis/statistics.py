"""Success rates with their uncertainty, and rows of a table compared posture by posture.

Every row of a protocol meets the same test postures, dressed by policies that learned from the same
demonstration sets. Differences are therefore taken within pairs (posture, set), which removes what
makes a posture hard from the comparison.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import binomtest

#: Success of each episode of one row by (demonstration set, posture); None where it is void.
Row = Mapping[tuple[int, str], bool | None]

#: Pseudo-episodes that a resampled table is mixed with, see `contrast`.
_PSEUDO_EPISODES = 2.0


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Wilson score interval of a success rate (Wilson 1927).

    Both bounds are from 0 to 1, as is the confidence; (0, 1) where there were no trials.
    """
    if trials == 0:
        return 0.0, 1.0
    interval = binomtest(successes, trials).proportion_ci(confidence, method="wilson")
    return float(interval.low), float(interval.high)


def mcnemar_p(only_a: int, only_b: int) -> float:
    """Exact two-sided McNemar test: binomial on the pairs in which one alone succeeds.

    The p-value is 1 where no pair differs. It takes pairs as independent.
    """
    discordant = only_a + only_b
    return float(binomtest(only_a, discordant).pvalue) if discordant else 1.0


def holm(p_values: Sequence[float]) -> list[float]:
    """P-values corrected for their number, in the same order (Holm 1979).

    Rejecting those at or below a level keeps the chance of any false rejection among all of them
    below it, whatever their dependence.
    """
    order = np.argsort(p_values, kind="stable")
    left = len(p_values) - np.arange(len(p_values))
    rising = np.maximum.accumulate(left * np.asarray(p_values, dtype=float)[order])
    corrected = np.empty(len(p_values))
    corrected[order] = np.minimum(rising, 1.0)
    return [float(p) for p in corrected]


@dataclass(frozen=True, slots=True)
class Contrast:
    """A weighted sum of the success rates of several rows, over episodes they have in common.

    Attributes:
        weights: Weight of each row.
        successes: Successes of each row, over the same episodes.
        n: Episodes that all rows have and none has void.
        n_void: Episodes that all rows have, left out because one of them is void.
        interval: Bootstrap interval of the weighted sum.
    """

    weights: tuple[int, ...]
    successes: tuple[int, ...]
    n: int
    n_void: int
    interval: tuple[float, float]

    @property
    def estimate(self) -> float:
        """The weighted sum of success rates; not a number where nothing is in common."""
        return float(np.dot(self.weights, self.successes)) / self.n if self.n else float("nan")


def contrast(
    rows: Sequence[Row],
    weights: Sequence[int],
    rng: np.random.Generator,
    confidence: float = 0.95,
    n_resamples: int = 10_000,
) -> Contrast:
    """A weighted sum of success rates with a two-level percentile bootstrap interval.

    With y_k the success (0 or 1) of row k in one episode and w_k its weight, each episode has the
    value d = sum_k w_k y_k, and the sum of rates is the mean of d. Policies that learned from one
    demonstration set share its luck, so sets are drawn with replacement first and then, within each
    set drawn, as many episodes as it has (Davison and Hinkley 1997, Bootstrap Methods and their
    Application, Section 3.8). With one set only postures are drawn: the interval then speaks of
    other postures, not of other demonstrations.

    Where all pairs agree a plain bootstrap has no width at all, however few they are. Each table is
    therefore mixed with two pseudo-episodes whose outcomes are fair coins, spread over the sets.
    For two rows this adds 1/2 to each of the four cells, as Agresti and Min (2005, Statistics in
    Medicine 24, 729-740) do for matched pairs. It affects the interval, never the estimate.

    Where sets do not differ the interval is wider than need be. Five sets that differ strongly tell
    little of sets in general: there 95 % is nearer to 90 %.

    Args:
        rows: Episodes of each row.
        weights: Weight of each row, whole numbers.
        rng: Source of randomness.
        confidence: Coverage, between 0 and 1.
        n_resamples: Number of bootstrap samples.

    Returns:
        The contrast; where nothing is in common its interval is all that is possible.
    """
    common = [key for key in rows[0] if all(key in row for row in rows)]
    keys = [key for key in common if all(row[key] is not None for row in rows)]
    outcomes = np.array([[bool(row[key]) for key in keys] for row in rows], dtype=np.int64)
    values, coins = _values_of_coins(weights)
    if keys:
        index = np.searchsorted(values, np.asarray(weights) @ outcomes)
        _, cluster = np.unique([key[0] for key in keys], return_inverse=True)
        counts = np.zeros((cluster.max() + 1, len(values)), dtype=np.int64)
        np.add.at(counts, (cluster, index), 1)
        means = _resample(counts, values, _PSEUDO_EPISODES * coins, rng, n_resamples)
        tail = 0.5 * (1.0 - confidence)
        low, high = np.quantile(means, [tail, 1.0 - tail])
    else:
        low, high = values[0], values[-1]
    return Contrast(
        weights=tuple(weights),
        successes=tuple(int(n) for n in outcomes.sum(axis=1)),
        n=len(keys),
        n_void=len(common) - len(keys),
        interval=(float(low), float(high)),
    )


def _values_of_coins(weights: Sequence[int]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Values an episode can have, ascending, and how probable each is if outcomes were coins."""
    sums = [sum(np.multiply(weights, coins)) for coins in product((0, 1), repeat=len(weights))]
    values, counts = np.unique(sums, return_counts=True)
    return values, counts / counts.sum()


def _resample(
    counts: NDArray[np.int64],
    values: NDArray[np.int64],
    pseudo: NDArray[np.float64],
    rng: np.random.Generator,
    n_resamples: int,
) -> NDArray[np.float64]:
    """Means of bootstrap samples, shape (n_resamples,).

    Drawing n episodes with replacement is drawing how many have each value: a multinomial.

    Args:
        counts: Episodes of each set with each value, shape (n_sets, n_values).
        values: The values, shape (n_values,).
        pseudo: Pseudo-episodes with each value, shared among the sets, shape (n_values,).
        rng: Source of randomness.
        n_resamples: Number of samples.
    """
    n_sets = len(counts)
    mixed = counts + pseudo / n_sets
    probabilities = mixed / mixed.sum(axis=1, keepdims=True)
    drawn = rng.integers(n_sets, size=(n_resamples, n_sets))
    sizes = counts.sum(axis=1)[drawn]
    samples = rng.multinomial(sizes, probabilities[drawn]).sum(axis=1)
    return (samples @ values) / sizes.sum(axis=1)


def rate_interval_over_sets(row: Row, rng: np.random.Generator) -> tuple[float, float] | None:
    """95 % interval of a row's success rate for other demonstrations too, each bound from 0 to 1.

    That of `contrast` for one row. Wilson's takes all episodes as independent and speaks of the
    demonstrations that were given. None with fewer than two demonstration sets, which say nothing
    of others.
    """
    if len({number for number, _ in row}) < 2:
        return None
    return contrast((row,), (1,), rng).interval


@dataclass(frozen=True, slots=True)
class Paired:
    """Two rows compared over the same postures and demonstration sets.

    Attributes:
        both: Pairs in which both succeed.
        only_a: Pairs in which the first alone does.
        only_b: Pairs in which the second alone does.
        neither: Pairs in which none does.
        n_void: Pairs left out because an episode is void.
        interval: 95 % bootstrap interval of the difference, see `contrast`.
    """

    both: int
    only_a: int
    only_b: int
    neither: int
    n_void: int
    interval: tuple[float, float]

    @property
    def n(self) -> int:
        """Number of pairs."""
        return self.both + self.only_a + self.only_b + self.neither

    @property
    def difference(self) -> float:
        """Success rate of the first less that of the second; not a number without a pair."""
        return (self.only_a - self.only_b) / self.n if self.n else float("nan")

    @property
    def p_value(self) -> float:
        """Exact McNemar test, see `mcnemar_p`."""
        return mcnemar_p(self.only_a, self.only_b)

    @property
    def probability_of_improvement(self) -> float:
        """P(A > B) + P(A = B) / 2 after Agarwal et al. (2021).

        rliable averages over tasks the Mann-Whitney statistic U / (n_a n_b) of the runs on each.
        Here a task is a pair (posture, set), with one run of each row: U is 1 where A alone
        succeeds, 1/2 on a tie, 0 where B alone does. The average is (1 + difference) / 2: on a
        verdict of yes or no it says the same as the difference, on another scale.
        """
        return 0.5 * (1.0 + self.difference)

    @property
    def probability_interval(self) -> tuple[float, float]:
        """95 % interval of the probability of improvement.

        That of the difference, on the other scale: as there is one run a task, tasks are drawn anew
        rather than the runs of each, as rliable does with several.
        """
        low, high = self.interval
        return 0.5 * (1.0 + low), 0.5 * (1.0 + high)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a JSON file; what is not defined is None. Percentages 0 to 100."""
        return {
            "n_pairs": self.n,
            "n_void": self.n_void,
            "n_both": self.both,
            "n_only_a": self.only_a,
            "n_only_b": self.only_b,
            "n_neither": self.neither,
            "pc_difference": 100.0 * self.difference if self.n else None,
            "pc_difference_ci95": [100.0 * bound for bound in self.interval],
            "p_mcnemar": self.p_value,
            "probability_of_improvement": self.probability_of_improvement if self.n else None,
            "probability_of_improvement_ci95": list(self.probability_interval),
        }


def compare(a: Row, b: Row, rng: np.random.Generator, n_resamples: int = 10_000) -> Paired:
    """Compare two rows over the postures and demonstration sets that both have."""
    pairs = [(a[key], b[key]) for key in a if key in b]
    difference = contrast((a, b), (1, -1), rng, n_resamples=n_resamples)
    return Paired(
        both=pairs.count((True, True)),
        only_a=pairs.count((True, False)),
        only_b=pairs.count((False, True)),
        neither=pairs.count((False, False)),
        n_void=difference.n_void,
        interval=difference.interval,
    )
