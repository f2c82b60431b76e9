import numpy as np
import pytest
from dressing_sim.benchmark.report.figures import (
    Axis,
    Point,
    budget_curves,
    elbow_axis,
    elbow_curves,
    first_failure,
    first_failures,
    hardest,
    number_axis,
    share_axis,
    symmetric_axis,
)
from fake_results import (
    BUDGET,
    EXPERT,
    FULL,
    HIT,
    SMALL,
    STUCK,
    SUCCESS,
    UNREACHABLE,
    VOID,
    random_results,
    results_of,
)

from dressing_sim.benchmark.analysis.statistics import wilson_interval
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.episode.rules import Failure, Outcome


@pytest.fixture(scope="module")
def results():
    return random_results(FULL, 50)


def valid_of(results, entry):
    return [r for r in results if r.entry == entry and r.outcome.invalid is None]


def test_a_point_has_its_rate_and_wilson_interval_in_per_cent():
    point = Point.of(3.0, 4, 5)
    low, high = wilson_interval(4, 5)
    assert point.rate == 80.0
    assert (point.low, point.high) == (100 * low, 100 * high)


def test_an_axis_places_its_ends_and_its_middle():
    axis = Axis(-20.0, 60.0, (-20.0, 60.0))
    assert [axis.place(value) for value in (-20.0, 20.0, 60.0)] == [0.0, 50.0, 100.0]


def test_every_valid_episode_is_in_one_bin_of_its_row(results):
    axis = elbow_axis(results)
    curves = elbow_curves(FULL, results, axis)
    assert [curve.entry for curve in curves] == list(FULL.entries)
    for curve in curves:
        valid = valid_of(results, curve.entry)
        assert sum(point.trials for point in curve.points) == len(valid)
        assert sum(p.successes for p in curve.points) == sum(r.outcome.success for r in valid)
        assert len(curve.dressed) == sum(point.successes for point in curve.points)
        assert len(curve.dressed) + len(curve.failed) == len(valid)


def test_a_bin_counts_what_lies_between_its_edges(results):
    axis = elbow_axis(results)
    curve = elbow_curves(FULL, results, axis)[3]
    valid = valid_of(results, curve.entry)
    edges = np.array(axis.ticks)
    counts, _ = np.histogram([r.posture.elbow_deg for r in valid], edges)
    assert [point.trials for point in curve.points] == [n for n in counts if n]
    assert all(np.diff(np.searchsorted(edges, [point.x for point in curve.points])) >= 1)


def test_bins_are_few_even_and_hold_all_flexions(results):
    axis = elbow_axis(results)
    bends = [r.posture.elbow_deg for r in results]
    assert axis.low <= min(bends)
    assert max(bends) <= axis.high
    assert 3 <= len(axis.ticks) <= 7
    assert len(set(np.diff(axis.ticks))) == 1
    assert (axis.ticks[0], axis.ticks[-1]) == (axis.low, axis.high)


def test_a_flexion_on_the_last_edge_is_in_the_last_bin():
    protocol = Protocol("p", "s", (EXPERT,))
    results = results_of(protocol, [[SUCCESS] * 7])  # bends of 0, 10, ..., 60 degrees
    axis = elbow_axis(results)
    assert axis.high == 60.0
    (curve,) = elbow_curves(protocol, results, axis)
    assert curve.points[-1].trials == 2


def test_without_valid_episodes_there_is_an_axis_and_an_empty_curve():
    protocol = Protocol("p", "s", (EXPERT,))
    results = results_of(protocol, [[VOID, VOID]])
    axis = elbow_axis(results)
    assert axis.low < axis.high
    (curve,) = elbow_curves(protocol, results, axis)
    assert (curve.points, curve.dressed, curve.failed) == ((), (), ())


def test_the_first_failure_is_the_earliest_and_without_a_time_it_was_there_from_the_start():
    late, early = Failure("stuck", "", 7.0), Failure("over_force", "", 3.0)
    untimed = Failure("ik_unreachable", "")
    assert first_failure(Outcome(False, (late, early))) == early
    assert first_failure(Outcome(False, (early, untimed))) == untimed
    assert first_failure(SUCCESS) is None


def test_a_sleeve_that_was_caught_counts_as_stuck_rather_than_as_the_limit_that_found_it_out():
    stuck, force = Failure("stuck", "", 3.2), Failure("over_force", "", 3.0)
    assert first_failure(Outcome(False, (stuck, force))) == stuck


def test_each_failed_episode_has_one_first_reason(results):
    for failures in first_failures(FULL, results):
        valid = valid_of(results, failures.entry)
        assert failures.n_episodes == len(valid)
        assert sum(failures.counts.values()) == sum(not r.outcome.success for r in valid)
        assert "stuck" not in failures.counts  # the strain came before


def test_segments_follow_one_another_to_the_percentage_of_failures():
    results = results_of(SMALL, [[SUCCESS] * 4, [SUCCESS, STUCK, STUCK, HIT], [VOID] * 4])
    dressed, failed, void = first_failures(SMALL, results)
    assert [(s.reason, s.n, s.start, s.width) for s in failed.segments] == [
        ("hit", 1, 0.0, 25.0),
        ("over_strain", 2, 25.0, 50.0),
    ]
    assert failed.percentage == 75.0
    assert (dressed.percentage, dressed.segments) == (0.0, [])
    assert (void.n_episodes, void.percentage) == (0, 0.0)


def test_the_hardest_postures_come_first_and_void_episodes_do_not_count():
    results = results_of(
        SMALL,
        [
            [SUCCESS, SUCCESS, HIT, SUCCESS],
            [STUCK, SUCCESS, HIT, STUCK],
            [SUCCESS, SUCCESS, SUCCESS, VOID],
        ],
    )
    found = hardest(results)
    assert [hard.posture.name for hard in found] == ["arm2", "arm3", "arm0"]
    assert [(len(hard.failed), hard.n_episodes) for hard in found] == [(2, 3), (1, 2), (1, 3)]
    assert [r.index for r in found[0].failed] == [2, 6]
    assert hardest(results, most=1) == found[:1]


def test_of_a_hard_posture_a_policy_that_learned_is_looked_at_if_one_failed():
    results = results_of(SMALL, [[HIT, HIT], [STUCK, SUCCESS], [STUCK, SUCCESS]])
    first, second = hardest(results)
    assert first.pictured.entry == SMALL.entries[1]
    assert second.pictured.entry == EXPERT


def test_nothing_is_hard_where_all_is_dressed():
    assert hardest(results_of(SMALL, [[SUCCESS], [VOID], [SUCCESS]])) == []


def test_a_budget_has_a_curve_for_each_policy_from_few_to_many():
    results = random_results(BUDGET, 20)
    curves = budget_curves(BUDGET, results)
    assert [curve.entry.policy for curve in curves] == ["tp-gmm", "tp-gmm-rf"]
    for curve in curves:
        assert [point.x for point in curve.points] == [2, 4, 7]
    fewest = valid_of(results, Entry("tp-gmm", "baseline7:2"))
    assert curves[0].points[0].trials == len(fewest)
    assert curves[0].points[0].successes == sum(r.outcome.success for r in fewest)
    axis = number_axis(curves)
    assert axis.ticks == (2.0, 3.0, 4.0, 5.0, 6.0, 7.0)
    assert axis.low < 2.0
    assert axis.high > 7.0


@pytest.mark.parametrize(
    "shown", [("case_a", "case_b"), ("random:5", "random:7"), ("random:5:1", "random:5:2")]
)
def test_other_demonstrations_have_no_budget(shown):
    protocol = Protocol("p", "s", tuple(Entry("tp-gmm", name) for name in shown))
    assert budget_curves(protocol, results_of(protocol, [[SUCCESS], [HIT]])) == []


def test_one_number_of_demonstrations_is_no_curve():
    protocol = Protocol("p", "s", (Entry("tp-gmm", "baseline7:3"),))
    assert budget_curves(protocol, results_of(protocol, [[UNREACHABLE]])) == []


@pytest.mark.parametrize("largest", [0.0, 7.0, 20.0, 21.0, 99.0, 100.0])
def test_axes_hold_their_values_and_end_in_ticks(largest):
    share, symmetric = share_axis(largest), symmetric_axis([-largest, 1.0])
    assert share.low == 0.0
    assert share.high >= largest
    assert symmetric.high == -symmetric.low >= largest
    for axis in (share, symmetric):
        assert (axis.ticks[0], axis.ticks[-1]) == (axis.low, axis.high)
        assert len(axis.ticks) == 5
