"""Rules as objects: one is added by one class, and every margin's sign is the verdict."""

import numpy as np
import pytest
from rule_traces import ROWS, SHOULDER, SPOILT, changed, good

from dressing_sim.benchmark.studies.success_tables import counted
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.record import record
from dressing_sim.episode.rules import (
    REASONS,
    RULES,
    ProtectiveStop,
    Rule,
    count_reasons,
    judge,
    margins,
    rule_colour,
)
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
    assert margins(good(), SHOULDER, True, None, (*RULES, TimeOver()))["too_slow"] == 20.0 - 4.0


@pytest.mark.parametrize("name", sorted(SPOILT))
def test_a_margin_is_negative_where_its_rule_is_broken(name):
    trace = changed(*SPOILT[name])
    found = margins(trace, SHOULDER, finished=True)
    assert list(found) == list(REASONS)
    broken = judge(trace, SHOULDER, True).reasons
    for reason in broken:
        assert found[reason] < 0.0, reason


def test_no_margin_of_a_good_dressing_is_negative_and_none_is_flat():
    found = margins(good(), SHOULDER, finished=True)
    assert all(value >= 0.0 for value in found.values())
    rules = Thresholds()
    assert found["over_strain"] == pytest.approx(0.5 * rules.strain)
    assert found["over_force"] == pytest.approx(0.8 * rules.grip_force)
    assert found["stuck"] == pytest.approx(0.1)
    assert found["stopped_short"] == pytest.approx(0.5 * rules.gripper_distance)


@pytest.mark.parametrize("strain", [0.1, 0.2, 0.29])
def test_margins_change_gradually(strain):
    trace = good(strain=np.full(ROWS, strain))
    found = margins(trace, SHOULDER, True)["over_strain"]
    assert found == pytest.approx(Thresholds().strain - strain)


def test_a_peak_shorter_than_a_moment_costs_no_margin():
    strain = np.full(ROWS, 0.1)
    strain[50:55] = 9.0
    assert margins(good(strain=strain), SHOULDER, True)["over_strain"] == pytest.approx(0.2)


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
