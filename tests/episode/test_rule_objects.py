"""Rules as objects: one is added by one class, and every margin's sign is the verdict."""

import numpy as np
import pytest
from rule_traces import ROWS, SHOULDER, SPOILT, changed, good

from dressing_sim.benchmark.studies.success_tables import counted
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.judge import ProtectiveStop, judge, margins
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.record import record
from dressing_sim.episode.rule import Evidence, Rule
from dressing_sim.episode.rules import REASONS, RULES, count_reasons, rule_colour
from dressing_sim.episode.thresholds import Thresholds, threshold_sources, threshold_units


class TimeOver(Rule):
    """The robot takes no longer than a time."""

    name, title, colour, ends, unit = "too_slow", "the robot took too long", "#123456", True, "s"

    def __init__(self, limit=20.0):
        self.limit = limit

    def exceeded(self, now, thresholds):
        return (now.time > self.limit,)

    def margin(self, evidence):
        return self.limit - len(evidence.trace) * evidence.trace.dt

    def failure(self, evidence):
        if self.name not in evidence.stop:
            return None
        detail = f"more than {self.limit:g} s"
        return evidence.failure(self, evidence.last, detail)


def test_a_rule_of_one_s_own_stops_the_robot_is_reported_and_counted(posture):
    rules = (*RULES, TimeOver(0.3))
    path = np.linspace(Dressing(posture).start, np.add(Dressing(posture).start, [0, 0, 0.2]), 30)
    recording = record(path, posture, rules=rules)
    outcome = recording.outcome
    assert outcome.reasons == ("too_slow",)
    assert outcome.failures[0].detail == "more than 0.3 s"
    assert outcome.failures[0].time == pytest.approx(0.32)
    assert len(recording.trace) == 16
    assert counted(count_reasons([outcome, Outcome(True)])) == "too_slow 1"
    # Without it the robot goes on.
    assert len(record(path, posture).trace) > 16
    assert rule_colour("too_slow").startswith("#")


def test_twenty_seconds_are_enough_for_the_operator_s_trace():
    outcome = judge(good(), SHOULDER, True, None, (*RULES, TimeOver()))
    assert outcome.success
    assert margins(Evidence(good(), SHOULDER), (*RULES, TimeOver()))["too_slow"] == 20.0 - 4.0


@pytest.mark.parametrize("name", sorted(SPOILT))
def test_a_margin_is_negative_where_its_rule_is_broken(name):
    trace = changed(*SPOILT[name])
    found = margins(Evidence(trace, SHOULDER))
    assert list(found) == list(REASONS)
    broken = judge(trace, SHOULDER, True).reasons
    for reason in broken:
        assert found[reason] < 0.0, reason


def test_no_margin_of_a_good_dressing_is_negative_and_none_is_flat():
    found = margins(Evidence(good(), SHOULDER))
    assert all(value >= 0.0 for value in found.values())
    rules = Thresholds()
    assert found["over_strain"] == pytest.approx(0.5 * rules.strain)
    assert found["over_force"] == pytest.approx(0.8 * rules.grip_force)
    assert found["stuck"] == pytest.approx(0.1)
    assert found["stopped_short"] == pytest.approx(0.5 * rules.gripper_distance)


@pytest.mark.parametrize("strain", [0.1, 0.2, 0.29])
def test_margins_change_gradually(strain):
    trace = good(strain=np.full(ROWS, strain))
    found = margins(Evidence(trace, SHOULDER))["over_strain"]
    assert found == pytest.approx(Thresholds().strain - strain)


@pytest.mark.parametrize("time_left", [-2.0, -0.02, 0.0, 3.5])
def test_the_margin_of_the_time_limit_is_the_time_that_is_left(time_left):
    evidence = Evidence(good(), SHOULDER, time_left)
    assert margins(evidence)["timeout"] == time_left
    assert judge(good(), SHOULDER, evidence.finished).success == (time_left >= 0.0)


@pytest.mark.parametrize("pull", [1.0, 2.0, 9.0])
def test_the_margin_of_the_grasp_is_what_the_fingers_could_still_hold(pull):
    trace = good(grip_force=np.full(ROWS, pull))
    assert margins(Evidence(trace, SHOULDER, grip_strength=42.0))["grasp_lost"] == 42.0 - pull


def test_the_margin_of_a_hit_is_a_distance_up_to_the_touch_and_a_depth_after_it():
    clearance = np.linspace(0.2, 0.05, ROWS)
    far = Evidence(good(), SHOULDER, robot_clearance=clearance)
    assert margins(far)["hit"] == pytest.approx(0.05)
    touched = np.full((ROWS, 3), -1)
    touched[150, 1] = 0
    # What comes after the robot has stopped is not looked at.
    for depth, after in ((-0.003, -0.1), (0.001, -0.1)):
        clearance[150], clearance[151:] = depth, after
        near = Evidence(good(hit_by=touched), SHOULDER, robot_clearance=clearance)
        assert margins(near)["hit"] == pytest.approx(min(depth, 0.0), abs=1e-8)
        assert margins(near)["hit"] < 0.0


def test_a_peak_shorter_than_a_moment_costs_no_margin():
    strain = np.full(ROWS, 0.1)
    strain[50:55] = 9.0
    assert margins(Evidence(good(strain=strain), SHOULDER))["over_strain"] == pytest.approx(0.2)


def test_a_sleeve_that_was_never_on_is_not_said_to_have_come_off():
    never = judge(good(wound=np.zeros(ROWS, dtype=bool)), SHOULDER, True).failures[0]
    assert never.reason == "ring_off"
    assert "never wholly on" in never.detail
    wound = np.ones(ROWS, dtype=bool)
    wound[120:] = False
    off = judge(good(wound=wound), SHOULDER, True).failures[0]
    assert "came off" in off.detail


def test_every_rule_has_a_name_a_title_and_a_colour_of_its_own():
    for attribute in ("name", "title", "colour"):
        assert len({getattr(rule, attribute) for rule in RULES}) == len(RULES)
    assert tuple(rule.name for rule in RULES) == REASONS


def test_every_threshold_has_a_unit_and_a_source_and_decides_some_rule():
    units, sources = threshold_units(), threshold_sources()
    assert set(units) == set(sources) == set(Thresholds.__dataclass_fields__)
    assert units["grip_force"] == "N"
    assert "Erickson" in sources["grip_force"]
    assert {name for rule in RULES for name in rule.thresholds} == set(units)


def test_the_stop_s_patience_is_that_of_each_rule():
    rows = list(changed(*SPOILT["over_strain"]).limited())
    watch = ProtectiveStop(Thresholds(), 0.02)
    first = next(i for i, row in enumerate(rows) if watch.observe(row))
    exceeded = next(i for i, row in enumerate(rows) if row.strain > Thresholds().strain)
    assert first - exceeded == round(Thresholds().moment / 0.02)


def test_a_config_without_stop_is_judged_the_same(posture):
    config = EpisodeConfig(hold=0.1, time_limit=0.5, protective_stop=False)
    rules = (*RULES, TimeOver(0.1))
    path = np.linspace(Dressing(posture).start, np.add(Dressing(posture).start, [0, 0, 0.2]), 30)
    recording = record(path, posture, config=config, rules=rules)
    assert len(recording.trace) == 25
    assert recording.outcome.reasons == ("too_slow",)
    assert recording.outcome.metrics["duration"] == pytest.approx(0.12)
