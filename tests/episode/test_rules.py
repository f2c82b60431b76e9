import json
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from rule_traces import (
    ARRIVED,
    DT,
    ENDS,
    HELD,
    LONG,
    MOMENT,
    ROWS,
    RULES,
    SHOULDER,
    SPOILT,
    STOPS,
    changed,
    good,
)

from dressing_sim.episode.judge import judge, stopped
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rules import count_reasons
from dressing_sim.episode.trace import region


def verdict(trace, finished=True, rules=None):
    return judge(trace, SHOULDER, finished, rules)


def test_a_good_dressing_is_a_success():
    outcome = verdict(good())
    assert outcome.success
    assert outcome.failures == ()
    assert outcome.invalid is None


@pytest.mark.parametrize("reason", SPOILT)
def test_each_thing_that_goes_wrong_is_reported_alone(reason):
    outcome = verdict(changed(*SPOILT[reason]))
    assert not outcome.success
    assert outcome.reasons == (reason,)
    assert outcome.failures[0].detail


def test_a_path_that_was_not_finished_is_a_timeout():
    outcome = verdict(good(), finished=False)
    assert outcome.reasons == ("timeout",)
    assert outcome.failures[0].time == pytest.approx(ROWS * DT)


def test_everything_that_goes_wrong_at_the_end_is_reported_in_the_order_of_tables():
    columns = {name: getattr(changed(name, *how), name) for name, *how in ENDS.values()}
    outcome = verdict(good(**columns), finished=False)
    # Stuck is said only of a gripper that got there.
    assert outcome.reasons == ("timeout", "stopped_short", "ring_off")


def test_everything_that_stops_the_robot_at_once_is_reported_in_the_order_of_tables():
    columns = {name: getattr(changed(name, *how), name) for name, *how in STOPS.values()}
    stop = LONG.stop - 1
    for name in ("hit_by", "holding"):
        columns[name] = np.roll(columns[name], stop - 50, axis=0)
    columns["holding"][:stop] = True
    assert verdict(good(**columns)).reasons == ("hit", "grasp_lost", "over_strain", "over_force")


@pytest.mark.parametrize("reason", STOPS)
def test_what_comes_after_the_stop_does_not_count(reason):
    trace = changed(*STOPS[reason])
    columns = {name: getattr(changed(name, *how), name) for name, *how in ENDS.values()}
    name = STOPS[reason][0]
    worse = good(**{name: getattr(trace, name)}, **columns)
    assert verdict(worse, finished=False).to_dict() == verdict(trace).to_dict()
    stop, _ = stopped(trace, RULES)
    assert verdict(trace[: stop + 1], finished=False).to_dict() == verdict(trace).to_dict()
    assert verdict(trace).metrics["duration"] == pytest.approx((stop + 1) * DT)
    assert stopped(trace[:stop], RULES) is None


def test_a_gripper_below_the_shoulder_has_stopped_short():
    trace = changed("tcp", slice(-HELD, None), SHOULDER - [0.0, 0.0, 0.01])
    assert verdict(trace).reasons == ("stopped_short",)
    assert "below" in verdict(trace).failures[0].detail


@pytest.mark.parametrize("reason", ["stopped_short", "stuck", "ring_off"])
def test_the_end_must_be_held(reason):
    name, _, value = SPOILT[reason]
    assert verdict(changed(name, ROWS - HELD, value)).reasons == (reason,)
    assert verdict(changed(name, ROWS - HELD - 1, value)).success


@pytest.mark.parametrize("hold_time", [0.0, 0.4 * DT])
def test_the_last_row_is_held_whatever_the_hold_time(hold_time):
    name, _, value = SPOILT["stopped_short"]
    rules = replace(RULES, hold_time=hold_time)
    spoilt = changed(name, -1, value)
    assert judge(spoilt, SHOULDER, True, rules).reasons == ("stopped_short",)


@pytest.mark.parametrize(
    ("name", "limit", "reason"),
    [
        ("strain", RULES.strain, "over_strain"),
        ("grip_force", RULES.grip_force, "over_force"),
        ("link_force", RULES.link_force, "over_force"),
    ],
)
def test_a_moment_is_forgiven_and_the_limit_itself_is_allowed(name, limit, reason):
    start = ARRIVED
    assert verdict(changed(name, slice(start, start + MOMENT), 2 * limit)).success
    assert verdict(changed(name, slice(None), limit)).success
    # Two moments with a pause are still moments.
    twice = changed(name, slice(start - MOMENT - 1, start + MOMENT), 2 * limit)
    getattr(twice, name)[start - 1] = 0.0
    assert verdict(twice).success
    outcome = verdict(changed(name, slice(start, start + MOMENT + 1), 2 * limit))
    assert outcome.reasons == (reason,)
    assert outcome.failures[0].time == pytest.approx((start + 1) * DT)


def test_a_hit_is_not_forgiven_and_says_what_hit_what_and_how_hard():
    trace = changed("hit_by", (70, [0, 2]), [1, 0])
    trace.hit_force[70, [0, 2]] = [3.0, 7.0]
    trace.hit_by[90, 1] = 0
    outcome = verdict(trace)
    (failure,) = outcome.failures
    assert failure.time == pytest.approx(71 * DT)
    assert failure.where == "upper arm"
    assert "panda_hand touched the upper arm with 7.0 N" in failure.detail
    assert "panda_leftfinger touched the hand with 3.0 N" in failure.detail
    assert "forearm" not in failure.detail
    assert outcome.metrics["hit_force"] == 7.0


def test_a_failure_says_where_the_sleeve_was():
    trace = changed("strain", LONG, 1.0)
    trace.armscye_s[LONG] = 1.1
    failure = verdict(trace).failures[-1]
    assert failure.reason == "over_strain"
    assert failure.s == pytest.approx(1.1)
    assert failure.where == "elbow"
    assert "at the elbow" in failure.detail


@pytest.mark.parametrize(
    ("hem", "armscye", "where"),
    [
        (-0.9, -0.1, "hand"),
        (-0.5, 0.3, "forearm"),
        (0.0, 0.8, "elbow"),
        (0.4, 1.2, "elbow"),
        (0.7, 1.5, "elbow"),  # the armscye has passed the elbow, the rest hangs there
        (1.05, 1.7, "upper arm"),
    ],
)
@pytest.mark.parametrize("reason", ["over_strain", "over_force", None])
def test_a_sleeve_is_stuck_where_it_is_caught(hem, armscye, where, reason):
    trace = changed(*STOPS[reason]) if reason else good()
    rows = LONG if reason else slice(-HELD, None)
    trace.hem_s[rows], trace.armscye_s[rows] = hem, armscye
    outcome = verdict(trace)
    assert outcome.reasons == (("stuck", reason) if reason else ("stuck",))
    stuck = outcome.failures[0]
    assert (stuck.where, stuck.s) == (where, armscye)
    # Dated to when it came to where it stays.
    begin, _, _ = rows.indices(ROWS)
    assert stuck.time == pytest.approx((begin + 1) * DT)


@pytest.mark.parametrize("reason", ["hit", "grasp_lost"])
def test_a_stop_that_is_not_the_cloth_s_leaves_no_sleeve_stuck(reason):
    trace = changed(*STOPS[reason])
    assert trace.armscye_s[50] < RULES.armscye_s
    assert verdict(trace).reasons == (reason,)


def test_a_sleeve_that_was_off_before_the_robot_stopped_came_off():
    stop = LONG.stop - 1
    for on, off, reasons in (
        (0, stop - HELD, ("ring_off", "over_force")),
        (0, stop, ("over_force",)),
        (ROWS, ROWS, ("over_force",)),  # never on
    ):
        trace = changed(*STOPS["over_force"])
        trace.wound[:on] = trace.wound[off:] = False
        assert verdict(trace).reasons == reasons
    assert RULES.hold_time > RULES.moment


def test_a_sleeve_that_came_off_is_dated_to_when_it_did_for_good():
    wound = np.ones(ROWS, dtype=bool)
    wound[10:20] = wound[120:] = False
    failure = verdict(good(wound=wound)).failures[0]
    assert failure.reason == "ring_off"
    assert failure.time == pytest.approx(121 * DT)
    assert verdict(changed("wound", slice(10, 20), False)).success


def test_two_forces_are_one_failure_dated_by_the_earlier():
    trace = changed("grip_force", slice(175, 195), 2 * RULES.grip_force)
    trace.link_force[170:190, 1, 0] = 2 * RULES.link_force
    outcome = verdict(trace)
    assert outcome.reasons == ("over_force",)
    assert outcome.failures[0].time == pytest.approx(171 * DT)
    detail = outcome.failures[0].detail
    assert f"pulled with {2 * RULES.grip_force:.1f} N" in detail
    assert f"pressed the forearm with {2 * RULES.link_force:.1f} N" in detail


@pytest.mark.parametrize(
    ("name", "told", "untold"),
    [("grip_force", "pulled with", "pressed"), ("link_force", "pressed the hand", "pulled")],
)
def test_too_much_force_says_which_and_how_much(name, told, untold):
    limit = getattr(RULES, name)
    (failure,) = verdict(changed(name, LONG, 3 * limit)).failures
    assert told in failure.detail
    assert f"with {3 * limit:.1f} N" in failure.detail
    assert untold not in failure.detail


def test_the_rules_can_be_changed():
    assert not verdict(good(), rules=replace(RULES, strain=0.4 * RULES.strain)).success
    assert not verdict(good(), rules=replace(RULES, armscye_s=3.0)).success
    trace = changed(*SPOILT["over_force"])
    assert verdict(trace, rules=replace(RULES, grip_force=2 * RULES.grip_force)).success


def test_figures_are_the_ends_and_the_extremes():
    trace = good()
    trace.torque[7, 3] = -9.0
    trace.limit_ratio[8] = [0.4, 0.7, 0.2]
    trace.link_force[11, 1] = [3.0, 4.0, 12.0]
    trace.link_normal_force[12, 2] = 0.4 * RULES.link_force
    trace.grip_force[9] = 1.5 * RULES.grip_force
    for peak, column in enumerate(("strain", "strain_median", "strain_max", "tracking_error")):
        getattr(trace, column)[20 + peak] = 0.25 + 0.01 * peak
    # On the way a sleeve may have been further on than in the end.
    trace.armscye_s[30] = trace.armscye_s[-1] + 0.2
    trace.dressed_ratio[30] = trace.dressed_ratio[-1] + 0.1
    figures = verdict(trace).metrics
    assert figures["duration"] == pytest.approx(ROWS * DT)
    assert figures["armscye_s"] == trace.armscye_s[-1]
    assert figures["gripper_distance"] == pytest.approx(0.5 * RULES.gripper_distance)
    assert figures["upper_arm_dressed_ratio"] == trace.dressed_ratio[-1, 0]
    assert figures["whole_arm_dressed_ratio"] == trace.dressed_ratio[-1, 1]
    assert figures["line_triangle_on"] == 1.0
    assert figures["line_triangle_ratio"] == trace.line_triangle_ratio[-1, 0]
    assert figures["torque"] == 9.0
    extremes = ("strain", "strain_median", "strain_max", "tracking_error")
    assert [figures[name] for name in extremes] == pytest.approx([0.25, 0.26, 0.27, 0.28])
    names = ("joint_position_ratio", "joint_speed_ratio", "torque_ratio")
    assert [figures[name] for name in names] == [0.4, 0.7, 0.25]
    assert figures["grip_force"] == 1.5 * RULES.grip_force
    assert figures["link_force"] == figures["forearm_force"] == pytest.approx(13.0)
    assert figures["hand_force"] == 0.2 * RULES.link_force
    assert figures["link_normal_force"] == 0.4 * RULES.link_force
    assert figures["upper_arm_normal_force"] == 0.4 * RULES.link_force
    assert figures["hand_normal_force"] == 0.3 * RULES.link_force
    for name in ("strain", "strain_median", "strain_max", "edge_strain"):
        assert figures[name] == getattr(trace, name).max()
    assert all(type(value) is float for value in figures.values())


def test_speed_near_the_arm_is_the_fastest_move_that_ends_near_it():
    trace = good()
    trace.tcp[:] = SHOULDER
    trace.tcp[100:, 0] += 0.002
    trace.tcp[120:, 0] += 0.005
    assert verdict(trace).metrics["speed_near_arm"] == pytest.approx(0.25)
    trace.clearance[120] = 0.11
    assert verdict(trace).metrics["speed_near_arm"] == pytest.approx(0.10)
    trace.clearance[:] = 0.11
    assert verdict(trace).metrics["speed_near_arm"] == 0.0


@pytest.mark.parametrize(
    ("s", "name"),
    [
        (-0.5, "hand"),
        (0.01, "forearm"),
        (0.5, "forearm"),
        (0.74, "forearm"),
        (0.76, "elbow"),
        (1.0, "elbow"),
        (1.1, "elbow"),
        (1.34, "elbow"),
        (1.36, "upper arm"),
        (1.84, "upper arm"),
        (1.86, "shoulder"),
        (1.6, "upper arm"),
        (2.0, "shoulder"),
        (2.5, "shoulder"),
    ],
)
def test_regions_of_the_arm(s, name):
    assert region(s) == name


@given(
    arrays(float, st.integers(1, 40), elements=st.sampled_from([0.0, 1.0])),
    st.integers(0, 5),
    st.sampled_from(["strain", "grip_force", "link_force"]),
)
def test_the_robot_stops_at_the_end_of_the_first_run_that_is_too_long(values, rows, name):
    text = "".join("x" if value > 0.5 else "." for value in values)
    place = text.find("x" * (rows + 1))
    rules = replace(RULES, moment=rows * DT, **{name: 0.5})
    trace = good()[: len(values)]
    for column in ("strain", "grip_force", "link_force"):
        getattr(trace, column)[:] = 0.0
    getattr(trace, name).T[..., :] = values
    reason = "over_strain" if name == "strain" else "over_force"
    expected = None if place < 0 else (place + rows, {reason: rows + 1})
    assert stopped(trace, rules) == expected


@given(st.integers(0, ROWS - 1), st.integers(1, ROWS))
def test_a_trace_is_sliced_by_rows(start, length):
    trace, part = good(), good()[start : start + length]
    assert len(part) == min(length, ROWS - start)
    np.testing.assert_array_equal(part.link_force, trace.link_force[start : start + length])
    assert (part.dt, part.links) == (trace.dt, trace.links)


def test_an_outcome_is_plain_values():
    outcome = verdict(changed(*SPOILT["over_strain"]))
    plain = json.loads(json.dumps(outcome.to_dict()))
    assert list(plain) == ["success", "void", "failures", "figures"]
    # Whether the policy abstained is told of those alone that did.
    assert len(plain) == len(fields(Outcome)) - 1
    abstained = replace(outcome, abstained="not sure").to_dict()
    assert set(abstained) - set(plain) == {"abstained"}
    assert plain["failures"][0]["reason"] == "over_strain"
    assert plain["failures"][0]["where"] == "shoulder"
    assert set(plain["failures"][0]) == {f.name for f in fields(Failure)}
    assert plain["figures"] == dict(outcome.metrics)


def test_reasons_are_counted_in_their_order():
    one = verdict(changed(*SPOILT["over_strain"]))
    both = verdict(changed(*SPOILT["ring_off"]), finished=False)
    assert list(count_reasons([one, both, one, verdict(good())]).items()) == [
        ("timeout", 1),
        ("ring_off", 1),
        ("over_strain", 2),
    ]
    assert count_reasons([]) == {}
