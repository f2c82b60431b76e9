import numpy as np
import pytest
from fake_results import (
    BUDGET,
    EXPERT,
    FULL,
    HIT,
    SUCCESS,
    UNREACHABLE,
    VOID,
    random_results,
    results_of,
)

from dressing_sim.benchmark.analysis.curves import (
    Point,
    budget_curves,
    elbow_bins,
    elbow_points,
)
from dressing_sim.benchmark.analysis.statistics import wilson_interval
from dressing_sim.benchmark.records import Entry, Protocol


@pytest.fixture(scope="module")
def results():
    return random_results(FULL, 50)


def valid_of(results, entry):
    return [r for r in results if r.entry == entry and r.outcome.invalid is None]


def test_a_point_has_its_rate_and_wilson_interval_in_per_cent():
    point = Point(3.0, 4, 5)
    assert point.rate == 80.0
    assert point.interval == tuple(100 * bound for bound in wilson_interval(4, 5))


def test_every_valid_episode_is_in_one_bin_of_its_row(results):
    bins = elbow_bins(results)
    for entry in FULL.entries:
        valid = valid_of(results, entry)
        points = elbow_points([r for r in results if r.entry == entry], bins)
        assert sum(point.trials for point in points) == len(valid)
        assert sum(p.successes for p in points) == sum(r.outcome.success for r in valid)


def test_a_bin_counts_what_lies_between_its_edges(results):
    edges = np.array(elbow_bins(results))
    valid = valid_of(results, FULL.entries[3])
    points = elbow_points(valid, list(edges))
    counts, _ = np.histogram([r.posture.elbow_deg for r in valid], edges)
    assert [point.trials for point in points] == [n for n in counts if n]
    assert all(np.diff(np.searchsorted(edges, [point.x for point in points])) >= 1)


def test_bins_are_few_even_and_hold_all_flexions(results):
    bins = elbow_bins(results)
    bends = [r.posture.elbow_deg for r in results]
    assert bins[0] <= min(bends)
    assert max(bends) <= bins[-1]
    assert 3 <= len(bins) <= 7
    assert len(set(np.diff(bins))) == 1


def test_a_flexion_on_the_last_edge_is_in_the_last_bin():
    protocol = Protocol("p", "s", (EXPERT,))
    results = results_of(protocol, [[SUCCESS] * 7])  # bends of 0, 10, ..., 60 degrees
    bins = elbow_bins(results)
    assert bins[-1] == 60
    assert elbow_points(results, bins)[-1].trials == 2


def test_without_valid_episodes_there_is_a_bin_and_no_point():
    results = results_of(Protocol("p", "s", (EXPERT,)), [[VOID, VOID]])
    bins = elbow_bins(results)
    assert bins[0] < bins[-1]
    assert elbow_points(results, bins) == []


def test_a_budget_has_a_curve_for_each_policy_from_few_to_many():
    results = random_results(BUDGET, 20)
    curves = budget_curves(BUDGET, results)
    assert [entry.policy for entry, _ in curves] == ["tp-gmm", "tp-gmm-rf"]
    for _, points in curves:
        assert [point.x for point in points] == [2, 4, 7]
    fewest = valid_of(results, Entry("tp-gmm", "baseline7:2"))
    assert curves[0][1][0].trials == len(fewest)
    assert curves[0][1][0].successes == sum(r.outcome.success for r in fewest)


@pytest.mark.parametrize(
    "shown", [("case_a", "case_b"), ("random:5", "random:7"), ("random:5:1", "random:5:2")]
)
def test_other_demonstrations_have_no_budget(shown):
    protocol = Protocol("p", "s", tuple(Entry("tp-gmm", name) for name in shown))
    assert budget_curves(protocol, results_of(protocol, [[SUCCESS], [HIT]])) == []


def test_one_number_of_demonstrations_is_no_curve():
    protocol = Protocol("p", "s", (Entry("tp-gmm", "baseline7:3"),))
    assert budget_curves(protocol, results_of(protocol, [[UNREACHABLE]])) == []
