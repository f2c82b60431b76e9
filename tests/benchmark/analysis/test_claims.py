import json
from types import SimpleNamespace

import numpy as np
import pytest
from fake_results import row_of_episodes

from dressing_sim.benchmark.analysis.claims import judge_claims
from dressing_sim.benchmark.analysis.comparisons import comparisons
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.hypotheses import (
    ALIKE,
    HYPOTHESES,
    MORE,
    NO_LESS,
    NOT_MORE,
    PAPER_TABLE,
)
from dressing_sim.benchmark.records import Entry
from dressing_sim.episode.outcome import Failure, Outcome

SUCCESS, FAILED = Outcome(True), Outcome(False, (Failure("hit", "the hand", 1.0, 0.2),))
STUCK = Outcome(False, (Failure("stuck", "stayed at the elbow", 9.0, 1.0, "elbow"),))
VOID = Outcome(False, invalid="solver warning")

NAMES = {"i": "tp-gmm", "n": "tp-gmm-noise", "r": "tp-gmm-rf", "b": "tp-gmm-rf-noise"}
SHOWN = {"A": "case_a", "B": "case_b", "7": "baseline7"}


def episodes(entry, outcomes, sets=4):
    return row_of_episodes(entry, outcomes, sets)


def outcomes(percent, n, failed=FAILED):
    """So many successes, spread evenly over the postures, the same ones first in every row."""
    order = np.random.default_rng(11).permutation(n)
    return [SUCCESS if order[i] < round(percent * n / 100) else failed for i in range(n)]


def table(n=200, **percent):
    """Results by row: ``rA=80`` is tp-gmm-rf on case_a with 80 % of n postures dressed."""
    return [
        episode
        for key, value in percent.items()
        for episode in episodes(Entry(NAMES[key[0]], SHOWN[key[1]]), outcomes(value, n))
    ]


def judged(results, seed=0):
    claims = judge_claims(EpisodeTable.of(results), np.random.default_rng(seed))
    return {claim.name: claim for claim in claims}


def verdict(name, **rows):
    return judged(table(**rows))[name].verdict


AS_PAPER = {"iA": 20, "nA": 15, "rA": 80, "bA": 78, "iB": 20, "nB": 15, "rB": 60, "bB": 58}


@pytest.mark.parametrize(
    ("rule", "interval", "expected"),
    [
        (MORE, (0.01, 0.3), "confirmed"),
        (MORE, (0.01, 0.04), "confirmed"),
        (MORE, (0.0, 0.3), "undecided"),
        (MORE, (-0.3, 0.04), "refuted"),
        (MORE, (-0.3, -0.1), "refuted"),
        (NOT_MORE, (0.01, 0.04), "refuted"),
        (NOT_MORE, (0.0, 0.3), "undecided"),
        (NOT_MORE, (-0.3, 0.04), "confirmed"),
        (ALIKE, (-0.1, 0.1), "confirmed"),
        (ALIKE, (-0.11, 0.1), "undecided"),
        (ALIKE, (0.05, 0.2), "undecided"),
        (ALIKE, (0.11, 0.2), "refuted"),
        (ALIKE, (-0.2, -0.11), "refuted"),
        (NO_LESS, (-0.09, 0.5), "confirmed"),
        (NO_LESS, (0.2, 0.5), "confirmed"),
        (NO_LESS, (-0.2, 0.5), "undecided"),
        (NO_LESS, (-0.2, -0.11), "refuted"),
    ],
)
def test_the_interval_decides(rule, interval, expected):
    assert rule.verdict(*interval) == expected
    assert "confirmed" in rule.criterion
    assert "refuted" in rule.criterion


def test_what_the_paper_says_is_confirmed_where_many_postures_say_so():
    claims = judged(table(**AS_PAPER, i7=80))
    assert {name for name, claim in claims.items() if claim.verdict != "confirmed"} == {
        "baseline_fails_at_elbow"
    }
    assert {h.name for h in HYPOTHESES} < set(claims)
    assert "best_matches_baseline" in claims


def test_the_contrary_is_refuted():
    contrary = {"iA": 80, "nA": 95, "rA": 20, "bA": 50, "iB": 20, "nB": 50, "rB": 30, "bB": 50}
    claims = judged(table(**contrary, i7=100))
    for name in (
        "rf_helps_case_a",
        "rf_noise_helps_case_a",
        "noise_does_not_help_case_a",
        "rf_beats_noise_case_a",
        "rf_noise_beats_noise_case_a",
        "rf_like_rf_noise_case_a",
        "case_a_gains_more_rf",
        "case_a_gains_more_rf_noise",
        "case_a_ends_better_rf",
        "case_a_ends_better_rf_noise",
        "every_policy_fails_somewhere",
    ):
        assert claims[name].verdict == "refuted", name
    assert claims["rf_helps_case_b"].verdict == "confirmed"


def test_five_postures_tell_hardly_anything():
    results = [
        episode
        for (policy, shown), (successes, trials) in PAPER_TABLE.items()
        for episode in episodes(
            Entry(policy, shown), outcomes(100 * successes / trials, trials), sets=1
        )
    ]
    claims = judged(results)
    claims.pop("every_policy_fails_somewhere")
    verdicts = {name: claim.verdict for name, claim in claims.items()}
    assert set(verdicts.values()) == {"undecided"}, verdicts


def test_a_claim_without_its_rows_is_left_out():
    assert set(judged(table(iA=20, rA=80))) == {"rf_helps_case_a"}
    assert judged(table(rA=80, rB=80)).keys() == {"case_a_ends_better_rf"}
    assert "best_matches_baseline" not in judged(table(i7=80, iA=20))
    assert judged([]) == {}


def test_rows_under_variation_decide_nothing():
    varied = Entry("tp-gmm-rf", "case_a", ("friction",))
    results = [*table(iA=50), *episodes(varied, outcomes(100, 200))]
    assert judged(results) == {}
    results += table(rA=20)
    assert judged(results)["rf_helps_case_a"].verdict == "refuted"


def test_the_same_generator_gives_the_same_claims_whatever_else_is_there():
    first = judged(table(iA=20, rA=35, n=60), seed=3)
    assert judged(table(iA=20, rA=35, n=60), seed=3) == first
    more = judged(table(iB=70, rA=35, iA=20, n=60), seed=3)
    assert more["rf_helps_case_a"] == first["rf_helps_case_a"]


def test_a_claim_reads_as_its_comparison():
    results = table(iA=20, rA=35, n=60)
    (claim,) = judge_claims(EpisodeTable.of(results), np.random.default_rng(4))
    (row,) = comparisons(EpisodeTable.of(results), np.random.default_rng(4))
    assert claim.numbers["pc_difference"] == row["pc_difference"]
    assert claim.numbers["pc_difference_ci95"] == row["pc_difference_ci95"]


def test_the_numbers_are_in_the_sentence_and_in_plain_values():
    results = table(iA=20, rA=80, n=40)
    results[0].outcome = VOID
    (claim,) = judge_claims(EpisodeTable.of(results), np.random.default_rng(0))
    numbers = claim.numbers
    assert (numbers["n_episodes"], numbers["n_void"]) == (39, 1)
    low, high = numbers["pc_difference_ci95"]
    assert low < numbers["pc_difference"] < high
    for part in (
        f"tp-gmm-rf on case_a {100 * numbers['rows'][0]['n_success'] / 39:.3g} %",
        f"{numbers['pc_difference']:+.3g} points",
        f"{low:+.0f} to {high:+.0f}",
        "39 episodes, 1 void left out",
    ):
        assert part in claim.detail
    assert json.loads(json.dumps(claim.to_dict(), allow_nan=False))["verdict"] == "confirmed"


def test_without_a_valid_episode_a_claim_is_undecided():
    results = [
        *episodes(Entry("tp-gmm-rf", "case_a"), [VOID] * 3),
        *table(iA=50, i7=50, n=3),
    ]
    for name, claim in judged(results).items():
        assert claim.verdict == "undecided", name
        json.dumps(claim.to_dict(), allow_nan=False)


def test_gains_are_compared_and_not_end_points():
    rows = {"iA": 50, "rA": 70, "iB": 10, "rB": 60}
    assert verdict("case_a_gains_more_rf", **rows) == "refuted"
    assert verdict("case_a_ends_better_rf", **rows) == "confirmed"
    gains = judged(table(**rows))["case_a_gains_more_rf"]
    assert gains.numbers["pc_difference"] == pytest.approx(-30.0)


@pytest.mark.parametrize(
    ("best", "expected"),
    [(95, "confirmed"), (80, "confirmed"), (60, "refuted"), (71, "undecided")],
)
def test_the_best_augmented_policy_is_held_against_the_baseline(best, expected):
    claim = judged(table(n=400, rA=20, bA=best, rB=30, i7=80))["best_matches_baseline"]
    assert claim.verdict == expected
    assert claim.numbers["rows"][0]["policy"] == "tp-gmm-rf-noise"
    assert claim.numbers["n_candidates"] == 3


def test_the_choice_of_the_best_costs_confidence():
    alone = judged(table(n=80, rA=70, i7=80))["best_matches_baseline"]
    chosen = judged(table(n=80, rA=70, bA=10, rB=10, bB=10, i7=80))["best_matches_baseline"]
    assert np.ptp(chosen.numbers["pc_difference_ci95"]) > np.ptp(
        alone.numbers["pc_difference_ci95"]
    )


@pytest.mark.parametrize(
    ("failed", "expected"),
    [
        ([STUCK] * 20, "confirmed"),
        ([FAILED] * 20, "refuted"),
        ([STUCK, FAILED] * 10, "undecided"),
        ([VOID] * 20, "undecided"),
        ([SUCCESS] * 20, "undecided"),
        ([Outcome(False, (Failure("ik_unreachable", "far"),))] * 20, "refuted"),
    ],
)
def test_where_the_baseline_fails(failed, expected):
    results = episodes(Entry("tp-gmm", "baseline7"), [SUCCESS] * 10 + failed)
    assert judged(results)["baseline_fails_at_elbow"].verdict == expected


@pytest.mark.parametrize(("percent", "expected"), [(99, "confirmed"), (100, "refuted")])
def test_whether_every_policy_fails_somewhere(percent, expected):
    rows = {"iA": 20, "rA": percent, "bA": 60, "iB": 20, "rB": 60, "bB": 40, "i7": 80}
    assert verdict("every_policy_fails_somewhere", **rows, n=100) == expected


def test_a_void_episode_is_no_proof_that_a_policy_dresses_all():
    rows = {"iA": 20, "rA": 60, "bA": 60, "iB": 20, "rB": 60, "bB": 40, "i7": 80}
    results = [r for r in table(n=20, **rows) if r.entry != Entry("tp-gmm-rf", "case_a")]
    results += episodes(Entry("tp-gmm-rf", "case_a"), [SUCCESS] * 19 + [VOID])
    assert judged(results)["every_policy_fails_somewhere"].verdict == "undecided"


def test_claims_are_judged_of_tuned_policies_by_themselves():
    published = table(**{**AS_PAPER, "i7": 60})
    tuned = [
        SimpleNamespace(**{**vars(one), "entry": one.entry.tuned})
        for one in table(iA=80, nA=79, rA=80, bA=20, iB=80, nB=80, rB=81, bB=79, i7=60)
    ]
    both, alone = judged(published + tuned), judged(published)
    assert {name: both[name] for name in alone} == alone
    assert alone["rf_helps_case_a"].verdict == "confirmed"
    assert both["rf_helps_case_a_tuned"].verdict == "refuted"
    assert both["rf_noise_helps_case_a_tuned"].verdict == "refuted"
    assert both["rf_helps_case_a_tuned"].statement == f"tuned: {both['rf_helps_case_a'].statement}"
    assert both["baseline_fails_at_elbow_tuned"].detail.count("tp-gmm-tuned on baseline7") == 1
    assert set(both) == {f"{name}{mark}" for name in alone for mark in ("", "_tuned")}
