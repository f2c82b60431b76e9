import json
import shutil
from pathlib import Path

import pytest
from fake_benchmark import write_suite
from full_disks import contents, without_physics

from dressing_sim.benchmark.run.store import load_run
from dressing_sim.cli import main
from dressing_sim.episode import record as record_module
from dressing_sim.episode.demonstration import save_demonstrations

STUDIES = {
    "evaluate": "evaluate --suite two.json --policies expert --no-pictures",
    "thresholds": "thresholds --suite two.json --policies expert",
    "validate": "validate --suite two.json --postures 1 --settings CG",
}
PLANAR = "planar --runs 1 --max-iterations 1 --method noise"
OWN = ("config.json", "episodes.jsonl", "summary.json", "report.md", "report.html")


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch, demonstrated):
    """Where commands run; studies and operators are made up."""
    inside = tmp_path / "here"
    inside.mkdir()
    monkeypatch.chdir(inside)
    monkeypatch.setattr(record_module, "demonstrate", lambda *_: demonstrated[0])
    without_physics(monkeypatch, tmp_path)
    write_suite(inside / "two.json", 1)
    save_demonstrations(inside / "shown.h5", [demonstrated[0]])
    return inside


def refused(capsys, arguments, *parts):
    """A command ends with one line and changes nothing."""
    before = contents(Path.cwd())
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    told = capsys.readouterr()
    assert (stopped.value.code, told.out, told.err.count("\n")) == (2, "", 1), told.err
    assert all(part in told.err for part in parts), told.err
    assert contents(Path.cwd()) == before


@pytest.mark.parametrize("name", [*OWN, "notes.txt", "demonstrations"])
@pytest.mark.parametrize("command", STUDIES)
def test_a_folder_with_files_of_others_is_left_alone(command, name, folder, capsys):
    (folder / "out").mkdir()
    if name == "demonstrations":
        (folder / "out" / name).mkdir()
    else:
        (folder / "out" / name).write_text('{"somebody": "else"}')
    refused(capsys, [*STUDIES[command].split(), "--out", "out"], "out", "--force")


@pytest.mark.parametrize("command", STUDIES)
def test_the_folder_one_is_in_is_left_alone_too(command, capsys):
    refused(capsys, [*STUDIES[command].split(), "--out", "."], "--force")


def test_force_replaces_the_runs_own_names_and_touches_nothing_else(folder, capsys):
    out = folder / "out"
    (out / "demonstrations").mkdir(parents=True)
    others = [out / name for name in ("notes.txt", "success-story.svg", "demonstrations/mine.h5")]
    others.append(folder / "linked.jsonl")
    for file in [*others, *(out / name for name in OWN if name != "episodes.jsonl")]:
        file.write_text("somebody's")
    (out / "episodes.jsonl").symlink_to(folder / "linked.jsonl")
    main([*STUDIES["evaluate"].split(), "--out", "out", "--workers", "1", "--force"])
    assert all(file.read_text() == "somebody's" for file in others)
    assert load_run(out).finished == {0}
    assert all((out / name).read_text() != "somebody's" for name in OWN)
    capsys.readouterr()
    (out / "config.json").unlink()
    (out / "config.json").mkdir()
    arguments = [*STUDIES["evaluate"].split(), "--out", "out", "--workers", "1", "--force"]
    refused(capsys, arguments, "it is a folder")


def test_resume_and_force_exclude_each_other(capsys):
    arguments = [*STUDIES["evaluate"].split(), "--out", "out", "--resume", "--force"]
    refused(capsys, arguments, "exclude each other")


@pytest.mark.parametrize("resume", [[], ["--resume"]])
def test_episodes_whose_config_is_gone_are_not_begun_anew(resume, folder, capsys):
    arguments = [*STUDIES["evaluate"].split(), "--out", "out", "--workers", "1"]
    main(arguments)
    capsys.readouterr()
    (folder / "out/config.json").unlink()
    refused(capsys, [*arguments, *resume], "episodes.jsonl without config.json", "--force")


def test_a_process_killed_as_it_replaced_a_run_is_followed_by_the_next(folder, capsys):
    arguments = [*STUDIES["evaluate"].split(), "--out", "out", "--workers", "1"]
    main(arguments)
    whole = (folder / "out/episodes.jsonl").read_bytes()
    (folder / "out/config.json").rename(folder / "out/.replaced.json")
    main(arguments)
    assert not (folder / "out/.replaced.json").exists()
    assert (folder / "out/episodes.jsonl").read_bytes() == whole


def test_what_a_killed_process_left_in_a_run_is_removed_when_it_goes_on(folder):
    arguments = [*STUDIES["evaluate"].split(), "--out", "out", "--workers", "1"]
    main(arguments)
    demonstrations = folder / "out/demonstrations"
    demonstrations.mkdir()
    left = [
        folder / "out/.config.abcdefgh.part.json",
        folder / "out/.success.abcdefgh.part.svg",
        demonstrations / ".set0-a-01234567.abcdefgh.part.h5",
    ]
    others = [folder / "out/.config.part.json", folder / "out/.mine.abcdefgh.part.txt"]
    for file in [*left, *others]:
        file.touch()
    main([*arguments, "--resume"])
    assert not any(file.exists() for file in left)
    assert all(file.exists() for file in others)


@pytest.mark.parametrize("way", ["same", "spelled", "symlink", "hard link"])
@pytest.mark.parametrize("force", [[], ["--force"]])
def test_an_output_is_never_an_input(way, force, folder, capsys):
    out = folder / "out.h5"
    if way == "symlink":
        out.symlink_to("shown.h5")
    elif way == "hard link":
        out.hardlink_to(folder / "shown.h5")
    else:
        out = {"same": "shown.h5", "spelled": "../here/./shown.h5"}[way]
    refused(capsys, ["learn", "shown.h5", "--out", str(out), *force], "is read as well")


def test_no_command_writes_over_what_it_reads(folder, capsys):
    refused(capsys, ["demonstrate", "two.json", "--out", "two.json", "--force"], "is read as well")
    (folder / "demos.npz").write_bytes(b"")
    (folder / "out").mkdir()
    (folder / "out/table.md").symlink_to(folder / "demos.npz")
    planar = [*PLANAR.split(), "--demos", "demos.npz"]
    refused(capsys, [*planar, "--out", "out", "--force"], "is read as well")
    refused(capsys, [*planar, "--out", "demos.npz", "--force"], "cannot be written")
    shutil.copy("two.json", "out/config.json")
    evaluate = "evaluate --suite out/config.json --policies expert --out out --force"
    refused(capsys, evaluate.split(), "is read as well")
    (folder / "film.gif").hardlink_to(folder / "shown.h5")
    dress = "dress --posture bent10 --demonstrations shown.h5 --video film.gif --force"
    refused(capsys, dress.split(), "is read as well")


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        ("demonstrate two.json --out", "old.h5"),
        ("learn shown.h5 --policy tp-gmm?samples=60 --out", "old.npz"),
        ("dress --posture bent10 --fps 2 --width 64 --height 48 --video", "old.gif"),
    ],
)
def test_an_existing_file_needs_force(arguments, name, folder, capsys, request):
    if "--video" in arguments:
        request.getfixturevalue("opengl")
    (folder / name).write_text("old")
    refused(capsys, [*arguments.split(), name], name, "is there already", "--force")
    main([*arguments.split(), name, "--force"])
    assert (folder / name).read_bytes() != b"old"


def test_a_planar_study_needs_force_where_anything_is(folder, capsys):
    out = folder / "out"
    out.mkdir()
    for name in ("notes.txt", "summary.json"):
        (out / name).write_text("somebody's")
    refused(capsys, [*PLANAR.split(), "--out", "out"], "out is not empty", "--force")
    main([*PLANAR.split(), "--out", "out", "--force"])
    assert (out / "notes.txt").read_text() == "somebody's"
    assert json.loads((out / "summary.json").read_text())["rows"]


def test_a_file_that_appears_during_the_work_is_not_replaced(folder, monkeypatch, demonstrated):
    def appear(*_):
        (folder / "new.h5").write_text("somebody's")
        return demonstrated[0]

    monkeypatch.setattr(record_module, "demonstrate", appear)
    with pytest.raises(SystemExit):
        main(["demonstrate", "two.json", "--out", "new.h5"])
    assert (folder / "new.h5").read_text() == "somebody's"
