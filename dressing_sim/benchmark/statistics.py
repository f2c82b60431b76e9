"""Success rates with their uncertainty."""

from __future__ import annotations

from scipy.stats import binomtest


def wilson_interval(successes: int, trials: int, confidence: float = 0.95) -> tuple[float, float]:
    """Wilson score interval of a success rate (Wilson 1927).

    Args:
        successes: Number of successes.
        trials: Number of trials.
        confidence: Coverage, between 0 and 1.

    Returns:
        Lower and upper bound, each from 0 to 1; (0, 1) where there were no trials.
    """
    if trials == 0:
        return 0.0, 1.0
    interval = binomtest(successes, trials).proportion_ci(confidence, method="wilson")
    return float(interval.low), float(interval.high)
