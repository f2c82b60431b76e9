from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.benchmark.analysis.hypotheses import PAPER_TABLE
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.studies.protocols import PROTOCOLS, find_protocol
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.expert import EXPERT_REPLAN
from dressing_sim.policies.hyperparameters import changed, split_name
from dressing_sim.policies.paper import AUGMENTED, POLICIES
from dressing_sim.policies.registry import DEFAULT, EXPERT, make_policy
from dressing_sim.policies.rivals import POLICIES as RIVALS
from dressing_sim.suites.suites import load_suite


def joints(posture):
    """A posture but for its name."""
    return tuple(np.concatenate([posture.wrist, posture.elbow, posture.shoulder]))


@pytest.mark.parametrize("name", PROTOCOLS)
def test_no_protocol_tests_on_a_posture_that_it_demonstrates(name):
    protocol = find_protocol(name)
    assert protocol.name == name
    tested = {joints(posture) for posture in load_suite(protocol.suite)}
    for entry in protocol.entries:
        suite = split_name(entry.demonstrations)[0] if entry.demonstrations else None
        shown = load_suite(suite) if suite else []
        assert not tested & {joints(posture) for posture in shown}


@pytest.mark.parametrize("name", PROTOCOLS)
def test_only_operators_are_shown_nothing_and_no_row_is_there_twice(name):
    entries, operators = find_protocol(name).entries, {EXPERT, EXPERT_REPLAN}
    assert all((entry.policy in operators) == (entry.demonstrations is None) for entry in entries)
    assert len(set(entries)) == len(entries)


def test_the_paper_compares_the_expert_with_two_cases_and_seven_demonstrations():
    entries = find_protocol("paper").entries
    assert entries[0] == Entry(EXPERT)
    assert {(e.policy, e.demonstrations) for e in entries[1:]} >= set(PAPER_TABLE)
    assert {e.demonstrations for e in entries[1:]} == {"case_a", "case_b", "baseline7"}


def test_the_large_protocols_have_what_they_compare():
    full, paper = find_protocol("full"), find_protocol("paper")
    assert set(full.entries) < set(paper.entries)
    assert {(e.policy, e.demonstrations) for e in full.entries} >= set(PAPER_TABLE)
    assert len(full.entries) == 8
    assert len(load_suite(full.suite)) == 200
    budget, robust = find_protocol("budget"), find_protocol("robust")
    for policy in ("tp-gmm", "tp-gmm-rf"):
        suites = [e.demonstrations for e in budget.entries if e.policy == policy]
        assert [len(load_suite(suite)) for suite in suites] == [2, 3, 4, 5, 6, 7]
    rows = {(e.policy, e.demonstrations) for e in robust.entries}
    compared = {
        (policy, case)
        for policy in ("tp-gmm-tuned", "tp-gmm-rf-noise-tuned", DEFAULT)
        for case in ("case_a", "case_b")
    }
    assert rows == {("expert", None), ("tp-gmm-tuned", "baseline7")} | compared
    variations = {(), ("friction",), ("fabric",), ("arm",)}
    assert {(e.policy, e.demonstrations, e.variation) for e in robust.entries} == {
        (*row, variation) for row in rows for variation in variations
    }
    assert all(len(load_suite(p.suite)) >= 50 for p in (budget, robust))
    assert {p.demonstration_sets for p in (full, budget, robust)} == {5}


def test_the_fair_table_has_each_of_the_papers_rows_as_published_and_tuned():
    fair, full = find_protocol("fair"), find_protocol("full")
    assert (fair.suite, fair.demonstration_sets) == (full.suite, full.demonstration_sets)
    papers = {entry for entry in fair.entries if entry.stem.startswith("tp-gmm")}
    published = {entry for entry in papers if entry == entry.untuned}
    assert published == set(full.entries)
    assert papers - published == {entry.tuned for entry in published}
    shown = {entry.demonstrations for entry in full.entries}
    assert set(fair.entries) - papers == {Entry(EXPERT), *(Entry(DEFAULT, one) for one in shown)}


def test_every_rival_learns_from_the_same_demonstrations_as_the_default():
    rivals = find_protocol("rivals")
    assert (rivals.suite, rivals.demonstration_sets) == ("test200", 5)
    rows = {(e.policy, e.demonstrations) for e in rivals.entries}
    assert rows >= {(p, case) for p in (DEFAULT, *RIVALS) for case in ("case_a", "case_b")}
    assert not any(entry.variation for entry in rivals.entries)


def test_each_row_with_settings_has_its_counterpart_as_chosen():
    protocol = find_protocol("settings")
    assert (len(load_suite(protocol.suite)), protocol.demonstration_sets) == (50, 5)
    as_chosen = {e for e in protocol.entries if "?" not in e.policy}
    assert as_chosen < set(find_protocol("full").entries)
    changed = set(protocol.entries) - as_chosen
    assert {replace(e, policy=e.policy.partition("?")[0]) for e in changed} == as_chosen


@pytest.mark.parametrize("name", {e.policy: None for e in find_protocol("settings").entries})
def test_settings_are_of_policies_that_there_are_and_change_something(name):
    make_policy(name)
    stem, mark, text = name.partition("?")
    assert not mark or changed(POLICIES[stem], text) != POLICIES[stem]
    if stem not in AUGMENTED:
        # An initial policy draws no random situations: it would be the same row once more.
        of_situations = {"situations", "angle_margin_deg", "translation_margin"}
        assert not of_situations & {part.partition("=")[0] for part in text.split("&")}


def test_a_change_is_made_to_all_rows_that_it_can_change():
    entries = find_protocol("settings").entries
    rows: dict[str, set[Entry]] = {}
    for entry in entries:
        stem, _, text = entry.policy.partition("?")
        rows.setdefault(text, set()).add(replace(entry, policy=stem))
    everywhere = rows["end_radius=0"]
    augmented = {e for e in everywhere if e.policy in AUGMENTED}
    # Noise and random frames, each alone, under one change only.
    alone = rows[""] - everywhere
    assert {e.policy for e in alone} == {"tp-gmm-noise", "tp-gmm-rf"}
    assert all(changed - alone in (everywhere, augmented) for changed in rows.values())
    assert [changed >= alone for changed in rows.values()].count(True) == 2


def test_the_cost_is_of_the_augmented_policies_on_both_cases():
    cost = find_protocol("paper-cost")
    assert cost.study == "cost"
    assert {e.demonstrations for e in cost.entries} == {"case_a", "case_b"}
    assert {e.policy for e in cost.entries} == set(AUGMENTED)


def test_other_policies_learn_from_every_set_of_demonstrations_under_every_variation():
    protocol = Protocol(
        "p",
        "s",
        (Entry(EXPERT), Entry("a", "x"), Entry("b", "y"), Entry("b", "x")),
        demonstration_sets=3,
    )
    changed = protocol.with_policies(["new", EXPERT])
    assert changed.entries == (Entry("new", "x"), Entry("new", "y"), Entry(EXPERT))
    assert (changed.name, changed.suite, changed.demonstration_sets) == ("p", "s", 3)
    varied = Protocol("p", "s", (Entry("a", "x"), Entry("a", "x", ("arm",))))
    assert varied.with_policies(["b", EXPERT]).entries == (
        Entry("b", "x"),
        Entry("b", "x", ("arm",)),
        Entry(EXPERT),
        Entry(EXPERT, None, ("arm",)),
    )


def test_a_policy_that_is_named_twice_is_one_row():
    protocol = Protocol("p", "s", (Entry(EXPERT), Entry("a", "x")))
    assert protocol.with_policies(["a", EXPERT, "a", EXPERT]).entries == (
        Entry("a", "x"),
        Entry(EXPERT),
    )


def test_a_variation_holds_for_every_row_and_takes_the_place_of_their_own():
    protocol = Protocol("p", "s", (Entry(EXPERT), Entry("a", "x"), Entry("a", "x", ("arm",))))
    assert protocol.with_variation(["fabric", "grasp", "fabric"]).entries == (
        Entry(EXPERT, None, ("fabric", "grasp")),
        Entry("a", "x", ("fabric", "grasp")),
    )


def test_a_number_after_the_name_means_the_first_postures():
    suite = load_suite("baseline7")
    assert [load_suite(f"baseline7:{n}") for n in range(1, 8)] == [suite[:n] for n in range(1, 8)]
    assert load_suite("baseline7") == suite
    assert len(load_suite("random:2:3")) == 2


@pytest.mark.parametrize("name", ["baseline7:0", "baseline7:8", "baseline7:99"])
def test_more_postures_than_there_are_is_an_error_that_says_how_many(name):
    with pytest.raises(InvalidInputError, match=f"'{name}': valid is 1 to 7"):
        load_suite(name)


@pytest.mark.parametrize("name", ["nowhere", "nowhere:2", "baseline7:x", ":2"])
def test_an_unknown_suite_of_demonstrations_is_an_error(name):
    with pytest.raises(InvalidInputError, match="unknown suite"):
        load_suite(name)


def test_a_protocol_without_demonstration_sets_is_an_error():
    with pytest.raises(InvalidInputError, match="demonstration_sets is 0, valid is 1 or more"):
        Protocol("p", "s", (Entry(EXPERT),), demonstration_sets=0)


def test_an_unknown_protocol_is_an_error_that_says_what_is_valid():
    with pytest.raises(InvalidInputError, match=r"'nope'; valid is one of paper"):
        find_protocol("nope")


def test_the_default_policy_goes_by_its_name_with_settings_too():
    names = ["default", "default?phases=50", "transport"]
    found = find_protocol("paper").with_policies(names)
    assert list(dict.fromkeys(e.policy for e in found.entries)) == [
        "transport",
        "transport?phases=50",
    ]
