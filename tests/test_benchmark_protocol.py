import numpy as np
import pytest

from dressing_sim.benchmark.policies import EXPERT, make_policy
from dressing_sim.benchmark.protocol import PROTOCOLS, Entry, Protocol, find_protocol
from dressing_sim.benchmark.suites import load_suite
from dressing_sim.errors import InvalidInputError


def joints(posture):
    """A posture but for its name."""
    return tuple(np.concatenate([posture.wrist, posture.elbow, posture.shoulder]))


@pytest.mark.parametrize("name", PROTOCOLS)
def test_everything_that_a_protocol_names_exists(name):
    protocol = find_protocol(name)
    assert protocol.name == name
    assert load_suite(protocol.suite)
    for entry in protocol.entries:
        if entry.policy == EXPERT:
            assert entry.demonstrations is None
        else:
            make_policy(entry.policy)
            assert load_suite(entry.demonstrations)


def test_no_protocol_tests_on_a_posture_that_it_demonstrates():
    for protocol in PROTOCOLS.values():
        tested = {joints(posture) for posture in load_suite(protocol.suite)}
        for entry in protocol.entries:
            shown = load_suite(entry.demonstrations) if entry.demonstrations else []
            assert not tested & {joints(posture) for posture in shown}


def test_the_paper_compares_the_expert_with_two_cases_and_seven_demonstrations():
    entries = find_protocol("paper").entries
    assert entries[0] == Entry(EXPERT)
    assert [e.demonstrations for e in entries[1:]] == ["case_a", "case_b", "baseline7"]


def test_other_policies_learn_from_every_set_of_demonstrations():
    protocol = Protocol(
        "p", "s", (Entry(EXPERT), Entry("a", "x"), Entry("b", "y"), Entry("b", "x"))
    )
    changed = protocol.with_policies(["new", EXPERT])
    assert changed.entries == (Entry("new", "x"), Entry("new", "y"), Entry(EXPERT))
    assert (changed.name, changed.suite) == ("p", "s")


def test_a_policy_that_is_named_twice_is_one_row():
    protocol = Protocol("p", "s", (Entry(EXPERT), Entry("a", "x")))
    assert protocol.with_policies(["a", EXPERT, "a", EXPERT]).entries == (
        Entry("a", "x"),
        Entry(EXPERT),
    )


def test_an_unknown_protocol_is_an_error_that_says_what_is_valid():
    with pytest.raises(InvalidInputError, match=r"'nope'; valid is one of paper"):
        find_protocol("nope")
