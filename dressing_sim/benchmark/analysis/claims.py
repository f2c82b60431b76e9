"""The paper's claims held against what was measured: confirmed, refuted or undecided.

No correction is made for the number of claims: of twenty verdicts, expect one to be luck.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.analysis.hypotheses import (
    AUGMENTED,
    BASELINE,
    HYPOTHESES,
    MOSTLY,
    PAPER_TABLE,
    Hypothesis,
    Verdict,
)
from dressing_sim.benchmark.analysis.statistics import (
    Contrast,
    Row,
    contrast,
    rate_interval_over_sets,
    wilson_interval,
)
from dressing_sim.benchmark.records import Entry, EpisodeResult


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
        return asdict(self)


def judge_claims(episodes: EpisodeTable, rng: np.random.Generator) -> list[Claim]:
    """Verdicts on the paper's claims.

    Args:
        episodes: Those of a protocol; only nominal rows (without variation) are looked at.
        rng: Source of randomness, of which one number is drawn, as `comparisons` does: with two
            generators alike, the same comparison reads the same in both.

    Returns:
        The claims whose rows are all among the episodes: of the policies as published, then, with
        ``_tuned`` after their names, of the tuned ones.
    """
    seed = int(rng.integers(2**32))
    return _claims(episodes, seed, lambda entry: entry) + [
        replace(claim, name=f"{claim.name}_tuned", statement=f"tuned: {claim.statement}")
        for claim in _claims(episodes, seed, lambda entry: entry.tuned)
    ]


def _claims(episodes: EpisodeTable, seed: int, run: Callable[[Entry], Entry]) -> list[Claim]:
    """Verdicts on claims about policies as they were run: as published, or tuned."""
    rows, baseline = episodes.rows, run(BASELINE)
    claims = [_claim(one, _measured(one, rows, seed)) for one in _known(HYPOTHESES, rows, run)]
    candidates = _known(AUGMENTED, rows, run)
    if candidates:
        claims.append(_best(candidates, rows, seed))
    if baseline in rows:
        claims.append(_baseline_fails_at_the_elbow(episodes.of_entry(baseline), seed, baseline))
    learned = [run(Entry(policy, shown)) for policy, shown in PAPER_TABLE]
    if all(entry in rows for entry in learned):
        claims.append(_every_policy_fails_somewhere(learned, rows))
    return claims


def _known(
    hypotheses: Iterable[Hypothesis], rows: Mapping[Entry, Row], run: Callable[[Entry], Entry]
) -> list[Hypothesis]:
    """The hypotheses about rows as they were run, where all these are there."""
    meant = [
        replace(one, terms=tuple((weight, run(entry)) for weight, entry in one.terms))
        for one in hypotheses
    ]
    return [one for one in meant if all(entry in rows for _, entry in one.terms)]


def _measured(
    hypothesis: Hypothesis, rows: Mapping[Entry, Row], seed: int, confidence: float = 0.95
) -> Contrast:
    weights, entries = zip(*hypothesis.terms, strict=True)
    rng = np.random.default_rng(seed)
    return contrast([rows[entry] for entry in entries], weights, rng, confidence)


def _best(candidates: list[Hypothesis], rows: Mapping[Entry, Row], seed: int) -> Claim:
    """The best is known only after the test, so its interval allows for the choice (Bonferroni)."""
    n = len(candidates)
    measured = [_measured(one, rows, seed, 1.0 - 0.05 / n) for one in candidates]
    best = max(range(n), key=lambda i: measured[i].estimate if measured[i].n else -np.inf)
    note = f"; the interval allows for the best of {n} being chosen"
    return _claim(candidates[best], measured[best], note, n_candidates=n)


def _claim(hypothesis: Hypothesis, measured: Contrast, note: str = "", **more: int) -> Claim:
    terms = list(zip(hypothesis.terms, measured.successes, strict=True))
    low, high = (100.0 * bound for bound in measured.interval)
    estimate = 100.0 * measured.estimate if measured.n else None
    if estimate is None:
        labels = ", ".join(entry.label for _, entry in hypothesis.terms)
        detail = f"no valid episode in common: {labels}"
    else:
        rates = ", ".join(f"{e.label} {100.0 * n / measured.n:.3g} %" for (_, e), n in terms)
        what = "difference" if len(terms) == 2 else "difference of gains"
        void = f", {measured.n_void} void left out" if measured.n_void else ""
        detail = (
            f"{rates}: {what} {estimate:+.3g} points, 95 % interval {low:+.0f} to {high:+.0f}, "
            f"over the same {measured.n} episodes{void}"
        )
    numbers = {
        "rows": [
            {
                "policy": entry.policy,
                "demonstrations": entry.demonstrations,
                "weight": weight,
                "n_success": n_success,
            }
            for (weight, entry), n_success in terms
        ],
        "n_episodes": measured.n,
        "n_void": measured.n_void,
        "pc_difference": estimate,
        "pc_difference_ci95": [low, high],
        "criterion": hypothesis.rule.criterion,
        **more,
    }
    verdict = hypothesis.rule.verdict(*measured.interval)
    return Claim(hypothesis.name, hypothesis.statement, verdict, detail + note, numbers)


def _baseline_fails_at_the_elbow(baseline: EpisodeTable, seed: int, entry: Entry) -> Claim:
    """Whether in most of the baseline's failed episodes the sleeve is caught at the elbow."""
    failed = baseline.where(baseline.failed)
    at_elbow = failed.judged(map(_stuck_at_the_elbow, failed.results))
    caught = at_elbow.rate
    over_sets = rate_interval_over_sets(at_elbow.row, np.random.default_rng(seed))
    low, high = over_sets or wilson_interval(caught.n_success, caught.n)
    return Claim(
        "baseline_fails_at_elbow",
        "where the seven-demonstration baseline fails, it is stuck at the elbow",
        MOSTLY.verdict(low, high),
        f"in {caught.n_success} of {caught.n} failures of {entry.label} the sleeve was stuck "
        f"at the elbow, 95 % interval {100 * low:.0f} to {100 * high:.0f} %",
        {
            "n_failed": caught.n,
            "n_at_elbow": caught.n_success,
            "pc_at_elbow_ci95": [100.0 * low, 100.0 * high],
            "criterion": MOSTLY.criterion,
        },
    )


def _stuck_at_the_elbow(result: EpisodeResult) -> bool:
    return any(f.reason == "stuck" and f.where == "elbow" for f in result.outcome.failures)


def _every_policy_fails_somewhere(entries: list[Entry], rows: Mapping[Entry, Row]) -> Claim:
    """A fact about the postures of the test, so without an interval."""
    rates = {entry: Rate.of(rows[entry].values()) for entry in entries}
    fewest = min(entries, key=lambda entry: rates[entry].n_failed)
    verdict: Verdict = "confirmed" if rates[fewest].n_failed else "undecided"
    # A void episode is no proof that a policy dresses all.
    if any(rate.n and not rate.n_failed + rate.n_void for rate in rates.values()):
        verdict = "refuted"
    return Claim(
        "every_policy_fails_somewhere",
        "every TP-GMM fails to dress at least one posture",
        verdict,
        f"fewest failures: {fewest.label}, {rates[fewest].n_failed} of {rates[fewest].n}",
        {
            "n_failures": {entry.label: rate.n_failed for entry, rate in rates.items()},
            "criterion": "refuted if a policy dressed every posture of the test",
        },
    )
