import ast
import os
import signal
import time
from pathlib import Path

import pytest
from fake_benchmark import start, tries, wait_until, write_suite

import dressing_sim

#: A clock on the wall that jumps by years at every look, forth and back.
JUMPING = """
import itertools, time
jumps = itertools.cycle((0.0, 1e9, -1e9, 3e7))
true, true_ns = time.time, time.time_ns
time.time = lambda: true() + next(jumps)
time.time_ns = lambda: true_ns() + int(next(jumps) * 1e9)
"""


@pytest.fixture
def arguments(tmp_path):
    suite = write_suite(tmp_path / "suite.json", 3)
    return ["evaluate", "--suite", suite, "--policies", "expert", "--no-pictures"]


def results(folder):
    return {name: (folder / name).read_bytes() for name in ("episodes.jsonl", "summary.json")}


def undisturbed(folder, arguments):
    folder.mkdir()
    process = start(folder, [*arguments, "--out", str(folder / "out"), "--workers", "1"])
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    return results(folder / "out")


def test_the_second_process_in_a_folder_says_so_at_once_and_the_first_goes_on(tmp_path, arguments):
    whole = undisturbed(tmp_path / "whole", arguments)
    folder = tmp_path / "held"
    folder.mkdir()
    (folder / "hold-1").touch()
    out = folder / "out"
    typed = [*arguments, "--out", str(out), "--workers", "1"]
    first = start(folder, typed)
    wait_until(lambda: tries(folder, 1))
    before = (out / "episodes.jsonl").read_bytes()
    for more in (["--resume"], ["--force"]):
        second = start(folder, [*typed, *more])
        output, errors = second.communicate(timeout=120)
        assert (second.returncode, output) == (2, "")
        assert errors == f"dressing-sim: {out}: another process is running in it\n"
    assert first.poll() is None
    assert (out / "episodes.jsonl").read_bytes().startswith(before)
    (folder / "hold-1").unlink()
    _, errors = first.communicate()
    assert first.returncode == 0, errors
    assert results(out) == whole


def test_a_worker_that_is_suspended_loses_and_doubles_nothing(tmp_path, arguments):
    whole = undisturbed(tmp_path / "whole", arguments)
    folder = tmp_path / "held"
    folder.mkdir()
    (folder / "hold-1").touch()
    process = start(folder, [*arguments, "--out", str(folder / "out"), "--workers", "2"])
    wait_until(lambda: tries(folder, 1))
    (worker,) = tries(folder, 1)
    os.kill(worker, signal.SIGSTOP)
    (folder / "hold-1").unlink()
    time.sleep(3.0)
    assert process.poll() is None
    os.kill(process.pid, signal.SIGSTOP)
    os.kill(worker, signal.SIGCONT)
    time.sleep(1.0)
    os.kill(process.pid, signal.SIGCONT)
    _, errors = process.communicate()
    assert process.returncode == 0, errors
    assert tries(folder, 1) == [worker]
    assert results(folder / "out") == whole


def test_a_clock_that_jumps_changes_no_bit(tmp_path, arguments, monkeypatch):
    whole = undisturbed(tmp_path / "whole", arguments)
    (tmp_path / "sitecustomize.py").write_text(JUMPING)
    before = os.environ.get("PYTHONPATH", "")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(filter(None, [str(tmp_path), before])))
    assert undisturbed(tmp_path / "jumping", arguments) == whole


def test_nothing_asks_for_the_time_of_day():
    wall = {"time", "time_ns", "now", "utcnow", "today", "localtime", "gmtime", "st_mtime"}
    for path in Path(dressing_sim.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Attribute) and node.attr in wall:
                of = node.value.id if isinstance(node.value, ast.Name) else ""
                asked = f"{path}:{node.lineno}: {of}.{node.attr}"
                assert of not in ("time", "datetime", "date"), asked
                assert node.attr != "st_mtime", asked
