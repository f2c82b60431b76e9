"""Policies learn from an operator of another style, which a row names."""

import json
from dataclasses import replace

import numpy as np
import pytest
from fake_benchmark import Threads, steady_demonstrate

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.plan import Plan, make_plan, style_of
from dressing_sim.benchmark.run.progress import silent
from dressing_sim.benchmark.run.runner import (
    Work,
    learned_by,
    learned_from,
    learned_source,
    learned_sources,
    record_demonstration,
    record_demonstrations,
)
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.benchmark.studies.evaluate import suites_in
from dressing_sim.benchmark.studies.protocols import find_protocol
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.expert import operator_of
from dressing_sim.suites.suites import load_suite

QUICK = "case_a?speed=0.2"
PROTOCOL = Protocol(
    "p",
    "case_b",
    (Entry("transport", "case_a"), Entry("transport", QUICK), Entry("transport", "baseline7:2")),
    demonstration_sets=2,
)


def test_a_style_stands_after_the_suite_and_changes_the_operator():
    assert (style_of("case_a"), style_of("baseline7:3?speed=0.2")) == ("", "speed=0.2")
    usual, other = operator_of("").config, operator_of("speed=0.2&sway=0").config
    assert other == replace(usual, speed=0.2, sway=0.0)


def test_the_postures_are_those_of_the_suite():
    plan = make_plan(PROTOCOL)
    assert plan.demonstrated[QUICK] == plan.demonstrated["case_a"]
    assert plan.demonstrated["baseline7:2"] == tuple(load_suite("baseline7:2"))
    assert Plan.from_dict(json.loads(json.dumps(plan.to_dict()))) == plan


@pytest.mark.parametrize(
    ("name", "told"),
    [("case_a?haste=2", "haste"), ("case_a?speed=fast", "fast"), ("case_a?speed=-1", "speed")],
)
def test_a_style_that_cannot_be_is_refused_before_anything_runs(name, told):
    with pytest.raises(InvalidInputError, match=told):
        make_plan(replace(PROTOCOL, entries=(Entry("transport", name),)))


def test_each_row_learns_from_its_operator_also_when_it_is_read_back(tmp_path):
    plan = make_plan(PROTOCOL)
    work = Work(steady_demonstrate)
    with Threads(2) as workers, open_run(tmp_path / "run", plan) as folder:
        taught = record_demonstrations(folder, workers, silent, work)
        sources = learned_sources(folder, plan.jobs, workers, silent, work)
    usual, quick = (taught[name, 1] for name in ("case_a", QUICK))
    assert [d.posture for d in usual] == [d.posture for d in quick]
    assert [d.seed for d in usual] == [d.seed for d in quick]
    # Twice the speed is half the samples.
    ratios = [len(a.positions) / len(b.positions) for a, b in zip(usual, quick, strict=True)]
    assert ratios == pytest.approx([2.0, 2.0], rel=0.03)
    again = load_run(tmp_path / "run")
    for name in ("case_a", QUICK):
        for one, other in zip(taught[name, 1], learned_from(again, name, 1), strict=True):
            assert np.array_equal(one.positions, other.positions)
    by_row = {learned_by(job): job for job in plan.jobs if job.demonstration_set == 1}
    paths = {}
    for key, job in by_row.items():
        frames, start = job.posture.frames(), np.array([0.4, 0.1, 0.5])
        relearned = learned_source(again, job, work)
        found, repeated = (
            one.generate(frames, start).positions for one in (sources[key], relearned)
        )
        assert np.array_equal(found, repeated)
        paths[key[1]] = found
    assert not np.array_equal(paths["case_a"], paths[QUICK])


def test_the_cache_tells_styles_apart(posture, tmp_path, monkeypatch):
    monkeypatch.setenv("DRESSING_SIM_CACHE", str(tmp_path))
    config = EpisodeConfig()
    styles = ("", "", "speed=0.2", "speed=0.2")
    found = [record_demonstration(0, posture, 0, config, style) for style in styles]
    lengths = [len(one.positions) for one in found]
    assert lengths[0] == lengths[1] > 1.5 * lengths[2]
    assert lengths[2] == lengths[3]
    assert len(list(tmp_path.rglob("*.h5"))) == 2


def test_the_command_line_takes_styles(tmp_path, monkeypatch):
    assert suites_in(f"{QUICK},baseline7:3") == [QUICK, "baseline7:3"]
    # A suite is meant by its name whatever lies in the folder where it is typed.
    (tmp_path / "case_a").mkdir()
    monkeypatch.chdir(tmp_path)
    assert suites_in("case_a") == ["case_a"]
    with pytest.raises(InvalidInputError, match="no such file and no suite"):
        suites_in("case_z?speed=0.2")


def test_the_protocol_compares_each_style_with_the_usual_one():
    entries = find_protocol("styles").entries
    styles = {style_of(entry.demonstrations) for entry in entries}
    assert len(styles) == 5
    assert "" in styles
    for entry in entries:
        operator_of(style_of(entry.demonstrations))
    policies = {entry.policy for entry in entries}
    assert len(entries) == len(policies) * len(("case_a", "case_b")) * len(styles)
