import json
from dataclasses import replace

import numpy as np
import pytest
from fake_results import outcome_of, row_of_episodes

from dressing_sim.benchmark.analysis.comparisons import comparisons
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import Entry
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.registry import DEFAULT


def episodes(entry, successes, sets=1):
    """Of one row, with so many demonstration sets; None is void."""
    return row_of_episodes(entry, map(outcome_of, successes), sets)


def rng():
    return np.random.default_rng(0)


def pairs(entries):
    results = [episode for entry in entries for episode in episodes(entry, [1, 0, 1])]
    return {
        (
            row["kind"],
            *(Entry(**{**row[side], "variation": tuple(row[side]["variation"])}) for side in "ab"),
        )
        for row in comparisons(EpisodeTable.of(results), rng())
    }


INITIAL_A, INITIAL_B = Entry("tp-gmm", "case_a"), Entry("tp-gmm", "case_b")
RF_A, RF_B = Entry("tp-gmm-rf", "case_a"), Entry("tp-gmm-rf", "case_b")
BASELINE = Entry("tp-gmm", "baseline7")


def test_the_papers_rows_are_compared_with_initial_baseline_and_other_case():
    assert pairs([INITIAL_A, INITIAL_B, RF_A, RF_B, BASELINE]) == {
        ("augmentation", RF_A, INITIAL_A),
        ("augmentation", RF_B, INITIAL_B),
        ("baseline", INITIAL_A, BASELINE),
        ("baseline", INITIAL_B, BASELINE),
        ("baseline", RF_A, BASELINE),
        ("baseline", RF_B, BASELINE),
        ("case", INITIAL_A, INITIAL_B),
        ("case", RF_A, RF_B),
    }


def test_a_budget_is_compared_with_its_last_step():
    two, seven = Entry("tp-gmm", "baseline7:2"), Entry("tp-gmm", "baseline7:7")
    two_rf, seven_rf = Entry("tp-gmm-rf", "baseline7:2"), Entry("tp-gmm-rf", "baseline7:7")
    assert pairs([two, seven, two_rf, seven_rf]) == {
        ("augmentation", two_rf, two),
        ("augmentation", seven_rf, seven),
        ("baseline", two, seven),
        ("baseline", two_rf, seven),
    }


def test_tuned_rows_are_compared_among_themselves_and_with_the_same_as_published():
    untuned = [INITIAL_A, RF_A, BASELINE, Entry("transport", "case_a")]
    tuned = [entry.tuned for entry in untuned]
    ours = untuned[-1]
    among_untuned = pairs(untuned)
    among_tuned = {(k, a.tuned, b.tuned) for k, a, b in among_untuned if k != "default"}
    itself = {("tuning", a, b) for a, b in zip(tuned, untuned, strict=True)}
    against_ours = {("default", one, ours) for one in tuned if one.demonstrations == "case_a"}
    assert pairs(tuned) == among_tuned
    assert pairs(untuned + tuned) == among_untuned | among_tuned | itself | against_ours


def test_rows_under_variation_are_compared_among_themselves_and_with_the_nominal():
    varied = Entry("tp-gmm-rf", "case_a", ("friction",))
    varied_initial = Entry("tp-gmm", "case_a", ("friction",))
    expert, varied_expert = Entry("expert"), Entry("expert", None, ("friction",))
    assert pairs([RF_A, varied, varied_initial, expert, varied_expert]) == {
        ("augmentation", varied, varied_initial),
        ("variation", varied, RF_A),
        ("variation", varied_expert, expert),
    }


def test_a_policy_of_another_s_is_compared_with_the_initial_one_on_the_same_demonstrations():
    names = ("tp-gmm", "my:Mine", "tp-gmm-rf")
    entries = [Entry(name, shown) for name in names for shown in ("case_a", "baseline7")]
    results = [e for entry in entries for e in episodes(entry, [1, 0])]
    found = comparisons(EpisodeTable.of(results), rng())
    pairs = [
        (p["kind"], p["a"]["policy"], p["b"]["policy"], p["a"]["demonstrations"]) for p in found
    ]
    for shown in ("case_a", "baseline7"):
        assert pairs.count(("policy", "my:Mine", "tp-gmm", shown)) == 1
        assert pairs.count(("augmentation", "tp-gmm-rf", "tp-gmm", shown)) == 1
    kinds = [kind for kind, *_ in pairs]
    assert kinds == sorted(kinds, key=["augmentation", "policy", "baseline"].index)


def test_policies_with_other_settings_are_compared_among_themselves():
    rf, initial = Entry("tp-gmm-rf?end_radius=0", "case_a"), Entry("tp-gmm?end_radius=0", "case_a")
    assert pairs([rf, initial]) == {("augmentation", rf, initial)}
    assert pairs([rf, INITIAL_A]) == set()


def test_policies_with_other_settings_are_compared_with_the_same_row_as_chosen():
    rf, initial = Entry("tp-gmm-rf?end_radius=0", "case_a"), Entry("tp-gmm?end_radius=0", "case_a")
    assert pairs([rf, initial, INITIAL_A, RF_B]) == {
        ("augmentation", rf, initial),
        ("settings", initial, INITIAL_A),
    }
    varied, varied_rf = replace(rf, variation=("friction",)), replace(RF_A, variation=("friction",))
    assert pairs([varied, varied_rf]) == {("settings", varied, varied_rf)}


def test_a_comparison_holds_the_counts_as_plain_values():
    results = [*episodes(RF_A, [1, 1, 1, 0, None]), *episodes(INITIAL_A, [1, 0, 0, 0, 1])]
    (row,) = comparisons(EpisodeTable.of(results), rng())
    assert row["a"] == {"policy": "tp-gmm-rf", "demonstrations": "case_a", "variation": []}
    counts = [row[f"n_{key}"] for key in ("both", "only_a", "only_b", "neither", "pairs", "void")]
    assert counts == [1, 2, 0, 1, 4, 1]
    assert row["pc_difference"] == pytest.approx(50.0)
    json.dumps(row, allow_nan=False)


def test_a_comparison_does_not_depend_on_which_others_there_are():
    rf, initial = episodes(RF_A, [1, 1, 0, 1] * 5, 2), episodes(INITIAL_A, [0, 1, 0, 0] * 5, 2)
    alone = comparisons(EpisodeTable.of([*rf, *initial]), rng())
    among = comparisons(EpisodeTable.of([*episodes(RF_B, [1] * 20), *initial, *rf]), rng())
    assert [row for row in among if row["kind"] == "augmentation"] == alone


def test_a_posture_may_occur_once_in_a_row():
    results = episodes(RF_A, [1, 0])
    rows = EpisodeTable.of(results).rows
    assert rows == {RF_A: {(0, "arm0"): True, (0, "arm1"): False}}
    with pytest.raises(InvalidInputError, match=r"tp-gmm-rf on case_a.*'arm1'.*twice"):
        list(EpisodeTable.of([*results, results[1]]).rows)


def test_a_label_says_what_was_shown_and_varied():
    assert Entry("expert").label == "expert"
    varied = Entry("tp-gmm", "case_a", ("friction", "arm"))
    assert varied.label == "tp-gmm on case_a, friction and arm varied"


def test_every_policy_is_held_against_our_own_and_their_number_is_corrected_for():
    others = [INITIAL_A, RF_A, Entry("dmp", "case_a"), Entry("kmp?kernel=3", "case_a")]
    ours, elsewhere = Entry(DEFAULT, "case_a"), Entry("dmp", "case_b")
    rows = [e for entry in others for e in episodes(entry, [0] * 8 + [1] * 4)]
    rows += (
        episodes(ours, [1] * 12) + episodes(elsewhere, [1] * 12) + episodes(Entry("expert"), [1])
    )
    found = comparisons(EpisodeTable.of(rows), rng())
    family = [pair for pair in found if pair["kind"] == "default"]
    assert [Entry.of(pair["a"]) for pair in family] == others
    assert all(Entry.of(pair["b"]) == ours for pair in family)
    for pair in family:
        assert pair["pc_difference"] == pytest.approx(-100 * 8 / 12)
        assert pair["p_holm"] == pytest.approx(min(1.0, len(others) * pair["p_mcnemar"]))
    assert all("p_holm" not in pair for pair in found if pair["kind"] != "default")
