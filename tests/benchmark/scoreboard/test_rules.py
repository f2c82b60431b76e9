import json
from dataclasses import replace
from pathlib import Path

import pytest
from submitted import ADA, ROWS, fake_run, others_run

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.origin import Origin
from dressing_sim.benchmark.run.plan import dressing_person, make_plan
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.scoreboard.rules import TEST_SUITES, Statement, check_run
from dressing_sim.benchmark.scoreboard.submission import submit
from dressing_sim.errors import InvalidInputError
from dressing_sim.numerics import numerics
from dressing_sim.policies.host import PolicyLimits
from dressing_sim.suites.suites import load_suite
from dressing_sim.suites.wardrobe import world_with

PAPER = Protocol("mine", "paper5", ROWS)


def refused(plan, part, statement=ADA, **origin):
    """A run of a plan is refused, before anything of it has been run."""
    found = Origin.here(plan, numerics())
    config = replace(found, provenance=found.provenance | origin).into(plan.to_dict())
    with pytest.raises(InvalidInputError, match=part):
        check_run(RunFolder(Path("run"), json.loads(json.dumps(config)), b""), statement)


def test_a_run_that_could_stand_there_is_only_not_finished():
    refused(make_plan(PAPER), "0 of 10 episodes, valid is all; go on with --resume")


@pytest.mark.parametrize("suite", ["val50", "case_a", "random:5"])
def test_only_test_suites_count(suite):
    refused(make_plan(replace(PAPER, suite=suite)), "valid is a test suite: paper5, test200, hard")


@pytest.mark.parametrize(
    ("entries", "part"),
    [
        ((ROWS[0], ROWS[0]), "two that are the same"),
        ((Entry("tp-gmm", "paper5"),), "demonstrations 'paper5', valid is one of baseline7"),
        ((Entry("tp-gmm", "hard_elbow:1"),), "was demonstrated, valid is a posture that is no"),
        ((Entry("tp-gmm", "random:3"),), "demonstrations 'random:3', valid is one of baseline7"),
        ((Entry("expert", None, ("friction",)),), "a varied world"),
        ((Entry("expert", "case_a"),), "'expert' learned from 'case_a'"),
    ],
)
def test_rows_are_comparable(entries, part):
    if entries[0].demonstrations == "paper5":
        part = "was demonstrated, valid is a posture that is no test's"
    refused(make_plan(replace(PAPER, entries=entries)), part)


def test_the_world_the_arms_and_the_limits_are_the_benchmarks():
    refused(make_plan(PAPER, config=world_with("tshirt-l")), "without --garment and --robot")
    person = dressing_person(make_plan(PAPER), "male_small")
    refused(person, "valid is a run without --person")
    refused(make_plan(PAPER, policy_limits=PolicyLimits(fit_time=1e4)), "without --fit-time")
    refused(make_plan(PAPER, seed=3), "seed 3, valid is a run with --seed 0")
    judged = replace(PAPER, entries=(Entry("tp-gmm?judge=mine.json", "case_a"),))
    plan = replace(make_plan(PAPER), protocol=judged)
    refused(plan, "reads a judge's file")


def test_more_than_one_version_of_the_code_is_said(tmp_path, monkeypatch):
    folder = fake_run(tmp_path, monkeypatch)
    config = json.loads((folder / "config.json").read_text())
    later = {"episodes_before": 3, "versions": config["versions"] | {"mujoco": "4.0.1"}}
    config["provenance"]["later_code"] = [later | {"sources": {}}]
    (folder / "config.json").write_text(json.dumps(config))
    with pytest.raises(InvalidInputError, match="say so with --accept-changes"):
        submit(folder, ADA)
    assert '"mixed_code": true' in submit(folder, replace(ADA, mixed_code=True))


def test_whose_policies_they_are_is_said(tmp_path, monkeypatch):
    folder = others_run(tmp_path, monkeypatch)
    with pytest.raises(InvalidInputError, match="valid is --package with what pip installs"):
        submit(folder, ADA)
    assert '"package": "mine==1.0"' in submit(folder, replace(ADA, package="mine==1.0"))


def test_no_built_in_demonstration_is_on_a_test_posture():
    tested = {replace(one, name="") for name in TEST_SUITES for one in load_suite(name)}
    for name in ("case_a", "case_b", "baseline7", "val50"):
        assert not tested & {replace(one, name="") for one in load_suite(name)}


def test_a_name_may_be_anybodys():
    for name in ("Ада Л.", "O'Neill (lab)", "李明", "Zoë-Ann"):
        assert replace(ADA, name=name).name == name
    assert Statement("A", "2026-01-31").link == ""
