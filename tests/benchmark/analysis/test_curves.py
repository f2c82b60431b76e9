from dataclasses import replace

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
    N_FRICTION_BINS,
    budget_curves,
    elbow_bins,
    elbow_curve,
    friction_bins,
    friction_curve,
)
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import Entry, Protocol


@pytest.fixture(scope="module")
def results():
    return random_results(FULL, 50)


def valid_of(results, entry):
    return [r for r in results if r.entry == entry and r.outcome.invalid is None]


def test_every_valid_episode_is_in_one_bin_of_its_row(results):
    bins = elbow_bins(EpisodeTable.of(results))
    for entry in FULL.entries:
        valid = valid_of(results, entry)
        curve = elbow_curve(EpisodeTable.of(results).of_entry(entry), bins)
        assert sum(rate.n for _, rate in curve) == len(valid)
        assert sum(rate.n_success for _, rate in curve) == sum(r.outcome.success for r in valid)


def test_a_bin_counts_what_lies_between_its_edges(results):
    edges = np.array(elbow_bins(EpisodeTable.of(results)))
    valid = valid_of(results, FULL.entries[3])
    curve = elbow_curve(EpisodeTable.of(valid), list(edges))
    counts, _ = np.histogram([r.posture.elbow_deg for r in valid], edges)
    assert [rate.n for _, rate in curve] == [n for n in counts if n]
    assert all(np.diff(np.searchsorted(edges, [x for x, _ in curve])) >= 1)


def test_bins_are_few_even_and_hold_all_flexions(results):
    bins = elbow_bins(EpisodeTable.of(results))
    bends = [r.posture.elbow_deg for r in results]
    assert bins[0] <= min(bends)
    assert max(bends) <= bins[-1]
    assert 3 <= len(bins) <= 7
    assert len(set(np.diff(bins))) == 1


def test_a_flexion_on_the_last_edge_is_in_the_last_bin():
    protocol = Protocol("p", "s", (EXPERT,))
    results = results_of(protocol, [[SUCCESS] * 7])  # bends of 0, 10, ..., 60 degrees
    bins = elbow_bins(EpisodeTable.of(results))
    assert bins[-1] == 60
    assert elbow_curve(EpisodeTable.of(results), bins)[-1][1].n == 2


def test_without_valid_episodes_there_is_a_bin_and_no_point():
    results = results_of(Protocol("p", "s", (EXPERT,)), [[VOID, VOID]])
    bins = elbow_bins(EpisodeTable.of(results))
    assert bins[0] < bins[-1]
    assert elbow_curve(EpisodeTable.of(results), bins) == []


def test_friction_has_bins_even_in_its_logarithm_that_hold_every_valid_episode(results, rng):
    drawn = [replace(r, variation={"friction": float(rng.uniform(0.2, 1.0))}) for r in results]
    episodes = EpisodeTable.of([*drawn[:100], *results[100:]])
    bins = friction_bins(episodes)
    assert len(bins) == N_FRICTION_BINS + 1
    np.testing.assert_allclose(np.diff(np.log(bins), 2), 0.0, atol=1e-12)
    valid = [r for r in drawn[:100] if r.outcome.invalid is None]
    counts, _ = np.histogram([r.variation["friction"] for r in valid], bins)
    curve = friction_curve(episodes, bins)
    assert sum(rate.n for _, rate in curve) == len(valid)
    assert [rate.n for _, rate in curve] == [n for n in counts if n]
    assert sum(rate.n_success for _, rate in curve) == sum(r.outcome.success for r in valid)
    assert all(np.diff(np.searchsorted(bins, [x for x, _ in curve])) >= 1)


def test_without_a_draw_there_are_no_bins_of_friction(results):
    assert len(friction_bins(EpisodeTable.of(results))) == 0


def test_a_budget_has_a_curve_for_each_policy_from_few_to_many():
    results = random_results(BUDGET, 20)
    curves = budget_curves(BUDGET, EpisodeTable.of(results))
    assert [entry.policy for entry, _ in curves] == ["tp-gmm", "tp-gmm-rf"]
    for _, curve in curves:
        assert [x for x, _ in curve] == [2, 4, 7]
    fewest = valid_of(results, Entry("tp-gmm", "baseline7:2"))
    assert curves[0][1][0][1].n == len(fewest)
    assert curves[0][1][0][1].n_success == sum(r.outcome.success for r in fewest)


@pytest.mark.parametrize(
    "shown", [("case_a", "case_b"), ("random:5", "random:7"), ("random:5:1", "random:5:2")]
)
def test_other_demonstrations_have_no_budget(shown):
    protocol = Protocol("p", "s", tuple(Entry("tp-gmm", name) for name in shown))
    results = results_of(protocol, [[SUCCESS], [HIT]])
    assert budget_curves(protocol, EpisodeTable.of(results)) == []


def test_one_number_of_demonstrations_is_no_curve():
    protocol = Protocol("p", "s", (Entry("tp-gmm", "baseline7:3"),))
    results = results_of(protocol, [[UNREACHABLE]])
    assert budget_curves(protocol, EpisodeTable.of(results)) == []
