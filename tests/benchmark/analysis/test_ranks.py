import numpy as np
import pytest
from fake_results import outcome_of, row_of_episodes

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.ranks import FEWEST, ranked
from dressing_sim.benchmark.records import Entry

NAMES = [f"method{i}" for i in range(FEWEST)]


def episodes(entry, successes, sets=5):
    """Of one row, with so many demonstration sets; None is void."""
    return row_of_episodes(entry, map(outcome_of, successes), sets)


def table(outcomes, cases=("case_a", "case_b")):
    """Methods with these outcomes from each case."""
    rows = (episodes(Entry(name, case), own) for name, own in outcomes.items() for case in cases)
    return EpisodeTable.of([episode for row in rows for episode in row])


def rank(outcomes, **options):
    return ranked(table(outcomes, **options), np.random.default_rng(0))


def rising(n=100):
    """Each method dresses the arms of the one before and some more."""
    return {name: [i < 10 * (place + 1) for i in range(n)] for place, name in enumerate(NAMES)}


def test_methods_stand_by_their_rates_the_best_first():
    found = rank(rising())
    assert [one.policy for one in found] == NAMES[::-1]
    assert [one.rank for one in found] == list(range(1, FEWEST + 1))
    assert [one.pc_success for one in found] == [10.0 * n for n in range(FEWEST, 0, -1)]


def test_what_always_dresses_the_same_arms_and_more_keeps_its_place():
    # The arms are nested, so wherever samples differ from each other the order does not.
    for one in rank(rising(400)):
        assert one.interval[0] <= one.rank <= one.interval[1]
        assert one.interval[1] - one.interval[0] < 2.0


def test_equals_share_the_mean_of_their_places():
    found = rank({name: [1, 0] * 20 for name in NAMES})
    middle = (FEWEST + 1) / 2
    assert all(one.rank == middle and one.interval == (middle, middle) for one in found)


def test_methods_that_hardly_differ_have_wide_intervals():
    rng = np.random.default_rng(1)
    noise = {name: rng.random(40) < 0.5 for name in NAMES}
    assert np.mean([one.interval[1] - one.interval[0] for one in rank(noise)]) > 3.0


def test_the_order_of_methods_does_not_matter():
    turned = dict(reversed(rising().items()))
    assert [one.policy for one in rank(turned)] == [one.policy for one in rank(rising())]


def test_an_episode_that_one_has_void_counts_for_none():
    outcomes = {name: [True] * 10 for name in NAMES}
    outcomes[NAMES[0]] = [None, *[True] * 9]
    outcomes[NAMES[1]] = [False, *[True] * 9]
    assert {one.rank for one in rank(outcomes)} == {(FEWEST + 1) / 2}


def test_few_methods_are_not_ranked_and_nor_are_worlds_or_the_operator():
    few = dict(list(rising().items())[1:])
    assert rank(few) == []
    rows = [e for name, own in few.items() for e in episodes(Entry(name, "case_a"), own)]
    rows += episodes(Entry("expert"), [1] * 10)
    rows += episodes(Entry("other", "case_a", ("friction",)), [1] * 10)
    assert ranked(EpisodeTable.of(rows), np.random.default_rng(0)) == []


@pytest.mark.parametrize("extra", ["baseline7", "case_a"])
def test_methods_are_ranked_over_demonstrations_that_most_of_them_had(extra):
    rows = [
        e
        for name, own in rising().items()
        for case in ("case_a", "case_b")
        for e in episodes(Entry(name, case), own)
    ]
    # One of few on other demonstrations, or one that lacks a case.
    rows += episodes(Entry("more", extra), [1] * 100)
    found = ranked(EpisodeTable.of(rows), np.random.default_rng(0))
    assert [one.policy for one in found] == NAMES[::-1]
