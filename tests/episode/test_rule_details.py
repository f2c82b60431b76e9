"""What a rule says in detail: margins in closed form, limits to the row, and where and when."""

from dataclasses import replace

import numpy as np
import pytest
from rule_traces import (
    ARRIVED,
    DT,
    HELD,
    LONG,
    MOMENT,
    ROWS,
    RULES,
    SHOULDER,
    STOPS,
    changed,
    good,
)

from dressing_sim.episode.judge import ProtectiveStop, judge, margins, stopped
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rule import Evidence, Rule
from dressing_sim.episode.rules import REASONS, UNREACHABLE, count_reasons, in_order, rule_colour
from dressing_sim.episode.thresholds import Thresholds

#: Pull at which the fingers lose the cloth [N].
GRIP = 42.0


def margin(name, trace, finished=True, thresholds=None):
    time_left = 0.0 if finished else -1.0
    evidence = Evidence(trace, SHOULDER, time_left, thresholds or Thresholds(), GRIP)
    return margins(evidence)[name]


def failure(trace, reason, finished=True, thresholds=None):
    found = judge(trace, SHOULDER, finished, thresholds).failures
    return next(one for one in found if one.reason == reason)


def test_a_rule_that_says_nothing_ends_nothing_and_has_no_verdict():
    rule, trace = Rule(), good()
    assert (rule.ends, rule.colour, rule.unit, rule.thresholds) == (False, "#999999", "-", ())
    assert rule.exceeded(next(iter(trace.limited())), RULES) == ()
    assert rule.patience(RULES) == 0.0
    with pytest.raises(NotImplementedError, match="rule ''"):
        judge(trace, SHOULDER, True, None, (rule,))
    with pytest.raises(NotImplementedError, match="rule ''"):
        margins(Evidence(trace, SHOULDER), (rule,))


def test_a_path_out_of_reach_fails_before_any_trace():
    assert UNREACHABLE.before_moving("too far") == Failure("ik_unreachable", "too far")
    assert margin("ik_unreachable", good()) == 0.0


def test_a_path_is_finished_or_not():
    assert (margin("timeout", good()), margin("timeout", good(), False)) == (0.0, -1.0)
    late = failure(good(), "timeout", finished=False)
    assert (late.time, late.s) == (pytest.approx(ROWS * DT), good().armscye_s[-1])


@pytest.mark.parametrize("row", [-HELD, -1])
def test_the_gripper_s_margin_is_the_least_of_distance_and_height_while_it_must_hold(row):
    limit = RULES.gripper_distance
    trace = changed("tcp", row, SHOULDER + [0.0, 0.6 * limit, 0.8 * limit])
    assert margin("stopped_short", trace) == pytest.approx(0.0, abs=1e-12)
    trace = changed("tcp", row, SHOULDER + [0.0, 0.42 * limit, 0.56 * limit])
    assert margin("stopped_short", trace) == pytest.approx(0.3 * limit)
    trace = changed("tcp", row, SHOULDER + [0.1 * limit, 0.0, 0.01])
    assert margin("stopped_short", trace) == pytest.approx(0.01)
    trace = changed("tcp", row, SHOULDER + [0.0, 2.4 * limit, 0.7 * limit])
    assert margin("stopped_short", trace) == pytest.approx(-1.5 * limit)
    before = changed("tcp", -HELD - 1, SHOULDER + [0.0, 2.4 * limit, 0.7 * limit])
    assert margin("stopped_short", before) == pytest.approx(0.5 * limit)


def test_the_gripper_may_be_at_the_limit_but_not_at_the_shoulder_s_height():
    # Numbers that a float holds exactly.
    rules, at = replace(RULES, gripper_distance=0.25), slice(-HELD, None)
    trace = good()
    shoulder = np.zeros(3)
    for place, success in (
        ([0.0, 0.0, 0.25], True),
        ([0.0, 0.0, 0.2500001], False),
        ([0.125, 0.0, 0.0], False),
        ([0.125, 0.0, 1e-9], True),
    ):
        trace.tcp[at] = place
        assert judge(trace, shoulder, True, rules).success is success


def test_a_gripper_that_stopped_short_says_how_far_away_it_is_and_whether_below():
    far = failure(changed("tcp", -1, SHOULDER + [0.0, 0.3, 0.4]), "stopped_short")
    assert far.detail == "the gripper ended 0.500 m from the shoulder"
    assert far.time == pytest.approx(ROWS * DT)
    level = failure(changed("tcp", -1, SHOULDER + [0.0, 0.1, 0.0]), "stopped_short")
    assert level.detail == "the gripper ended 0.100 m from the shoulder, below it"


@pytest.mark.parametrize(("rows", "held"), [(0.0, 1), (0.4, 1), (1.0, 1), (1.6, 2), (7.0, 7)])
def test_as_many_rows_are_held_as_the_hold_time_has_and_one_at_least(rows, held):
    rules = replace(RULES, hold_time=rows * DT)
    trace = changed("wound", -held, False)
    assert margin("ring_off", trace, True, rules) == pytest.approx(-1.0 / held)
    trace = changed("wound", -held - 1, False)
    assert margin("ring_off", trace, True, rules) == 0.0


def test_a_trace_shorter_than_the_hold_time_is_held_as_a_whole():
    trace = good()[-5:]
    trace.wound[0] = False
    assert margin("ring_off", trace) == pytest.approx(-0.2)
    assert judge(trace, SHOULDER, True).reasons == ("ring_off",)


def test_the_armscye_s_margin_is_that_of_the_held_rows_or_after_a_stop_of_the_last():
    trace = good()
    trace.armscye_s[-HELD] = RULES.armscye_s - 0.3
    assert margin("stuck", trace) == pytest.approx(-0.3)
    trace.armscye_s[-HELD - 1] = 0.0
    assert margin("stuck", trace) == pytest.approx(-0.3)
    trace = changed(*STOPS["over_force"])
    stop = LONG.stop - 1
    trace.armscye_s[: stop + 1] = 0.5
    trace.armscye_s[stop] = RULES.armscye_s - 0.1
    assert margin("stuck", trace) == pytest.approx(-0.1)


@pytest.mark.parametrize("last", [1.85, 1.8499])
def test_an_armscye_at_its_limit_has_arrived(last):
    trace = good()
    trace.armscye_s[-HELD:] = last
    assert judge(trace, SHOULDER, True).success is (last == RULES.armscye_s)


def test_a_sleeve_is_stuck_from_when_its_hem_no_longer_moved():
    trace = good()
    trace.armscye_s[:] = 0.4
    trace.hem_s[:] = 0.1
    trace.hem_s[60:] = 0.119  # still
    assert failure(trace, "stuck").time == pytest.approx(DT)
    trace.hem_s[:60] = 0.09  # 0.029 away
    assert failure(trace, "stuck").time == pytest.approx(61 * DT)
    trace.hem_s[:60] = 0.15  # as far on the other side
    assert failure(trace, "stuck").time == pytest.approx(61 * DT)


def test_a_stuck_sleeve_says_where_it_lies_and_what_it_presses_hardest():
    trace = good()
    trace.hem_s[-HELD:], trace.armscye_s[-HELD:] = -0.25, 0.5
    trace.link_normal_force[-1] = [3.0, 2.0, 7.25]
    found = failure(trace, "stuck")
    assert found.detail == (
        "the sleeve was caught at the forearm: it lies from s = -0.25 to 0.50 "
        "and presses the upper arm with 7.2 N"
    )
    assert (found.where, found.s) == ("forearm", 0.5)


@pytest.mark.parametrize(
    ("hem", "armscye", "where"),
    [(0.99, 1.4, "elbow"), (1.0, 1.4, "upper arm"), (0.5, 1.0, "elbow")],
)
def test_only_a_sleeve_that_lies_across_the_elbow_is_caught_by_it(hem, armscye, where):
    trace = good()
    trace.hem_s[-HELD:], trace.armscye_s[-HELD:] = hem, armscye
    assert failure(trace, "stuck").where == where


def test_the_share_of_held_rows_without_the_sleeve_is_the_ring_s_margin():
    assert margin("ring_off", changed("wound", slice(-5, None), False)) == pytest.approx(-5 / HELD)
    assert margin("ring_off", changed("wound", slice(0, -HELD), False)) == 0.0


def test_a_sleeve_that_came_off_says_where_and_one_that_never_was_on_where_it_ended():
    trace = good()
    trace.wound[40:] = False
    trace.armscye_s[40] = 1.0
    found = failure(trace, "ring_off")
    assert found.detail == "the sleeve came off the arm at the elbow"
    assert (found.where, found.s, found.time) == ("elbow", 1.0, pytest.approx(41 * DT))
    trace.wound[:] = False
    found = failure(trace, "ring_off")
    assert found.detail.endswith("never wholly on the arm; its armscye ended at the shoulder")
    assert (found.where, found.time) == ("shoulder", pytest.approx(DT))


def test_a_sleeve_that_goes_on_and_off_while_it_must_hold_is_dated_by_the_last_time():
    trace = changed("wound", slice(-4, -2), False)
    assert failure(trace, "ring_off").time == pytest.approx((ROWS - 3) * DT)


def test_the_hardest_hit_is_the_margin_and_comes_first():
    trace = changed("hit_by", (50, [0, 1, 2]), [0, 1, 0])
    trace.hit_force[50] = [2.0, 5.0, 2.0]
    found = failure(trace, "hit")
    assert found.detail == (
        "panda_leftfinger touched the forearm with 5.0 N and panda_hand touched the hand with "
        "2.0 N and panda_hand touched the upper arm with 2.0 N"
    )
    assert (found.where, found.time) == ("forearm", pytest.approx(51 * DT))
    assert margin("hit", trace) == -1e-9  # how deep it went is not known of a trace alone
    assert margin("hit", changed("hit_by", (50, 1), 0)) == -1e-9
    trace = good()
    trace.hit_force[50, 1] = 3.0  # nothing of the robot's
    assert margin("hit", trace) == 0.0


def test_a_lost_grasp_says_how_hard_the_pull_was_and_where():
    trace = changed("holding", slice(49, None), False)
    trace.grip_force[49] = 6.25
    trace.armscye_s[49] = 0.3
    found = failure(trace, "grasp_lost")
    assert found.detail == "the cloth slipped from the fingers at 6.2 N"
    assert (found.where, found.time) == ("forearm", pytest.approx(50 * DT))
    assert margin("grasp_lost", trace) == -1e-9
    trace.grip_force[49] = GRIP + 1.5
    assert margin("grasp_lost", trace) == -1.5


def test_too_much_strain_says_the_most_of_it_and_where_it_began():
    trace = changed("strain", LONG, 0.4)
    trace.strain[LONG.stop - 2] = 0.61
    trace.strain[ARRIVED - 20] = 0.9
    trace.armscye_s[ARRIVED] = 1.0
    found = failure(trace, "over_strain")
    assert found.detail == "the cloth was stretched by 61 % at the elbow"
    assert (found.where, found.s, found.time) == ("elbow", 1.0, pytest.approx((ARRIVED + 1) * DT))
    assert margin("over_strain", trace) == pytest.approx(RULES.strain - 0.4)


def test_the_margin_of_force_is_the_pull_s_or_the_links():
    trace = good()
    trace.link_force[:, 2] = [0.0, 0.6 * RULES.link_force, 0.45 * RULES.link_force]
    assert margin("over_force", trace) == pytest.approx(0.8 * RULES.grip_force)
    little = replace(RULES, link_force=0.8 * RULES.link_force)
    expected = (0.8 - 0.75) * RULES.link_force
    assert margin("over_force", trace, True, little) == pytest.approx(expected)


def test_a_limit_is_judged_by_what_lasts_a_moment_and_a_row():
    for rows, expected in ((MOMENT, 0.5 * RULES.strain), (MOMENT + 1, 0.1 * RULES.strain)):
        trace = changed("strain", slice(20, 20 + rows), 0.9 * RULES.strain)
        assert margin("over_strain", trace) == pytest.approx(expected)
    short = good()[:3]  # shorter than a moment: the least of all
    short.strain[:] = [0.2, 0.05, 0.1]
    assert margin("over_strain", short) == pytest.approx(RULES.strain - 0.05)


def test_too_much_force_is_told_of_the_rows_since_it_began():
    trace = changed("grip_force", LONG, 12.0)
    trace.grip_force[LONG.stop - 2] = 15.0
    trace.grip_force[ARRIVED - 30] = 40.0
    trace.armscye_s[ARRIVED] = 0.5
    trace.link_force[ARRIVED + 1, 1] = [0.0, 60.0, 80.0]
    trace.link_force[ARRIVED + 2, 0] = [RULES.link_force, 0.0, 0.0]
    found = failure(trace, "over_force")
    assert found.detail == (
        "the cloth was pulled with 15.0 N at the forearm and "
        "the cloth pressed the forearm with 100.0 N"
    )
    assert (found.where, found.time) == ("forearm", pytest.approx((ARRIVED + 1) * DT))


def test_the_watch_counts_rows_of_each_limit_and_forgets_them_at_a_pause():
    pulls = [0.0, 11.0, 11.0, 11.0, 10.0, 11.0]
    links = [60.0, 60.0, 0.0, 60.0, 60.0, 60.0]
    trace = good()[: len(pulls)]
    trace.grip_force[:] = pulls
    trace.link_force[:, 0, 0] = links
    watch = ProtectiveStop(replace(RULES, moment=2 * DT), DT)
    told, runs = [], []
    for now in trace.limited():
        told.append(watch.observe(now))
        runs.append(watch.runs["over_force"])
    assert runs == [[0, 1], [1, 2], [2, 0], [3, 1], [0, 2], [1, 3]]
    assert told == [{}, {}, {}, {"over_force": 3}, {}, {"over_force": 3}]
    assert stopped(trace, replace(RULES, moment=2 * DT)) == (3, {"over_force": 3})
    assert set(watch.runs) == {"hit", "grasp_lost", "over_strain", "over_force"}


def test_names_of_other_people_s_rules_come_last_and_have_the_common_colour():
    names = {"zebra", "timeout", "apple", "over_force"}
    assert in_order(names) == ["timeout", "over_force", "apple", "zebra"]
    assert in_order(set(REASONS)) == list(REASONS)
    outcomes = [Outcome(False, (Failure(name, ""),)) for name in ("zebra", "hit", "zebra")]
    assert list(count_reasons(outcomes).items()) == [("hit", 1), ("zebra", 2)]
    assert (rule_colour("hit"), rule_colour("zebra")) == ("#cc79a7", "#999999")
