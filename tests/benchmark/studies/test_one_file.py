"""A study, a suite and a policy are each added by one file: this one, and a file of JSON."""

import json
import sys
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest
from fake_benchmark import Threads, fake_work

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report.document import Document, Table
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.replay import replay_episode
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.benchmark.studies import STUDIES, find_study
from dressing_sim.benchmark.studies.study import EpisodeStudy, run_study
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import load_suite


@dataclass(frozen=True)
class Bends(EpisodeStudy):
    """How far the elbows of dressed arms were bent."""

    def summarise(self, folder, results):
        dressed = [r.posture.elbow_deg for r in results if r.outcome.success]
        return {"mean_elbow_deg": float(np.mean(dressed)), "n": len(dressed)}

    def document(self, folder, results, summary, command):
        cells = [["elbow of dressed arms"], [f"{summary['mean_elbow_deg']:.1f} deg"]]
        return Document("Bends", command, (Table(cells),))


class Straight:
    """From where the gripper is to the shoulder."""

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        return np.linspace(start, frames.shoulder.b, 20)


@pytest.fixture
def suite(tmp_path):
    angles = {"flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}
    arms = [{"name": f"mine{i}", "elbow_deg": 10.0 * i, **angles} for i in range(4)]
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({"postures": arms}))
    return str(path)


@pytest.fixture
def importable(monkeypatch, tmp_path):
    """The name under which this module can be imported, here and in other processes."""
    (tmp_path / "added_in_one_file.py").write_text(Path(__file__).read_text())
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(sys.modules, "added_in_one_file", sys.modules[__name__])
    return "added_in_one_file"


def test_a_suite_and_a_policy_are_found_by_their_names(suite, importable):
    assert [posture.name for posture in load_suite(suite)] == [f"mine{i}" for i in range(4)]
    assert isinstance(make_policy(f"{importable}:Straight"), Straight)


def test_a_study_runs_from_plan_to_report_and_can_be_replayed(tmp_path, suite, importable):
    entries = (Entry("expert"), Entry(f"{importable}:Straight", "case_a"))
    protocol = Protocol("bends", suite, entries, study=f"{importable}:Bends")
    study = replace(find_study(protocol.study), work=fake_work(tmp_path))
    out = tmp_path / "run"
    with Threads(1) as workers:
        finished = run_study(study, make_plan(protocol), workers, out, command="by hand")
    assert finished.summary["n"] == sum(r.outcome.success for r in finished.results) > 0
    assert "provenance" in finished.summary
    assert json.loads((out / "summary.json").read_text()) == finished.summary
    assert "elbow of dressed arms" in (out / "report.md").read_text()
    assert json.loads((out / "config.json").read_text())["protocol"]["study"] == protocol.study
    run = load_run(out)
    assert isinstance(find_study(run.plan.protocol.study), Bends)
    assert not replay_episode(study, run, 0).differences


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_of_ours_is_found(name):
    assert find_study(name).stage


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("nothing", "unknown study 'nothing'; valid is one of success"),
        ("nowhere:Study", "No module named 'nowhere'"),
        ("json:JSONEncoder", "unknown study"),
    ],
)
def test_another_name_is_an_error_that_says_what_is_valid(name, part):
    with pytest.raises(InvalidInputError, match=part):
        find_study(name)


def test_a_study_without_episodes_cannot_be_replayed(tmp_path, suite):
    plan = make_plan(Protocol("p", suite, (Entry("tp-gmm-rf", "case_a"),), study="cost"))
    with open_run(tmp_path / "run", plan) as run, pytest.raises(InvalidInputError) as caught:
        find_study("cost").repeat(run, plan.jobs[0])
    assert "its study 'cost' cannot be replayed" in str(caught.value)
