import json
import subprocess
import sys

import crash
from crash_checks import Whole, check_killed


def test_two_kills_lose_nothing():
    command = [sys.executable, crash.__file__, "--count", "2", "--seed", "3"]
    done = subprocess.run(
        [*command, "--only", "demonstrate"], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    counts, told = done.stdout.splitlines()
    assert json.loads(counts)["kills"]["demonstrate"] >= 2
    assert json.loads(counts)["faults"] == []
    assert told.endswith(" kills, 0 faults")


def test_what_is_lost_doubled_or_damaged_is_a_fault(tmp_path):
    earlier = tmp_path / "earlier"
    earlier.mkdir()
    (earlier / "shown.h5").write_bytes(b"old")
    lines = {"episodes.jsonl": b"1\n2\n3\n"}
    run, file = Whole(lines, 1.0, earlier), Whole({"shown.h5": b"new"}, 1.0, earlier)
    before = {"episodes.jsonl": b"1\n2\n"}
    faults = [
        ("evaluate", before, {"episodes.jsonl": b"1\n"}, run, "a line is gone"),
        ("evaluate", before, {"episodes.jsonl": b"1\n2\n2\n"}, run, "there twice"),
        ("evaluate", before, {"episodes.jsonl": b"1\n2\n4\n"}, run, "of no run"),
        ("demonstrate", {"shown.h5": b"old"}, {}, file, "damaged or gone"),
        ("demonstrate", {"shown.h5": b"old"}, {"shown.h5": b"ne"}, file, "damaged or gone"),
        ("demonstrate", {"notes.txt": b""}, {}, file, "gone"),
    ]
    for name, was, now, whole, told in faults:
        assert told in fault_of(name, was, now, whole)
    assert fault_of("evaluate", before, lines, run) == ""
    assert fault_of("demonstrate", {"shown.h5": b"old"}, {"shown.h5": b"new"}, file) == ""


def fault_of(name, before, after, whole):
    try:
        check_killed(name, before, after, whole, resumed=name == "evaluate")
    except AssertionError as fault:
        return str(fault)
    return ""
