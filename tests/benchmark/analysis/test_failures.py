from fake_results import EXPERT, FULL, HIT, SMALL, STUCK, SUCCESS, VOID, random_results, results_of

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.failures import hardest, typical
from dressing_sim.benchmark.records import first_failure
from dressing_sim.episode.outcome import Failure, Outcome


def test_each_failed_episode_has_one_first_reason():
    results = random_results(FULL, 50)
    for entry in FULL.entries:
        inside = [r for r in results if r.entry == entry]
        failed = [r for r in inside if r.outcome.invalid is None and not r.outcome.success]
        counts = EpisodeTable.of(inside).first_reasons
        assert sum(counts.values()) == len(failed)
        assert "stuck" not in counts  # the strain came before


def test_first_reasons_come_in_the_order_of_all_reasons_and_leave_void_episodes_out():
    results = results_of(SMALL, [[SUCCESS] * 4, [SUCCESS, STUCK, STUCK, HIT], [VOID] * 4])
    assert list(EpisodeTable.of(results).first_reasons.items()) == [("hit", 1), ("over_strain", 2)]


def test_a_verdict_reads_as_people_say_it():
    abstained = Outcome(False, abstained="too bent")
    assert [outcome.verdict for outcome in (SUCCESS, STUCK, VOID, abstained)] == [
        "success",
        "stuck, over_strain",
        f"void: {VOID.invalid}",
        "abstained",
    ]


def test_the_first_failure_is_the_earliest_and_without_a_time_it_was_there_from_the_start():
    late, early = Failure("stuck", "", 7.0), Failure("over_force", "", 3.0)
    untimed = Failure("ik_unreachable", "")
    assert first_failure(Outcome(False, (late, early))) == early
    assert first_failure(Outcome(False, (early, untimed))) == untimed
    assert first_failure(SUCCESS) is None


def test_a_sleeve_that_was_caught_counts_as_stuck_rather_than_as_the_limit_that_found_it_out():
    stuck, force = Failure("stuck", "", 3.2), Failure("over_force", "", 3.0)
    assert first_failure(Outcome(False, (stuck, force))) == stuck


def test_the_hardest_postures_come_first_and_void_episodes_do_not_count():
    results = results_of(
        SMALL,
        [
            [SUCCESS, SUCCESS, HIT, SUCCESS],
            [STUCK, SUCCESS, HIT, STUCK],
            [SUCCESS, SUCCESS, SUCCESS, VOID],
        ],
    )
    found = hardest(EpisodeTable.of(results))
    assert [hard.pictured.posture.name for hard in found] == ["arm2", "arm3", "arm0"]
    assert [(len(hard.failed), hard.n_episodes) for hard in found] == [(2, 3), (1, 2), (1, 3)]
    assert [r.index for r in found[0].failed] == [2, 6]
    assert hardest(EpisodeTable.of(results), most=1) == found[:1]


def test_of_a_hard_posture_a_policy_that_learned_is_looked_at_if_one_failed():
    results = results_of(SMALL, [[HIT, HIT], [STUCK, SUCCESS], [STUCK, SUCCESS]])
    first, second = hardest(EpisodeTable.of(results))
    assert first.pictured.entry == SMALL.entries[1]
    assert second.pictured.entry == EXPERT


def test_nothing_is_hard_where_all_is_dressed():
    results = results_of(SMALL, [[SUCCESS], [VOID], [SUCCESS]])
    assert hardest(EpisodeTable.of(results)) == []


def reached(outcome, s):
    return Outcome(False, outcome.failures, {"armscye_s": s})


def test_typical_failures_are_the_medians_of_the_reasons_the_most_frequent_first():
    strained = [reached(STUCK, s) for s in (1.4, 0.2, 1.0, 0.6, 0.9)]  # median at place 4
    hits = [reached(HIT, s) for s in (0.5, 0.1)]  # of two the lesser
    line = [SUCCESS, *hits, VOID, *strained]
    row = EpisodeTable.of(results_of(SMALL, [line, [SUCCESS], [SUCCESS]])).of_entry(EXPERT)
    assert [r.index for r in typical(row, 1)] == [8]
    assert [r.index for r in typical(row, 3)] == [8, 2, 7]
    assert [r.index for r in typical(row, 99)] == [8, 2, 7, 1, 6, 5, 4]
    assert typical(row, 0) == []


def test_a_row_without_failures_has_no_typical_one():
    results = results_of(SMALL, [[SUCCESS, VOID]] * 3)
    assert typical(EpisodeTable.of(results).of_entry(EXPERT), 5) == []
