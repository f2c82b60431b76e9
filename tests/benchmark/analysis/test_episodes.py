import numpy as np
import pytest
from fake_results import FULL, HIT, SMALL, STUCK, SUCCESS, VOID, random_results, results_of

from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate, count
from dressing_sim.benchmark.analysis.statistics import wilson_interval


def test_an_invalid_episode_counts_neither_way():
    rate = Rate.of([True, False, None, True, None])
    assert (rate.n_success, rate.n_failed, rate.n, rate.n_void) == (2, 1, 3, 2)
    assert rate.percent == pytest.approx(200.0 / 3.0)
    assert rate.interval == tuple(100.0 * bound for bound in wilson_interval(2, 3))


def test_no_episodes_have_no_rate():
    assert Rate.of([]).percent is None
    assert Rate.of([None]).interval == (0.0, 100.0)
    assert len(EpisodeTable.of([])) == 0
    assert EpisodeTable.of([]).of_entry(SMALL.entries[0]).rate == Rate(0, 0, 0)


def test_columns_come_in_the_order_of_the_protocol_whatever_the_results():
    results = random_results(FULL, 12)
    table, again = EpisodeTable.of(results[::-1]), EpisodeTable.of(results)
    assert table.results == again.results == tuple(results)
    assert table.successes == again.successes
    np.testing.assert_array_equal(table.elbow_deg, [r.posture.elbow_deg for r in results])
    np.testing.assert_array_equal(table.valid, [r.outcome.invalid is None for r in results])


def test_rows_and_masks_partition_the_episodes():
    results = random_results(FULL, 30)
    table = EpisodeTable.of(results)
    assert sum(len(rows) for rows in table.by_entry.values()) == len(table) == len(results)
    for entry in FULL.entries:
        own = [result for result in results if result.entry == entry]
        assert table.of_entry(entry).rate == count(own)
        assert table.rows[entry] == table.where([r.entry == entry for r in table.results]).row
    sets = [table.where(table.sets == number).rate for number in range(5)]
    assert sum(rate.n_success for rate in sets) == table.rate.n_success
    assert sum(rate.n_void for rate in sets) == table.rate.n_void > 0


def test_reasons_are_those_of_episodes_that_count():
    table = EpisodeTable.of(results_of(SMALL, [[STUCK, VOID], [HIT, SUCCESS], [STUCK, HIT]]))
    assert table.reasons == {"stuck": 2, "hit": 2, "over_strain": 2}
    assert list(table.reasons) == ["stuck", "hit", "over_strain"]


def test_other_verdicts_leave_all_else_as_it_is():
    table = EpisodeTable.of(results_of(SMALL, [[SUCCESS, HIT], [SUCCESS, HIT], [VOID, HIT]]))
    judged = table.judged([None, True, True, False, True, False])
    assert judged.successes == [None, True, True, False, True, False]
    assert (judged.rate.n_success, judged.rate.n_void) == (3, 1)
    assert judged.results == table.results
    assert table.rate == Rate(2, 5, 1)
