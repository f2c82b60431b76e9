import json
from dataclasses import fields, replace
from types import SimpleNamespace

import numpy as np
import pytest

from dressing_sim.benchmark.run.plan import Job
from dressing_sim.benchmark.studies import thresholds_verdicts
from dressing_sim.benchmark.studies.thresholds import PROTOCOL
from dressing_sim.benchmark.studies.thresholds_verdicts import (
    FACTORS,
    NAMES,
    StrainReader,
    dress_and_judge,
    scaled,
    variants,
    verdict_of,
    verdicts,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rollout import follow
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.episode.trace import Trace
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.sleeve import SleeveConfig, sleeve_mesh

RULES = Thresholds()
DT, ROWS = 0.02, 200
SHOULDER = np.array([0.5, -0.3, 0.2])
ALL, NONE = dict.fromkeys(NAMES, FACTORS), dict.fromkeys(NAMES, ())
LINKS = ("hand", "forearm", "upper_arm")
MOMENT = round(RULES.moment / DT)


def good(**changes):
    """A dressing that every variant of the rules lets pass."""
    n = len(LINKS)
    columns = {
        "dt": DT,
        "links": LINKS,
        "robot_links": ("gripper",),
        "tcp": np.tile(np.add(SHOULDER, [0.0, 0.0, 0.2 * RULES.gripper_distance]), (ROWS, 1)),
        "clearance": np.full(ROWS, 0.1),
        "tracking_error": np.full(ROWS, 1e-4),
        "joint_position": np.zeros((ROWS, 7)),
        "joint_velocity": np.zeros((ROWS, 7)),
        "torque": np.full((ROWS, 7), 3.0),
        "limit_ratio": np.full((ROWS, 3), 0.2),
        "armscye_s": np.full(ROWS, 1.99),
        "hem_s": np.full(ROWS, 1.2),
        "line_triangle_on": np.ones(ROWS, dtype=bool),
        "wound": np.ones(ROWS, dtype=bool),
        "dressed_ratio": np.ones((ROWS, 2)),
        "line_triangle_ratio": np.ones((ROWS, 2)),
        "strain": np.full(ROWS, 0.2 * RULES.strain),
        "strain_median": np.full(ROWS, 0.1 * RULES.strain),
        "strain_max": np.full(ROWS, 0.3 * RULES.strain),
        "edge_strain": np.full(ROWS, 0.2 * RULES.strain),
        "holding": np.ones(ROWS, dtype=bool),
        "grip_force": np.full(ROWS, 0.2 * RULES.grip_force),
        "link_force": np.full((ROWS, n, 3), [0.2 * RULES.link_force, 0.0, 0.0]),
        "link_normal_force": np.full((ROWS, n), 0.2 * RULES.link_force),
        "penetration": np.full(ROWS, 0.001),
        "hit_by": np.full((ROWS, n), -1),
        "hit_force": np.zeros((ROWS, n)),
    }
    known = {field.name for field in fields(Trace)}
    return Trace(**{name: column for name, column in columns.items() if name in known} | changes)


def changed(name, rows, value):
    column = getattr(good(), name).copy()
    column[rows] = value
    return good(**{name: column})


def judged(trace, strain=None, outcome=None, finished=True):
    """Factors under which a trace is a success, by threshold."""
    time_left = 0.0 if finished else -1.0
    recording = Recording(outcome or Outcome(True), trace, None, np.zeros((1, 3)), time_left)
    if strain is None:
        column = None if trace is None else trace.strain
        strain = {variant.strain_percentile: column for *_, variant in variants(RULES)}
    found = verdicts(recording, SHOULDER, RULES, strain)
    assert list(found) == list(NAMES)
    assert all(list(found[name]) == [f"{factor:g}" for factor in FACTORS] for name in NAMES)
    return {name: tuple(f for f in FACTORS if found[name][f"{f:g}"]) for name in NAMES}


def test_a_dressing_that_would_have_gone_on_into_a_breakdown_has_no_verdict():
    """Nobody knows how it would have ended; where the robot stops before, it is known."""
    strain = {variant.strain_percentile: None for *_, variant in variants(RULES)}
    pulled = changed("grip_force", LONG, 1.15 * RULES.grip_force)
    torn = changed("grip_force", slice(100, 100 + 3 * MOMENT), 3.0 * RULES.grip_force)
    everything = {(name, f"{factor:g}") for name in NAMES for factor in FACTORS}
    looser = {("grip_force", f"{f:g}") for f in FACTORS if f > 1.15}
    # Pulled for so short a time that a longer moment forgives it, too.
    looser |= {("moment", f"{f:g}") for f in FACTORS if f > 1.0}
    for trace, unknown in ((good(), everything), (pulled, looser), (torn, set())):
        recording = Recording(Outcome(True), trace, None, np.zeros((1, 3)), 0.0, broke="BADQVEL")
        found = verdicts(recording, SHOULDER, RULES, dict.fromkeys(strain, trace.strain))
        known = {(name, factor) for name, own in found.items() for factor in own}
        assert everything - known == unknown
        assert not any(success for own in found.values() for success in own.values())


LONG = slice(100, 100 + MOMENT + 1)
LATE = ROWS - round(1.05 * RULES.hold_time / DT)

#: Traces that are 15 % beyond one threshold, and far from all others.
SPOILT = {
    "armscye_s": changed("armscye_s", slice(None), 2.0 - 1.15 * (2.0 - RULES.armscye_s)),
    "gripper_distance": changed(
        "tcp", slice(None), np.add(SHOULDER, [0.0, 1.15 * RULES.gripper_distance, 0.001])
    ),
    "strain": changed("strain", LONG, 1.15 * RULES.strain),
    "grip_force": changed("grip_force", LONG, 1.15 * RULES.grip_force),
    "link_force": changed("link_force", (LONG, 1, 0), 1.15 * RULES.link_force),
}


def test_a_factor_of_one_leaves_the_rules_as_they_are():
    assert 1.0 in FACTORS
    assert all(scaled(RULES, name, 1.0) == RULES for name in NAMES)


def test_one_threshold_is_multiplied_and_the_others_are_not():
    for name, factor, variant in variants(RULES):
        others = {name: getattr(RULES, name)}
        assert replace(variant, **others) == RULES
        origin = {"armscye_s": 2.0, "strain_percentile": 100.0}.get(name, 0.0)
        ratio = (getattr(variant, name) - origin) / (getattr(RULES, name) - origin)
        assert ratio == pytest.approx(factor)


def test_a_dressing_far_from_every_limit_passes_throughout():
    assert judged(good()) == ALL


@pytest.mark.parametrize("name", SPOILT)
def test_a_dressing_beyond_a_limit_passes_where_this_limit_is_loose_enough(name):
    loose = tuple(factor for factor in FACTORS if factor > 1.15)
    passed = judged(SPOILT[name])
    assert passed.pop(name) == loose
    if name == "strain":
        # What is judged there is the strain of another part of the cloth.
        assert passed.pop("strain_percentile") == ()
    moments = passed.pop("moment")
    assert moments == (() if name in ("armscye_s", "gripper_distance") else (1.1, *loose))
    assert set(passed.values()) == {()}


def test_a_sleeve_that_is_on_late_passes_where_it_need_not_hold_for_long():
    trace = changed("armscye_s", slice(0, LATE), 1.0)
    assert judged(trace)["hold_time"] == tuple(factor for factor in FACTORS if factor < 1.05)


def test_another_part_of_the_cloth_is_judged_by_its_own_strain():
    strain = {
        variant.strain_percentile: np.full(ROWS, 2.0 * RULES.strain * (factor < 0.9))
        for name, factor, variant in variants(RULES)
        if name == "strain_percentile"
    }
    passed = judged(good(), strain)
    assert passed["strain_percentile"] == tuple(factor for factor in FACTORS if factor >= 0.9)
    assert passed["strain"] == FACTORS


def test_whoever_came_too_late_or_never_moved_passes_nowhere():
    late = Outcome(False, (Failure("timeout", "too late"),))
    assert judged(good(), outcome=late, finished=False) == NONE
    unreachable = Outcome(False, (Failure("ik_unreachable", "far"),))
    assert judged(None, outcome=unreachable) == NONE


def test_strain_is_read_at_each_percentile():
    mesh = sleeve_mesh(SleeveConfig(), np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 0, 1.0]))
    reader = StrainReader([90.0, 95.0, 90.0])
    # The farther from the origin, the more stretched along x.
    bent = mesh.vertices + [0.4, 0.0, 0.0] * mesh.vertices[:, :1] ** 2
    for cloth in (mesh.vertices, 1.2 * mesh.vertices, bent):
        reader(SimpleNamespace(mesh=mesh, cloth=cloth))
    columns = reader.columns
    assert list(columns) == [90.0, 95.0]
    for column in columns.values():
        assert column.shape == (3,)
        assert column[:2] == pytest.approx([0.0, 0.2], abs=1e-9)
    assert columns[90.0][2] < columns[95.0][2]


def test_what_is_read_stands_beside_the_rows_of_a_trace(posture, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    episode = Dressing(posture, EpisodeConfig(hold=0.1))
    reader = StrainReader([90.0, RULES.strain_percentile])
    path = episode.start + np.outer(np.linspace(0.0, 0.02, 5), [0.0, 0.0, 1.0])
    trace = follow(episode, path, 0.05, reader).trace
    np.testing.assert_array_equal(reader.columns[RULES.strain_percentile], trace.strain)
    assert np.all(reader.columns[90.0] <= trace.strain)


def one_job():
    return Job(3, PROTOCOL.entries[0], load_suite("paper5")[0], 0, 5, 6)


def test_an_episode_carries_its_verdicts(monkeypatch):
    job, seen = one_job(), []
    base = replace(SPOILT["grip_force"], tcp=good().tcp - SHOULDER + job.posture.shoulder)

    def record(source, posture, seed, config, observer):
        seen.append((source, posture, seed, config))
        mesh = sleeve_mesh(SleeveConfig(), np.zeros(3), np.eye(3)[0], np.eye(3)[2])
        for _ in range(ROWS):
            observer(SimpleNamespace(mesh=mesh, cloth=mesh.vertices))
        outcome = Outcome(False, metrics={"strain": 0.1})
        return Recording(outcome, base, None, np.zeros((1, 3)), time_left=0.0)

    monkeypatch.setattr(thresholds_verdicts, "record_answer", record)
    config = EpisodeConfig(time_limit=12.0)
    result = dress_and_judge("source", job, config)
    assert seen == [("source", job.posture, job.seed, config)]
    assert (result.index, result.entry, result.posture) == (3, job.entry, job.posture)
    assert result.outcome.metrics == {"strain": 0.1}
    for factor in FACTORS:
        assert verdict_of(result, "grip_force", factor) is (factor > 1.15)
    assert json.loads(json.dumps(result.extra)) == result.extra


def test_a_void_episode_has_no_verdicts(monkeypatch):
    void = Recording(Outcome(False, invalid="not finite"), None, None, np.zeros((1, 3)))
    monkeypatch.setattr(thresholds_verdicts, "record_answer", lambda *arguments: void)
    result = dress_and_judge(None, one_job(), EpisodeConfig())
    assert (result.outcome, result.extra) == (void.outcome, {})
    assert verdict_of(result, "strain", 1.0) is None
