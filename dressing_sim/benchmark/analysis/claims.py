"""The paper's claims held against what was measured: confirmed, refuted or undecided.

No correction is made for the number of claims: of twenty verdicts, expect one to be luck.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.analysis.hypotheses import (
    AUGMENTED,
    BASELINE,
    HYPOTHESES,
    NO_LESS,
    PAPER_TABLE,
    Hypothesis,
    Rule,
    Verdict,
)
from dressing_sim.benchmark.analysis.statistics import (
    Contrast,
    Row,
    contrast,
    rate_interval_over_sets,
    wilson_interval,
)
from dressing_sim.benchmark.records import Entry


@dataclass(frozen=True, slots=True)
class Claim:
    """A claim of the paper and what became of it.

    Attributes:
        name: Short name.
        statement: What the paper says.
        verdict: What the results say of it.
        detail: The numbers in one sentence.
        numbers: The same as plain values, percentages from 0 to 100.
    """

    name: str
    statement: str
    verdict: Verdict
    detail: str
    numbers: dict[str, Any]

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a JSON file."""
        return {
            "name": self.name,
            "statement": self.statement,
            "verdict": self.verdict,
            "detail": self.detail,
            "numbers": self.numbers,
        }


def judge_claims(episodes: EpisodeTable, rng: np.random.Generator) -> list[Claim]:
    """Verdicts on the paper's claims.

    Args:
        episodes: Those of a protocol; only nominal rows (without variation) are looked at.
        rng: Source of randomness, of which one number is drawn, as `comparisons` does: with two
            generators alike, the same comparison reads the same in both.

    Returns:
        The claims whose rows are all among the episodes.
    """
    rows = episodes.rows
    seed = int(rng.integers(2**32))
    claims = [
        _claim(hypothesis, rows, seed)
        for hypothesis in HYPOTHESES
        if all(entry in rows for _, entry in hypothesis.terms)
    ]
    candidates = [entry for entry in AUGMENTED if entry in rows]
    if candidates and BASELINE in rows:
        claims.append(_best_matches_baseline(candidates, rows, seed))
    if BASELINE in rows:
        claims.append(_baseline_fails_at_the_elbow(episodes.of_entry(BASELINE), seed))
    learned = [Entry(policy, shown) for policy, shown in PAPER_TABLE]
    if all(entry in rows for entry in learned):
        claims.append(_every_policy_fails_somewhere(learned, rows))
    return claims


def _claim(hypothesis: Hypothesis, rows: Mapping[Entry, Row], seed: int) -> Claim:
    weights, entries = zip(*hypothesis.terms, strict=True)
    measured = contrast([rows[e] for e in entries], weights, np.random.default_rng(seed))
    return Claim(
        hypothesis.name,
        hypothesis.statement,
        hypothesis.rule.verdict(*measured.interval),
        _sentence(entries, measured),
        _numbers(entries, measured, hypothesis.rule),
    )


def _best_matches_baseline(candidates: list[Entry], rows: Mapping[Entry, Row], seed: int) -> Claim:
    """The best is known only after the test, so its interval allows for the choice (Bonferroni)."""
    confidence = 1.0 - 0.05 / len(candidates)
    measured = {
        entry: contrast(
            (rows[entry], rows[BASELINE]), (1, -1), np.random.default_rng(seed), confidence
        )
        for entry in candidates
    }
    best = max(candidates, key=lambda e: measured[e].estimate if measured[e].n else -np.inf)
    entries = best, BASELINE
    sentence = _sentence(entries, measured[best])
    return Claim(
        "best_matches_baseline",
        "the best augmented policy of two demonstrations matches that of seven",
        NO_LESS.verdict(*measured[best].interval),
        f"{sentence}; the interval allows for the best of {len(candidates)} being chosen",
        {**_numbers(entries, measured[best], NO_LESS), "n_candidates": len(candidates)},
    )


def _baseline_fails_at_the_elbow(baseline: EpisodeTable, seed: int) -> Claim:
    """Whether in most of the baseline's failed episodes the sleeve is caught at the elbow."""
    failed = baseline.where(baseline.valid & ~baseline.success)
    at_elbow = {
        (number, posture): any(f.reason == "stuck" and f.where == "elbow" for f in failures)
        for number, posture, failures in zip(
            failed.sets.tolist(), failed.postures, failed.failures, strict=True
        )
    }
    over_sets = rate_interval_over_sets(at_elbow, np.random.default_rng(seed))
    caught = Rate.of(at_elbow.values())
    n, n_failed = caught.n_success, caught.n
    low, high = over_sets or wilson_interval(n, n_failed)
    return Claim(
        "baseline_fails_at_elbow",
        "where the seven-demonstration baseline fails, it is stuck at the elbow",
        "confirmed" if low > 0.5 else "refuted" if high < 0.5 else "undecided",
        f"in {n} of {n_failed} failures of {BASELINE.label} the sleeve was stuck at the elbow, "
        f"95 % interval {100 * low:.0f} to {100 * high:.0f} %",
        {
            "n_failed": n_failed,
            "n_at_elbow": n,
            "pc_at_elbow_ci95": [100.0 * low, 100.0 * high],
            "criterion": "confirmed if the interval is above 50 %, refuted if it is below",
        },
    )


def _every_policy_fails_somewhere(entries: list[Entry], rows: Mapping[Entry, Row]) -> Claim:
    """A fact about the postures of the test, so without an interval."""
    rates = {entry: Rate.of(rows[entry].values()) for entry in entries}
    failures = {entry: rate.n_failed for entry, rate in rates.items()}
    faultless = [
        entry for entry, rate in rates.items() if rate.n and not rate.n_failed + rate.n_void
    ]
    verdict: Verdict = "confirmed" if all(failures.values()) else "undecided"
    fewest = min(entries, key=lambda entry: failures[entry])
    return Claim(
        "every_policy_fails_somewhere",
        "every TP-GMM fails to dress at least one posture",
        "refuted" if faultless else verdict,
        f"fewest failures: {fewest.label}, {failures[fewest]} of {rates[fewest].n}",
        {
            "n_failures": {entry.label: n for entry, n in failures.items()},
            "criterion": "refuted if a policy dressed every posture of the test",
        },
    )


def _sentence(entries: Sequence[Entry], measured: Contrast) -> str:
    if not measured.n:
        return f"no valid episode in common: {', '.join(entry.label for entry in entries)}"
    rates = ", ".join(
        f"{entry.label} {100.0 * successes / measured.n:.3g} %"
        for entry, successes in zip(entries, measured.successes, strict=True)
    )
    what = "difference" if len(entries) == 2 else "difference of gains"
    low, high = (100.0 * bound for bound in measured.interval)
    void = f", {measured.n_void} void left out" if measured.n_void else ""
    return (
        f"{rates}: {what} {100.0 * measured.estimate:+.3g} points, 95 % interval {low:+.0f} to "
        f"{high:+.0f}, over the same {measured.n} episodes{void}"
    )


def _numbers(entries: Sequence[Entry], measured: Contrast, rule: Rule) -> dict[str, Any]:
    return {
        "rows": [
            {
                "policy": entry.policy,
                "demonstrations": entry.demonstrations,
                "weight": weight,
                "n_success": successes,
            }
            for entry, weight, successes in zip(
                entries, measured.weights, measured.successes, strict=True
            )
        ],
        "n_episodes": measured.n,
        "n_void": measured.n_void,
        "pc_difference": 100.0 * measured.estimate if measured.n else None,
        "pc_difference_ci95": [100.0 * bound for bound in measured.interval],
        "criterion": rule.criterion,
    }
