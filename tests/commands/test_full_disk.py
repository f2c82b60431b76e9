import json
import os
import shutil
import subprocess
import sys
from contextlib import nullcontext, suppress

import numpy as np
import pytest
from fake_benchmark import start, tries, wait_until, write_suite
from full_disks import closed, contents, mounted, small_files, without_physics

from dressing_sim.benchmark.run.store import load_run
from dressing_sim.cli import main
from dressing_sim.episode import record as record_module
from dressing_sim.episode.demonstration import save_demonstrations
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import replacing, write_file, write_files

PLANAR = "planar --runs 1 --max-iterations 1 --method noise --out disk/out"
FILM = "dress --posture bent10 --policy expert --fps 4 --width 64 --height 48 --video disk/film"
#: Each command that writes, and what of its result is there before.
COMMANDS = {
    "demonstrate": ("demonstrate one.json --out disk/some.h5", "some.h5"),
    "learn": ("learn recorded.h5 --policy tp-gmm?samples=60 --out disk/policy.npz", "policy.npz"),
    "planar": (PLANAR, "out/cost.png"),
    "mp4": (f"{FILM}.mp4", "film.mp4"),
    "gif": (f"{FILM}.gif", "film.gif"),
    "evaluate": ("evaluate --suite two.json --policies expert --out disk/out", None),
    "thresholds": ("thresholds --suite two.json --policies expert --out disk/out", None),
    "validate": ("validate --suite two.json --postures 1 --settings CG --out disk/out", None),
}
FULL = ("File too large", "No space left on device")


@pytest.fixture
def folder(tmp_path, monkeypatch, posture, demonstrated):
    """Where commands run, with what they read; studies and operators are made up."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(record_module, "demonstrate", lambda *_: demonstrated[0])
    without_physics(monkeypatch, tmp_path)
    (tmp_path / "one.json").write_text(json.dumps({"postures": [posture.to_dict()]}))
    write_suite(tmp_path / "two.json", 2)
    save_demonstrations(tmp_path / "recorded.h5", [demonstrated[0]])
    (tmp_path / "disk").mkdir()
    return tmp_path


def refused(capsys, arguments):
    """The one line with which a command ends with exit code 2."""
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    told = capsys.readouterr()
    assert "Traceback" not in told.err
    lines = [line for line in told.err.splitlines() if line.startswith("dressing-sim: ")]
    assert lines == told.err.splitlines()[-1:]
    return lines[0]


@pytest.fixture(params=["limit", "disk"])
def full(request, folder):
    """A disk without room; both kinds where a disk can be mounted."""
    if request.param == "limit":
        # Set in the test, around the command alone: whoever runs the tests writes files too.
        yield request.param
        return
    with mounted(folder / "disk", "size=16k") as done:
        if not done:
            pytest.skip("no disk can be mounted here; the same is tested with a limit")
        yield request.param


@pytest.mark.parametrize("name", COMMANDS)
def test_a_full_disk_is_one_line_that_names_the_file_and_leaves_all_as_it_was(
    name, folder, full, capsys, request
):
    arguments, old = COMMANDS[name]
    more = ["--workers", "1"] if old is None else ["--force"]
    if name in ("mp4", "gif"):
        request.getfixturevalue("opengl")
    if old is not None:
        (folder / "disk" / old).parent.mkdir(exist_ok=True)
        (folder / "disk" / old).write_bytes(b"old")
    with suppress(OSError), open(folder / "disk/filling", "wb", buffering=0) as file:
        while full == "disk":
            file.write(bytes(4096))
    before = contents(folder / "disk")
    with small_files(700) if full == "limit" else nullcontext():
        line = refused(capsys, [*arguments.split(), *more])
    assert "disk/" in line
    assert any(f"cannot be written ({why})" in line for why in FULL), line
    assert contents(folder / "disk") == before


@pytest.mark.parametrize(
    ("command", "most"),
    [
        ("evaluate", 5000),
        ("evaluate", 9000),
        ("evaluate", 30000),
        ("thresholds", 9000),
        ("validate", 9000),
    ],
)
def test_a_run_whose_disk_gets_full_goes_on_later_and_ends_with_the_same_bytes(
    command, most, folder, capsys
):
    arguments = [*COMMANDS[command][0].split(), "--workers", "1"]
    main([*arguments[:-3], "whole", *arguments[-2:]])
    capsys.readouterr()
    out = folder / "disk/out"
    with small_files(most):
        line = refused(capsys, arguments)
    assert any(f"cannot be written ({why})" in line for why in FULL)
    assert not [path for path in out.rglob("*") if ".part" in path.name]
    if not (out / "config.json").exists():
        assert most == 5000
    episodes = out / "episodes.jsonl"
    before = episodes.read_bytes().splitlines() if episodes.exists() else []
    main([*arguments, "--resume"])
    after = episodes.read_bytes().splitlines()
    assert set(before) <= set(after)
    for name in ("episodes.jsonl", "summary.json"):
        assert (out / name).read_bytes() == (folder / "whole" / name).read_bytes()


def test_a_finished_run_is_still_there_if_its_successor_finds_no_room(folder, capsys):
    arguments = [*COMMANDS["evaluate"][0].split(), "--workers", "1"]
    main(arguments)
    capsys.readouterr()
    before = contents(folder / "disk")
    with small_files(700):
        line = refused(capsys, [*arguments, "--seed", "3", "--force"])
    assert "config.json: cannot be written" in line
    assert contents(folder / "disk") == before


@pytest.mark.parametrize("name", COMMANDS)
def test_a_folder_that_takes_no_files_is_one_line(name, folder, capsys, request):
    if name in ("mp4", "gif"):
        request.getfixturevalue("opengl")
    with closed(folder / "closed") as place:
        before = contents(folder)
        arguments = COMMANDS[name][0].replace("disk/", f"{place}/").split()
        line = refused(capsys, [*arguments, *(["--workers", "1"] if "out" in arguments else [])])
        assert str(place) in line
        assert "cannot be written" in line
        assert contents(folder) == before


def test_an_operator_whose_folder_vanishes_writes_it_anew(folder, demonstrated, monkeypatch):
    def vanish(*_):
        shutil.rmtree(folder / "disk")
        return demonstrated[0]

    monkeypatch.setattr(record_module, "demonstrate", vanish)
    main(["demonstrate", "one.json", "--out", "disk/some.h5"])
    assert [path.name for path in (folder / "disk").iterdir()] == ["some.h5"]


def test_a_run_whose_folder_vanishes_says_so_and_loses_nothing_in_silence(tmp_path):
    suite, out = write_suite(tmp_path / "suite.json", 3), tmp_path / "out"
    (tmp_path / "hold-1").touch()
    arguments = ["evaluate", "--suite", suite, "--policies", "expert", "--no-pictures"]
    process = start(tmp_path, [*arguments, "--workers", "1", "--out", str(out)])
    wait_until(lambda: tries(tmp_path, 1) and load_run(out).finished == {0})
    shutil.rmtree(out)
    (tmp_path / "hold-1").unlink()
    output, errors = process.communicate()
    assert (process.returncode, output) == (2, "")
    assert "episodes.jsonl: cannot be written (No such file" in errors.splitlines()[-1]
    assert "Traceback" not in errors
    assert not out.exists()


def test_hdf5_on_a_full_disk_is_no_crash_of_the_process(folder):
    code = (
        "import resource, sys; from dressing_sim.cli import main;"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (700, 700)); main(sys.argv[1:])"
    )
    arguments = ["demonstrate", "one.json", "--out", "disk/some.h5"]
    command = [sys.executable, "-c", code, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.splitlines()[-1] == (
        "dressing-sim: disk/some.h5: cannot be written (File too large)"
    )
    assert contents(folder / "disk") == {}


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
def test_an_output_that_takes_nothing_is_one_line():
    with open("/dev/full", "w") as nowhere:
        command = [sys.executable, "-m", "dressing_sim", "doctor", "--json"]
        done = subprocess.run(command, stdout=nowhere, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 2
    assert done.stderr.splitlines() == [
        "dressing-sim: standard output: cannot be written, No space left on device"
    ]


def test_of_files_that_belong_together_all_are_written_or_none(tmp_path):
    old, large, new = tmp_path / "old", tmp_path / "large", tmp_path / "new"
    old.write_text("old")
    with small_files(1000), pytest.raises(InvalidInputError, match="large: cannot be written"):
        write_files({old: "new", large: np.zeros(9000).tobytes(), new: "new"})
    assert old.read_text() == "old"
    assert list(tmp_path.iterdir()) == [old]


def test_what_a_killed_process_left_is_removed_and_what_is_being_written_is_not(tmp_path):
    code = (
        "import os, sys; from dressing_sim.files import replacing\n"
        "with replacing(sys.argv[1]) as temporary:\n"
        "    print(temporary.write_text('half'), flush=True); os.kill(os.getpid(), 9)"
    )
    target = tmp_path / "some.txt"
    subprocess.run([sys.executable, "-c", code, str(target)], stdout=subprocess.PIPE, check=False)
    (left,) = tmp_path.iterdir()
    (tmp_path / ".some.own.txt").write_text("somebody's")
    with replacing(target) as mine:
        assert not left.exists()
        write_file(target, "another's")
        assert mine.exists()
        mine.write_text("mine")
    assert target.read_text() == "mine"
    assert {path.name for path in tmp_path.iterdir()} == {"some.txt", ".some.own.txt"}
