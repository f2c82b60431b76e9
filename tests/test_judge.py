import json
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from dressing_sim.judge import (
    REASONS,
    Failure,
    Outcome,
    Thresholds,
    Trace,
    count_reasons,
    first_excess,
    judge,
    region,
)

RULES = Thresholds()
DT = 0.02
ROWS = 200
MOMENT = round(RULES.moment / DT)
HELD = round(RULES.hold_time / DT)
SHOULDER = np.array([0.5, -0.3, 0.2])
LINKS = ("hand", "forearm", "upper_arm")


def good(**changes):
    """A dressing as it should be: in four seconds the sleeve is at the shoulder."""
    progress = np.linspace(0.0, 1.0, ROWS)
    above = np.add(SHOULDER, [0.0, 0.0, 0.5 * RULES.gripper_distance])
    columns = {
        "tcp": above + np.outer(1.0 - np.minimum(1.2 * progress, 1.0), [0.0, 0.4, 0.0]),
        "armscye_s": np.minimum(1.2 * progress, 1.0) * (RULES.armscye_s + 0.1),
        "wound": np.ones(ROWS, dtype=bool),
        "strain": np.full(ROWS, 0.5 * RULES.strain),
        "strain_max": np.full(ROWS, 0.8 * RULES.strain),
        "grip_force": np.full(ROWS, 0.2 * RULES.grip_force),
        "link_force": np.full((ROWS, len(LINKS)), 0.2 * RULES.link_force),
        "hit": np.zeros((ROWS, len(LINKS)), dtype=bool),
        "hit_force": np.zeros((ROWS, len(LINKS))),
        "tracking_error": np.full(ROWS, 1e-4),
        "torque": np.full((ROWS, 7), 3.0),
    }
    return Trace(DT, LINKS, **(columns | changes))


def changed(name, rows, value):
    """The good trace with one quantity changed in some rows."""
    column = getattr(good(), name).copy()
    column[rows] = value
    return good(**{name: column})


def verdict(trace, finished=True, rules=None):
    return judge(trace, SHOULDER, finished, rules)


LAST = slice(-1, None)
LONG = slice(100, 100 + MOMENT + 1)
SPOILT = {
    "stopped_short": ("tcp", LAST, np.add(SHOULDER, [0.0, 1.01 * RULES.gripper_distance, 0.01])),
    "stuck": ("armscye_s", LAST, RULES.armscye_s - 0.01),
    "ring_off": ("wound", LAST, False),
    "hit": ("hit", (50, 1), True),
    "over_strain": ("strain", LONG, 1.01 * RULES.strain),
    "over_force": ("grip_force", LONG, 1.01 * RULES.grip_force),
}


def test_a_good_dressing_is_a_success():
    outcome = verdict(good())
    assert outcome.success
    assert outcome.failures == ()
    assert outcome.void is None


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


def test_everything_that_goes_wrong_is_reported_in_the_order_of_tables():
    columns = {}
    for reason, (name, rows, value) in SPOILT.items():
        if reason != "stuck":  # said only of a gripper that got there
            columns[name] = getattr(changed(name, rows, value), name)
    outcome = verdict(good(**columns), finished=False)
    expected = [r for r in REASONS if r in SPOILT or r == "timeout"]
    expected.remove("stuck")
    assert list(outcome.reasons) == expected


def test_a_gripper_below_the_shoulder_has_stopped_short():
    trace = changed("tcp", slice(-HELD, None), SHOULDER - [0.0, 0.0, 0.01])
    assert verdict(trace).reasons == ("stopped_short",)
    assert "below" in verdict(trace).failures[0].detail


@pytest.mark.parametrize("reason", ["stopped_short", "stuck", "ring_off"])
def test_the_end_must_be_held(reason):
    name, _, value = SPOILT[reason]
    assert verdict(changed(name, ROWS - HELD, value)).reasons == (reason,)
    assert verdict(changed(name, ROWS - HELD - 1, value)).success


@pytest.mark.parametrize(
    ("name", "limit", "reason"),
    [
        ("strain", RULES.strain, "over_strain"),
        ("grip_force", RULES.grip_force, "over_force"),
        ("link_force", RULES.link_force, "over_force"),
    ],
)
def test_a_moment_is_forgiven_and_the_limit_itself_is_allowed(name, limit, reason):
    start = 60
    assert verdict(changed(name, slice(start, start + MOMENT), 2 * limit)).success
    assert verdict(changed(name, slice(None), limit)).success
    # Two moments with a pause are still moments.
    twice = changed(name, slice(start, start + 2 * MOMENT + 1), 2 * limit)
    getattr(twice, name)[start + MOMENT] = 0.0
    assert verdict(twice).success
    outcome = verdict(changed(name, slice(start, start + MOMENT + 1), 2 * limit))
    assert outcome.reasons == (reason,)
    assert outcome.failures[0].time == pytest.approx((start + 1) * DT)


def test_a_hit_is_not_forgiven_and_names_the_links():
    hit = good().hit.copy()
    hit[70, 0] = hit[90, 2] = True
    failure = verdict(good(hit=hit)).failures[0]
    assert failure.time == pytest.approx(71 * DT)
    assert "hand, upper_arm" in failure.detail
    assert "forearm" not in failure.detail


def test_a_failure_says_where_the_sleeve_was():
    trace = changed("strain", LONG, 1.0)
    trace.armscye_s[LONG] = 1.1
    failure = verdict(trace).failures[0]
    assert failure.s == pytest.approx(1.1)
    assert "at the elbow" in failure.detail


def test_a_sleeve_that_came_off_is_dated_to_when_it_did_for_good():
    wound = np.ones(ROWS, dtype=bool)
    wound[10:20] = wound[120:] = False
    failure = verdict(good(wound=wound)).failures[0]
    assert failure.reason == "ring_off"
    assert failure.time == pytest.approx(121 * DT)
    assert verdict(changed("wound", slice(10, 20), False)).success


def test_two_forces_are_one_failure_dated_by_the_earlier():
    trace = changed("grip_force", slice(100, 120), 2 * RULES.grip_force)
    trace.link_force[60:80, 1] = 2 * RULES.link_force
    outcome = verdict(trace)
    assert outcome.reasons == ("over_force",)
    assert outcome.failures[0].time == pytest.approx(61 * DT)


def test_the_rules_can_be_changed():
    assert not verdict(good(), rules=replace(RULES, strain=0.4 * RULES.strain)).success
    assert not verdict(good(), rules=replace(RULES, armscye_s=3.0)).success
    trace = changed(*SPOILT["over_force"])
    assert verdict(trace, rules=replace(RULES, grip_force=2 * RULES.grip_force)).success


def test_figures_are_the_ends_and_the_extremes():
    trace = good()
    trace.torque[7, 3] = -50.0
    trace.grip_force[9] = 1.5 * RULES.grip_force
    figures = verdict(trace).figures
    assert figures["duration"] == pytest.approx(ROWS * DT)
    assert figures["armscye_s"] == trace.armscye_s[-1]
    assert figures["gripper_distance"] == pytest.approx(0.5 * RULES.gripper_distance)
    assert figures["torque"] == 50.0
    assert figures["grip_force"] == 1.5 * RULES.grip_force
    assert all(type(value) is float for value in figures.values())


@pytest.mark.parametrize(
    ("s", "name"),
    [
        (-0.5, "hand"),
        (0.01, "forearm"),
        (0.5, "forearm"),
        (1.0, "elbow"),
        (1.1, "elbow"),
        (1.6, "upper arm"),
        (2.0, "shoulder"),
        (2.5, "shoulder"),
    ],
)
def test_regions_of_the_arm(s, name):
    assert region(s) == name


@given(arrays(float, st.integers(1, 40), elements=st.sampled_from([0.0, 1.0])), st.integers(0, 5))
def test_the_first_excess_starts_the_first_run_that_is_too_long(values, rows):
    text = "".join("x" if value > 0.5 else "." for value in values)
    place = text.find("x" * (rows + 1))
    assert first_excess(values, 0.5, rows) == (None if place < 0 else place)


def test_an_outcome_is_plain_values():
    outcome = verdict(changed(*SPOILT["over_strain"]))
    plain = json.loads(json.dumps(outcome.to_dict()))
    assert set(plain) == {f.name for f in fields(Outcome)}
    assert plain["failures"][0]["reason"] == "over_strain"
    assert set(plain["failures"][0]) == {f.name for f in fields(Failure)}
    assert plain["figures"] == dict(outcome.figures)


def test_reasons_are_counted_in_their_order():
    one = verdict(changed(*SPOILT["over_strain"]))
    both = verdict(changed(*SPOILT["over_strain"]), finished=False)
    assert list(count_reasons([one, both, verdict(good())]).items()) == [
        ("timeout", 1),
        ("over_strain", 2),
    ]
    assert count_reasons([]) == {}
