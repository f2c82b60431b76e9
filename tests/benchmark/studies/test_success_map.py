import re

from fake_results import (
    EXPERT,
    FULL,
    HIT,
    SMALL,
    STUCK,
    SUCCESS,
    VOID,
    random_results,
    results_of,
)

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import Protocol, first_failure
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.studies.success_map import failure_map
from dressing_sim.episode.rules import rule_colour


def drawn(protocol, outcomes):
    return failure_map(protocol, EpisodeTable.of(results_of(protocol, outcomes)))


def test_the_map_tells_what_went_wrong_first_and_at_which_bend():
    outcomes = [[SUCCESS, HIT, SUCCESS, VOID], [STUCK, STUCK, STUCK, HIT], [VOID] * 4]
    alt = drawn(SMALL, outcomes).alt.split(". ")
    assert alt[0] == (
        "expert: dressed 2, median elbow 10, shoulder 70 deg; hit 1, median elbow 10, "
        "shoulder 70 deg"
    )
    first = first_failure(STUCK).reason
    assert alt[1].startswith(f"tp-gmm on case_a: {first} 3, median elbow 10")
    assert alt[2] == "mine on case_b: no episode counts"


def test_every_episode_that_counts_has_a_mark():
    results = random_results(FULL, 30)
    plot = failure_map(FULL, EpisodeTable.of(results))
    valid = [r for r in results if r.outcome.invalid is None]
    told = [int(n) for n in re.findall(r"(\d+), median", plot.alt)]
    assert sum(told) == len(valid)
    reasons = {first_failure(r.outcome).reason for r in valid if not r.outcome.success}
    assert all(reason in plot.svg for reason in reasons)  # as a comment of the legend's text
    colours = {rule_colour(reason).replace("#000000", plots.BLACK) for reason in reasons}
    assert all(colour in plot.svg for colour in colours)


def test_nothing_that_counts_has_no_map():
    assert drawn(Protocol("p", "s", (EXPERT,)), [[VOID, VOID]]) is None
