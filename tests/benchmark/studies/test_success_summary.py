import json

import numpy as np
import pytest
from fake_results import (
    FULL,
    HIT,
    ROBUST,
    SMALL,
    STUCK,
    SUCCESS,
    UNREACHABLE,
    VOID,
    random_results,
    results_of,
)

from dressing_sim.benchmark.analysis.claims import judge_claims
from dressing_sim.benchmark.analysis.comparisons import comparisons
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.statistics import rate_interval_over_sets, wilson_interval
from dressing_sim.benchmark.studies.success_summary import summarise
from dressing_sim.episode.demonstration import versions

OUTCOMES = [
    [SUCCESS, SUCCESS, SUCCESS, SUCCESS, VOID],
    [SUCCESS, STUCK, HIT, UNREACHABLE, VOID],
    [VOID],
]
RESULTS = results_of(SMALL, OUTCOMES)


@pytest.fixture
def summary():
    return summarise(SMALL, RESULTS, {"seed": 4})


@pytest.fixture(scope="module")
def full():
    results = random_results(FULL, 50)
    return results, summarise(FULL, results, {"seed": 4})


def test_a_row_counts_episodes_successes_and_reasons_and_void_ones_apart(summary):
    low, high = wilson_interval(1, 4)
    assert summary["rows"][1] == {
        "policy": "tp-gmm",
        "demonstrations": "case_a",
        "variation": [],
        "n_episodes": 4,
        "n_success": 1,
        "pc_success": 25.0,
        "pc_success_ci95": [100 * low, 100 * high],
        "failures": {"ik_unreachable": 1, "stuck": 1, "hit": 1, "over_strain": 1},
        "n_void": 1,
        "inputs": "frames",
    }
    assert summary["rows"][0]["pc_success"] == 100.0
    assert summary["rows"][0]["failures"] == {}


def test_a_row_of_void_episodes_has_no_rate(summary):
    row = summary["rows"][2]
    assert (row["n_episodes"], row["n_success"], row["n_void"]) == (0, 0, 1)
    assert row["pc_success"] is None
    assert row["pc_success_ci95"] == [0.0, 100.0]


def test_a_summary_says_what_it_depends_on(summary):
    assert summary["versions"] == versions()
    assert summary["config"] == {
        "protocol": "small",
        "suite": "five",
        "demonstration_sets": 1,
        "seed": 4,
    }
    assert [row["policy"] for row in summary["rows"]] == ["expert", "tp-gmm", "mine"]


def test_a_row_that_learned_has_a_rate_for_each_set_and_they_add_up(full):
    results, summary = full
    assert "sets" not in summary["rows"][0]
    for entry, row in zip(FULL.entries[1:], summary["rows"][1:], strict=True):
        assert [one["demonstration_set"] for one in row["sets"]] == [0, 1, 2, 3, 4]
        for name in ("n_episodes", "n_success"):
            assert sum(one[name] for one in row["sets"]) == row[name]
        third = [r.outcome for r in results if r.entry == entry and r.demonstration_set == 3]
        assert row["sets"][3]["n_success"] == sum(outcome.success for outcome in third)


def test_a_row_that_learned_from_several_sets_has_an_interval_for_others_too(full):
    results, summary = full
    measured = EpisodeTable.of(results).rows
    for row, entry in zip(summary["rows"], FULL.entries, strict=True):
        expected = rate_interval_over_sets(measured[entry], np.random.default_rng(0))
        if entry.demonstrations is None:
            assert "pc_success_ci95_sets" not in row
        else:
            low, high = 100.0 * np.array(expected)
            assert row["pc_success_ci95_sets"] == pytest.approx([low, high])


def test_one_set_is_not_told_apart(summary):
    assert all("sets" not in row for row in summary["rows"])


def test_rows_of_one_policy_under_different_variation_are_kept_apart():
    results = results_of(ROBUST, [[SUCCESS], [HIT], [VOID]])
    rows = summarise(ROBUST, results, {})["rows"]
    assert [row["variation"] for row in rows] == [[], ["friction"], ["arm", "grasp"]]
    assert [row["n_success"] for row in rows] == [1, 0, 0]
    assert [row["n_void"] for row in rows] == [0, 0, 1]


def test_comparisons_and_claims_are_part_of_a_summary(full):
    results, summary = full
    again = comparisons(EpisodeTable.of(results), np.random.default_rng(0))
    assert summary["comparisons"] == again
    claims = judge_claims(EpisodeTable.of(results), np.random.default_rng(0))
    assert summary["claims"] == [claim.to_dict() for claim in claims]
    # The same comparison reads the same in both.
    intervals = {
        (*(pair[side][key] for side in "ab" for key in ("policy", "demonstrations")),): pair
        for pair in again
    }
    found = 0
    for claim in summary["claims"]:
        rows = claim["numbers"].get("rows", ())
        key = tuple(row[key] for row in rows for key in ("policy", "demonstrations"))
        if key in intervals and "n_candidates" not in claim["numbers"]:
            found += 1
            assert claim["numbers"]["pc_difference_ci95"] == intervals[key]["pc_difference_ci95"]
    assert found > 5
    assert summary["comparisons"]
    assert summary["claims"]


def test_a_summary_is_plain_and_the_same_in_whatever_order_episodes_ended(full):
    results, summary = full
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    again = summarise(FULL, results[::-1], {"seed": 4})
    assert json.dumps(again) == json.dumps(summary)
