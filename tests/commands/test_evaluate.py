import json
import os
import signal
import sys
from functools import partial

import pytest
from fake_benchmark import (
    dask_cluster,
    is_running,
    start,
    steady_demonstrate,
    tries,
    wait_until,
    write_suite,
)

from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies import STUDIES, cost, study
from dressing_sim.benchmark.studies.cost import Cost
from dressing_sim.benchmark.studies.success_tables import next_to_paper
from dressing_sim.cli import main
from dressing_sim.episode import demonstration as demonstrations
from dressing_sim.errors import DressingSimError
from dressing_sim.learning import AugmentOptions
from dressing_sim.policies.paper import AUGMENTED, AugmentedTPGMMConfig, left_open


@pytest.fixture
def suite(tmp_path):
    return write_suite(tmp_path / "suite.json", 6)


@pytest.fixture
def arguments(suite):
    """Four rows and six postures."""
    policies = ["--policies", "expert,tp-gmm"]
    return ["evaluate", "--suite", suite, *policies, "--seed", "2", "--no-pictures"]


def play(folder, arguments, out, *more):
    """Run the command without physics to its end; its exit code and what it printed."""
    process = start(folder, [*arguments, "--out", str(out), *more])
    output, errors = process.communicate()
    return process.returncode, output, errors


def count_lines(out):
    path = out / "episodes.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def files(out):
    return {name: (out / name).read_bytes() for name in ("summary.json", "episodes.jsonl")}


@pytest.fixture
def held(tmp_path, arguments):
    """A run with some episodes done and two that do not end; its process, folders and workers."""
    folder, out = tmp_path / "held", tmp_path / "out"
    folder.mkdir()
    whole = tmp_path / "whole"
    whole.mkdir()
    assert play(whole, arguments, whole / "out", "--workers", "1")[0] == 0

    # The fifth episode holds, and with it all that come after it.
    (folder / "hold-4").touch()
    (folder / "hold-5").touch()
    process = start(folder, [*arguments, "--out", str(out), "--workers", "2"])
    try:
        wait_until(lambda: tries(folder, 4) and tries(folder, 5) and count_lines(out) >= 4)
        yield process, folder, out, whole / "out"
    finally:
        process.kill()
        process.communicate()


def workers_of(folder):
    return [pid for file in folder.glob("tried-*") for pid in map(int, file.read_text().split())]


def assert_goes_on(held, arguments):
    """The folder is resumable: what was done is not repeated, and the end is the same."""
    _, folder, out, whole = held
    done = load_run(out).finished
    (folder / "hold-4").unlink()
    (folder / "hold-5").unlink()
    code, _, errors = play(folder, arguments, out, "--resume", "--workers", "2")
    assert code == 0, errors
    assert files(out) == files(whole)
    assert all(len(tries(folder, index)) == 1 for index in done)
    assert len(tries(folder, 4)) == len(tries(folder, 5)) == 2


def test_a_run_whose_process_is_killed_goes_on_and_ends_with_the_same_bytes(held, arguments):
    process, folder, out, _ = held
    process.send_signal(signal.SIGKILL)
    process.communicate()
    wait_until(lambda: not any(is_running(pid) for pid in workers_of(folder)))  # no orphans
    with (out / "episodes.jsonl").open("a") as file:
        file.write('{"index": 4, "protocol": "pap')  # as if killed while it wrote
    assert_goes_on(held, arguments)


def test_an_interrupted_run_says_how_to_go_on_and_does(held, arguments):
    process, folder, out, _ = held
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate()
    assert process.returncode == 130
    assert output == ""
    last = errors.splitlines()[-1]
    assert last.startswith("dressing-sim: interrupted; to continue: dressing-sim evaluate --suite")
    assert last.endswith("--resume")
    assert "Traceback" not in errors
    assert not any(is_running(pid) for pid in workers_of(folder))
    assert not (out / "summary.json").exists()
    assert_goes_on(held, arguments)


def test_ctrl_c_in_a_terminal_reaches_the_workers_too_and_they_are_silent(tmp_path, arguments):
    (tmp_path / "hold").touch()
    process = start(tmp_path, [*arguments, "--workers", "2"], start_new_session=True, cwd=tmp_path)
    wait_until(lambda: workers_of(tmp_path))
    os.killpg(process.pid, signal.SIGINT)
    _, errors = process.communicate()
    assert process.returncode == 130
    assert "Traceback" not in errors
    assert errors.splitlines()[-1].startswith("dressing-sim: interrupted")


def test_an_unfinished_run_is_not_replaced_and_other_settings_are_refused(held, arguments):
    process, folder, out, _ = held
    process.kill()
    process.communicate()
    before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
    for more, part in (
        ((), "unfinished"),
        (("--resume", "--seed", "3"), "seed: 2 there, 3 now"),
        (("--resume", "--suite", "paper5"), "tested.0.name: 'arm0' there, 'bent10' now"),
    ):
        code, output, errors = play(folder, arguments, out, *more)
        assert (code, output) == (2, "")
        assert part in errors
        assert "Traceback" not in errors
    assert {path: path.read_bytes() for path in out.rglob("*") if path.is_file()} == before


def test_a_finished_run_is_replaced_and_can_be_resumed(tmp_path, arguments, suite):
    out = tmp_path / "out"
    assert play(tmp_path, arguments, out)[0] == 0
    before = files(out)
    code, _, errors = play(tmp_path, arguments, out, "--resume")
    assert (code, files(out)) == (0, before), errors
    assert len(tries(tmp_path, 0)) == 1
    code, _, errors = play(tmp_path, arguments, out, "--seed", "3")
    assert (code, files(out)) == (2, before)
    assert "holds a finished run with another config (seed: 2 there, 3 now); choose" in errors
    assert play(tmp_path, arguments, out)[0] == 0
    assert play(tmp_path, arguments, out, "--seed", "3", "--force")[0] == 0
    assert load_run(out).plan.seed == 3


def words(text):
    """What is in a table of the terminal, without its frame."""
    return " ".join(text.replace("│", " ").split())


def test_the_papers_protocol_is_shown_next_to_the_papers_table(tmp_path, arguments):
    code, output, errors = play(tmp_path, arguments, tmp_path / "out")
    assert code == 0, errors
    heading, *rows = next_to_paper(json.loads((tmp_path / "out/summary.json").read_text())["rows"])
    assert len(rows) == 4
    told = words(output)
    assert all(" ".join(line) in told for line in rows)
    assert all(name in told for name in heading)
    assert f"policies: {left_open()} written to" in told


@pytest.mark.parametrize(
    "more",
    [("--protocol", "budget"), ("--variation", "friction"), ("--policies", "expert")],
    ids=["another protocol", "under variation", "none of the paper's policies"],
)
def test_what_is_not_the_papers_is_shown_with_what_went_wrong(tmp_path, arguments, more):
    code, output, errors = play(tmp_path, arguments, tmp_path / "out", *more)
    assert code == 0, errors
    told = words(output)
    assert "what went wrong" in told
    assert "the paper's" not in told
    assert ("policies: " in told) == ("--policies" not in more)


def test_a_dask_cluster_gives_the_same_bytes(tmp_path, arguments):
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    there.mkdir()
    assert play(here, arguments, here / "out", "--workers", "2")[0] == 0
    (there / "kill-7").touch()
    with dask_cluster(tmp_path, 2) as cluster:
        code, output, errors = play(
            there, arguments, there / "out", "--scheduler", cluster.address, "--json"
        )
    assert code == 0, errors
    assert files(there / "out") == files(here / "out")
    assert json.loads(output) == json.loads((there / "out/summary.json").read_text())
    assert len(tries(there, 7)) == 2


@pytest.mark.parametrize(
    ("more", "part"),
    [
        (["--workers", "0"], "workers is 0, valid is 1 or more"),
        (["--workers", "1", "--scheduler", "tcp://127.0.0.1:9"], "exclude each other"),
        (["--scheduler", "nonsense://"], "nonsense"),
        (["--protocol", "nothing"], "unknown protocol 'nothing'; valid is one of paper"),
        (["--protocol", "paper-cost", "--suite", "paper5"], "do not apply"),
        (["--protocol", "paper-cost", "--policies", "expert"], "do not apply"),
        (["--variation", "friction,colour"], "unknown factor 'colour'; valid is friction"),
        (["--suite", "nowhere"], "unknown suite 'nowhere'; valid is one of"),
        (["--policies", "nobody"], "unknown policy 'nobody'; valid is one of"),
        (["--policies", "json:JSONDecodeError"], "'json:JSONDecodeError'"),
        (["--seed", "-1"], "seed is -1"),
        (["--films", "-1"], "films is -1, valid is a whole number, 0 to 100"),
        (["--protocol", "paper-cost", "--films", "1"], "films is 1, valid is 0 with protocol"),
        (["--out", "text.txt"], "text.txt"),
        (["--out", "text.txt/out"], "text.txt"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(more, part, capsys, tmp_path, monkeypatch):
    def fails(*_arguments, **_settings):
        raise AssertionError("a simulation was started")

    monkeypatch.setattr(study, "run_jobs", fails)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "text.txt").write_text("in the way")
    with pytest.raises(SystemExit) as stopped:
        main(["evaluate", *more])
    output = capsys.readouterr()
    assert stopped.value.code == 2
    assert part in output.err
    assert output.err.startswith("dressing-sim: ")
    assert output.err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["text.txt"]


def test_films_without_opengl_are_one_line_before_anything_is_run(capsys, tmp_path, monkeypatch):
    def none():
        raise DressingSimError("no offscreen OpenGL works here: install EGL")

    monkeypatch.setattr("dressing_sim.benchmark.studies.evaluate.gl_backend", none)
    monkeypatch.setattr(study, "run_jobs", None)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        main(["evaluate", "--films", "1"])
    assert stopped.value.code == 2
    assert capsys.readouterr().err == "dressing-sim: no offscreen OpenGL works here: install EGL\n"
    assert not list(tmp_path.iterdir())


def test_evaluate_writes_its_files_and_prints_the_summary(capsys, tmp_path, posture, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["dressing-sim", "evaluate", "--seed", "2"])
    (tmp_path / "one.json").write_text(json.dumps({"postures": [posture.to_dict()]}))
    main(["evaluate", "--suite", "one.json", "--policies", "expert", "--workers", "1", "--out",
          "a/b", "--seed", "2", "--json"])  # fmt: skip
    output = capsys.readouterr()
    summary = json.loads(output.out)
    assert summary == json.loads((tmp_path / "a/b/summary.json").read_text())
    (row,) = summary["rows"]
    assert (row["policy"], row["n_episodes"], row["n_void"]) == ("expert", 1, 0)
    assert {
        "policy",
        "demonstrations",
        "n_episodes",
        "n_success",
        "pc_success",
        "pc_success_ci95",
        "failures",
        "n_void",
    } <= set(row)
    assert summary["config"]["seed"] == 2
    (line,) = (tmp_path / "a/b/episodes.jsonl").read_text().splitlines()
    assert json.loads(line)["versions"] == demonstrations.versions()
    assert "dressing-sim evaluate --seed 2" in (tmp_path / "a/b/report.md").read_text()
    assert "episodes: 1 of 1" in output.err


def test_the_cost_protocol_learns_from_both_cases_and_writes_its_report(
    capsys, tmp_path, monkeypatch
):
    config = AugmentedTPGMMConfig(options=AugmentOptions(max_iterations=1), samples=60)
    quick = partial(Cost, Work(demonstrate=steady_demonstrate), config)
    monkeypatch.setitem(STUDIES, "cost", quick)
    monkeypatch.setattr(cost, "RUNS", 1)
    out = tmp_path / "out"
    main(["evaluate", "--protocol", "paper-cost", "--out", str(out), "--seed", "2", "--json"])
    summary = json.loads(capsys.readouterr().out)
    assert summary["config"]["seed"] == 2
    assert json.loads((out / "summary.json").read_text()) == summary
    rows = [(row["policy"], row["demonstrations"]) for row in summary["rows"]]
    assert rows == [(policy, case) for case in ("case_a", "case_b") for policy in AUGMENTED]
    assert "| tp-gmm-rf | case_a | 2 + 0 |" in (out / "report.md").read_text()
    assert (out / "cost.svg").is_file()
    assert load_run(out).plan.protocol.study == "cost"
