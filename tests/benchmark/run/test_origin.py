import json

import pytest
from fake_benchmark import write_suite

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.folder import CONFIG
from dressing_sim.benchmark.run.origin import Accept, Origin
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.errors import InvalidInputError
from dressing_sim.numerics import numerics

OTHER = {**numerics(), "fingerprint": "0123456789ab", "blas": "openblas 0.3 SkylakeX"}


@pytest.fixture
def plan(tmp_path):
    return make_plan(Protocol("p", write_suite(tmp_path / "suite.json", 2), (Entry("expert"),)))


@pytest.fixture
def folder(tmp_path, plan):
    with open_run(tmp_path / "run", plan):
        pass
    return tmp_path / "run"


def settings(folder):
    return json.loads((folder / CONFIG).read_text())


def change(folder, **provenance):
    values = settings(folder)
    values["provenance"] |= provenance
    (folder / CONFIG).write_text(json.dumps(values))


def test_a_folder_says_where_its_episodes_come_from_after_all_else(folder):
    assert list(settings(folder))[-1] == "provenance"
    origin = load_run(folder).origin
    assert origin.numerics == [dict(numerics())]
    assert origin.other_numerics(numerics()) == ""


def test_another_commit_is_no_reason_to_refuse(folder, plan):
    change(folder, commit="abc", python="3.12.0", version="0.0.9")
    before = (folder / CONFIG).read_bytes()
    with open_run(folder, plan, resume=True):
        pass
    assert (folder / CONFIG).read_bytes() == before


def test_other_numerics_are_refused_and_named_with_what_to_do(folder, plan):
    before = (folder / CONFIG).read_bytes()
    with (
        pytest.raises(InvalidInputError, match="SkylakeX") as caught,
        open_run(folder, plan, resume=True, numerics=lambda: OTHER),
    ):
        pass
    assert "--accept-numerics" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert (folder / CONFIG).read_bytes() == before


def test_other_numerics_that_are_accepted_are_written_down(folder, plan):
    for _ in range(2):  # again with the same ones says nothing new
        with open_run(folder, plan, True, lambda: OTHER, accept=Accept(numerics=True)):
            pass
    said = settings(folder)["provenance"]
    assert said["numerics"] == dict(numerics())
    assert said["later_numerics"] == [{"episodes_before": 0, "numerics": OTHER}]
    origin = load_run(folder).origin
    assert "SkylakeX" in origin.other_numerics(numerics())
    assert "SkylakeX" in origin.other_numerics(OTHER)


def test_other_numerics_explain_nothing_where_versions_differ(folder):
    values = settings(folder)
    values["versions"]["mujoco"] = "3.0"
    assert Origin.of(values).other_numerics(OTHER) == ""


def test_a_folder_of_an_earlier_version_says_nothing_and_can_go_on(folder, plan):
    values = settings(folder)
    del values["provenance"]
    (folder / CONFIG).write_text(json.dumps(values))
    with open_run(folder, plan, resume=True, numerics=lambda: OTHER) as run:
        assert run.origin.numerics == []
        assert run.origin.other_numerics(OTHER) == ""


def test_other_people_s_code_that_changed_is_named(tmp_path, monkeypatch):
    (tmp_path / "their_policy.py").write_text(POLICY)
    monkeypatch.syspath_prepend(tmp_path)
    protocol = Protocol(
        "p",
        write_suite(tmp_path / "suite.json", 1),
        (Entry("their_policy:Still", str(tmp_path / "suite.json")),),
    )
    plan = make_plan(protocol)
    with open_run(tmp_path / "run", plan):
        pass
    assert list(settings(tmp_path / "run")["provenance"]["sources"]) == ["their_policy:Still"]
    (tmp_path / "their_policy.py").write_text(POLICY + "# another line\n")
    with (
        pytest.raises(InvalidInputError, match="their_policy:Still"),
        open_run(tmp_path / "run", plan, resume=True),
    ):
        pass
    with open_run(tmp_path / "run", plan, resume=True, accept=Accept(changes=True)) as run:
        assert run.origin.mixed("their_policy:Still")
        assert run.origin.mixed("their_policy:Still?speed=2")
        assert not run.origin.mixed("tp-gmm")
    later = settings(tmp_path / "run")["provenance"]["later_code"]
    assert [step["episodes_before"] for step in later] == [0]
    # It goes on with the code that it last had, and needs to be asked no more.
    with open_run(tmp_path / "run", plan, resume=True) as run:
        assert run.origin.mixed("their_policy:Still")
    assert settings(tmp_path / "run")["provenance"]["later_code"] == later


def test_other_versions_of_packages_are_accepted_only_if_that_is_said(tmp_path):
    suite = write_suite(tmp_path / "suite.json", 1)
    plan = make_plan(Protocol("p", suite, (Entry("expert"),)))
    with open_run(tmp_path / "run", plan):
        pass
    values = settings(tmp_path / "run")
    values["versions"]["mujoco"] = "3.99"
    (tmp_path / "run" / CONFIG).write_text(json.dumps(values))
    with (
        pytest.raises(InvalidInputError, match=r"mujoco: '3\.99' then"),
        open_run(tmp_path / "run", plan, resume=True),
    ):
        pass
    with open_run(tmp_path / "run", plan, resume=True, accept=Accept(changes=True)) as run:
        assert run.origin.mixed("expert")


POLICY = """
class Still:
    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        return [start, start]
"""


def test_other_numerics_are_named_after_other_code_was_accepted_too(folder):
    values = settings(folder)
    now = dict(values["versions"])
    values["versions"] = {**now, "mujoco": "3.9.9"}
    values["provenance"]["later_code"] = [{"versions": now, "sources": {}}]
    (folder / CONFIG).write_text(json.dumps(values))
    assert "SkylakeX" in load_run(folder).origin.other_numerics(OTHER)
