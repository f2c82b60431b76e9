"""The study of confidence, on runs whose episodes are decided by the bend of the elbow."""

import json
import shutil
from dataclasses import asdict, replace
from types import SimpleNamespace

import numpy as np
import pytest
from fake_benchmark import Threads, steady_demonstrate

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.run import runner
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies.confidence import (
    Confidence,
    Looking,
    Seen,
    confidence_plan,
    row_of,
)
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.cli import main
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.errors import InvalidInputError, PolicyError
from dressing_sim.policies.confidence import FEATURES, Judge
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.suites.suites import load_suite

POSTURES = load_suite("val50")
ROWS = (Entry("expert"), Entry("transport", "case_a"))


def judged_by_the_elbow(source, posture, *_):
    """What would be an episode: a bent elbow is not dressed, but for some luck."""
    bend = Skeleton.of(posture.frames()).bend
    luck = 0.15 * np.sin(1000.0 * posture.elbow_deg)
    missed = () if bend + luck < 0.6 else (Failure("stuck", "caught"),)
    return Recording(Outcome(not missed, missed), None, None, np.empty((0, 3)))


def never(*_):
    raise AssertionError("simulated")


def finished(folder, postures, sets=1, rows=ROWS):
    """A finished run."""
    suite = folder.with_suffix(".json")
    suite.write_text(json.dumps({"postures": [p.to_dict() for p in postures]}))
    plan = make_plan(Protocol("p", str(suite), rows, demonstration_sets=sets))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "record", judged_by_the_elbow)
        run_study(Success(runner.Work(steady_demonstrate)), plan, Threads(1), folder)
    return folder


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs")
    training = finished(folder / "training", POSTURES[:24])
    return training, finished(folder / "tested", POSTURES[24:36], sets=2)


@pytest.fixture(scope="module")
def done(runs, tmp_path_factory):
    out = tmp_path_factory.mktemp("confidence")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "record", never)
        return run_study(Confidence(), confidence_plan(*runs), Threads(1), out), out


def test_rows_are_those_that_learned_and_every_episode_is_there(done, runs):
    finished, _ = done
    rows = finished.summary["rows"]
    assert [(row["policy"], row["demonstrations"]) for row in rows] == [("transport", "case_a")]
    for row in rows:
        assert (row["n_training"], row["n_episodes"], row["n_unanswered"]) == (24, 12, 0)
    summary = json.loads((runs[1] / "summary.json").read_text())
    for row, tested in zip(rows, summary["rows"][1:], strict=True):
        assert row["n_success"] == tested["n_success"]
        assert row["coverage"][0]["pc_success"] == tested["pc_success"] == row["pc_success"]
        assert row["surest"][0]["pc_coverage"] == 100.0
    tried = [(r.part, r.demonstration_set) for r in finished.results]
    assert tried == [("training", 0), ("tested", 0), ("tested", 1)]


def test_it_learns_what_decides_and_parts_sum_to_the_score(done):
    for row in done[0].summary["rows"]:
        parts = row["miscalibration"] - row["discrimination"] + row["uncertainty"]
        assert row["brier"] == pytest.approx(parts, abs=1e-12)
        assert row["gain"] > 0.02
        assert row["judge"]["features"]["bend"]["weight"] < 0.0
        half = row["surest"][-1]
        assert half["pc_success"] > row["pc_success"]


def test_only_training_decides_the_judge(done, runs, tmp_path):
    """A run whose tested episodes all fail has the same judges."""
    finished, _ = done
    training, tested = (
        [s for r in finished.results if r.entry == ROWS[1] and r.part == part for s in r.episodes]
        for part in ("training", "tested")
    )
    other = [Seen(one.index, False, one.features) for one in tested]
    row = row_of(ROWS[1], training, other, finished.summary["rows"][0]["judge"]["source"])
    assert row["judge"] == finished.summary["rows"][0]["judge"]
    assert row["pc_success"] == 0.0


def test_the_report_has_a_table_and_two_plots(done):
    finished, out = done
    assert {file.name for file in out.glob("*.svg")} == {
        "confidence-reliability.svg",
        "confidence-coverage.svg",
    }
    told = markdown(finished.document)
    assert "| transport on case_a |" in told
    assert f"{finished.summary['rows'][0]['brier']:.3f}" in told


def test_features_are_found_again_in_the_lines(done):
    finished, out = done
    lines = load_run(out).lines
    assert len(lines) == len(finished.results)
    first = finished.results[0]
    assert isinstance(first, Looking)
    assert len(first.episodes[0].features) == len(FEATURES)


def test_the_command_writes_a_judge_for_each_row(runs, tmp_path, monkeypatch, done, capsys):
    monkeypatch.setattr("dressing_sim.commands.studies.Processes", Threads)
    out = tmp_path / "out"
    main(["confidence", *map(str, runs), "--out", str(out), "--workers", "1", "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert summary["rows"] == json.loads(json.dumps(done[0].summary["rows"]))
    judges = sorted(out.glob("judge-*.json"))
    assert [file.name for file in judges] == ["judge-transport-case_a.json"]
    assert Judge.load(judges[0]).to_dict() == summary["rows"][0]["judge"]


def test_a_policy_without_an_answer_is_counted_and_left_out(runs, tmp_path, monkeypatch):
    shown = len(POSTURES[24:36])
    run = load_run(runs[1])
    lines = [run.line(index) for index in range(2 * shown)]
    lines[shown]["failures"] = [asdict(Failure("policy_error", "raised"))]
    lines[shown]["success"] = False
    lines[shown + 1]["abstained"] = "too bent"
    damaged = tmp_path / "damaged"
    shutil.copytree(runs[1], damaged)
    (damaged / "episodes.jsonl").write_text("".join(json.dumps(one) + "\n" for one in lines))
    told = run_study(Confidence(), confidence_plan(runs[0], damaged), Threads(1), tmp_path / "out")
    assert [row["n_unanswered"] for row in told.summary["rows"]] == [2]
    assert told.summary["rows"][0]["n_episodes"] == shown - 2

    def unanswered(*_):
        raise PolicyError("no path")

    monkeypatch.setattr("dressing_sim.benchmark.studies.confidence.policy_path", unanswered)
    with pytest.raises(InvalidInputError, match="transport on case_a: has 0 training and 0 tested"):
        run_study(Confidence(), confidence_plan(*runs), Threads(1), tmp_path / "none")


def test_a_row_without_paths_leaves_the_others(done, runs):
    finished, _ = done
    plan = confidence_plan(*runs)
    entries = (*plan.protocol.entries, Entry("transport-replan", "case_a"))
    plan = replace(plan, protocol=replace(plan.protocol, entries=entries))
    told = Confidence().summarise(SimpleNamespace(plan=plan), finished.results)
    assert told["rows"] == finished.summary["rows"]
    assert len(told["left_out"]) == 1
    assert "transport-replan on case_a: has 0 training" in told["left_out"][0]
    text = markdown(Confidence().document(None, finished.results, told, "c"))
    assert "Left out: row transport-replan on case_a" in text


def test_runs_that_do_not_fit_are_errors(runs, tmp_path):
    training, tested = runs
    with pytest.raises(InvalidInputError, match=r"is in .*training too; valid is a run on"):
        confidence_plan(training, training)
    expert = finished(tmp_path / "expert", POSTURES[:1], rows=ROWS[:1])
    with pytest.raises(InvalidInputError, match="no row in common that learned"):
        confidence_plan(expert, tested)
    lines = (expert / "episodes.jsonl").read_text().splitlines(keepends=True)
    (expert / "episodes.jsonl").write_text("".join(lines[:-1]))
    with pytest.raises(InvalidInputError, match="has 0 of 1 episodes"):
        confidence_plan(expert, tested)
    with pytest.raises(InvalidInputError, match="no run here"):
        confidence_plan(tmp_path / "nothing", tested)
