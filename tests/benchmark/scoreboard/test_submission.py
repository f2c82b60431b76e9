import hashlib
import json
from dataclasses import replace

import numpy as np
import pytest
from submitted import ADA, changed, episodes_of, fake_run, flip

from dressing_sim import __version__
from dressing_sim.arm import Posture
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.scoreboard.submission import read_submission, submit
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import read_results
from dressing_sim.cli import main
from dressing_sim.episode.demonstration import Demonstration, save_demonstrations
from dressing_sim.errors import InvalidInputError


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        yield fake_run(tmp_path_factory.mktemp("submitted"), patch)


@pytest.fixture(scope="module")
def text(folder):
    return submit(folder, ADA)


@pytest.fixture
def file(text, tmp_path):
    path = tmp_path / "ada.json"
    path.write_text(text)
    return path


def test_what_is_read_is_what_was_run(folder, file):
    read, run = read_submission(file), load_run(folder)
    assert read.statement == replace(ADA, package=f"dressing-sim=={__version__}")
    assert (read.run.lines, read.run.plan) == (run.lines, run.plan)
    content = (folder / "episodes.jsonl").read_bytes()
    assert read.episodes_sha256 == hashlib.sha256(content).hexdigest()
    study = find_study("success")
    summary = study.summarise(run, read_results(study, run))
    rows = json.loads(json.dumps(summary["rows"]))
    assert [row | {"variation": []} for row in read.rows] == rows
    assert list(read.demonstrations) == ["case_a"]


def test_the_same_run_gives_the_same_file(folder, file):
    assert submit(folder, ADA) == file.read_text()


def test_unpacked_it_is_the_run_again(folder, file):
    with read_submission(file).unpacked() as again:
        assert (again.plan, again.origin) == (load_run(folder).plan, load_run(folder).origin)
        content = (folder / "episodes.jsonl").read_bytes()
        assert (again.path / "episodes.jsonl").read_bytes() == content


def test_own_demonstrations_come_along(tmp_path, monkeypatch):
    arm = Posture("mine", 71.0, 21.0, 33.0, 44.0)
    line = np.linspace(arm.wrist, arm.shoulder, 30)
    save_demonstrations(tmp_path / "own.h5", [Demonstration(line, 0.05, arm, 1, None)])
    folder = fake_run(tmp_path, monkeypatch, demonstrations=tmp_path / "own.h5")
    path = tmp_path / "own.json"
    path.write_text(submit(folder, ADA))
    with read_submission(path).unpacked() as again:
        (name,) = again.plan.own
        original = load_run(folder).own_file(name)
        assert again.own_file(name).read_bytes() == original.read_bytes()

    def aside(values):
        values["config"]["own_demonstrations"][name] = "/../../a" + "0" * 56

    changed(path, aside, recount=False)
    with pytest.raises(InvalidInputError, match="valid is a checksum"):
        read_submission(path)


def drop(values):
    del values["episodes"][4]


def drop_last(values):
    values["episodes"].pop()


def rates(values):
    values["rows"][1] |= {"n_success": 5, "pc_success": 100.0}


def metric(values):
    values["episodes"][2]["figures"]["strain"] += 1e-15


@pytest.mark.parametrize(
    ("change", "seal", "part"),
    [
        (metric, False, "episodes do not match episodes_sha256"),
        (flip, False, "episodes do not match episodes_sha256"),
        (rates, False, "rows are not what the episodes give: rows.1.n_success"),
        (drop, True, "not all there, or not in order"),
        (drop_last, True, "9 of 10 episodes, valid is all"),
    ],
)
def test_what_contradicts_itself_is_caught(change, seal, part, file):
    with pytest.raises(InvalidInputError, match=part):
        read_submission(changed(file, change, seal))


def at(*places, value):
    """A change that puts a value at a place."""

    def change(values):
        inside = values
        for place in places[:-1]:
            inside = inside[place]
        inside[places[-1]] = value

    return change


DEEP = json.loads("[" * 500 + "]" * 500)


@pytest.mark.parametrize(
    "change",
    [
        lambda values: [values],
        lambda values: {"format": values["format"], "version": 1},
        at("format", value="something else"),
        at("version", value=2),
        at("version", value=True),
        at("more", value=1),
        at("submitted", value=None),
        at("submitted", "name", value="<script>alert(1)</script>"),
        at("submitted", "name", value="[Ada](javascript:alert(1))"),
        at("submitted", "name", value="Ada\x1b[2J"),
        at("submitted", "name", value="\ud800"),
        at("submitted", "name", value="A" * 300),
        at("submitted", "name", value=7),
        at("submitted", "link", value="javascript:alert(1)"),
        at("submitted", "link", value='https://a" onclick="x'),
        at("submitted", "date", value="20261127"),
        at("submitted", "date", value="yesterday"),
        at("submitted", "package", value="a`b"),
        at("submitted", "practised", value="no"),
        at("submitted", "mixed_code", value=True),
        at("rows", value={}),
        at("rows", 0, value=None),
        at("rows", 0, "pc_success", value="100"),
        at("rows", 0, "n_success", value=10**400),
        at("episodes", value="all"),
        at("episodes", 0, value=[]),
        at("episodes", 0, "index", value=False),
        at("episodes", 0, "success", value=1),
        at("episodes", 0, "posture", value={"name": "bent10"}),
        at("episodes", 0, "seed", value=-1),
        at("episodes", 0, "figures", value=DEEP),
        at("episodes", 0, "failures", value=[{"reason": [], "detail": ""}]),
        at("demonstrations", value={}),
        at("demonstrations", "case_a", value="x"),
        at("demonstrations", "case_a", "file", value="AAAA"),
        at("demonstrations", "case_a", "sha256", value=None),
        at("config", value=DEEP),
        at("config", "protocol", "study", value="os:abort"),
        at("config", "protocol", "suite", value="../../etc/passwd"),
        at("config", "protocol", "suite", value="val50"),
        at("config", "protocol", "entries", value=[]),
        at("config", "protocol", "entries", 1, "policy", value="../x:y"),
        at("config", "protocol", "entries", 1, "policy", value="<b>"),
        at("config", "protocol", "entries", 1, "policy", value=["tp-gmm"]),
        at("config", "protocol", "entries", 1, "inputs", value="everything"),
        at("config", "protocol", "entries", 1, "demonstrations", value=None),
        at("config", "protocol", "demonstration_sets", value=10**12),
        at("config", "tested", value=[]),
        at("config", "demonstrated", "case_a", value=[]),
        at("config", "episode", "thresholds", "grip_force", value=1e15),
        at("config", "policy_limits", "fit_time", value=1e9),
        at("config", "seed", value="zero"),
        at("config", "provenance", value={}),
        at("config", "provenance", "numerics", value=["a"]),
        at("config", "provenance", "later_code", value=[{}]),
    ],
)
def test_a_hostile_file_is_one_line(change, file, capsys, monkeypatch):
    monkeypatch.chdir(file.parent)
    changed(file, change, seal=False)
    values = json.loads(file.read_text())
    if isinstance(values, dict) and isinstance(values.get("episodes"), list):
        changed(file, lambda values: None, recount=False)
    with pytest.raises(SystemExit) as stopped:
        main(["verify", str(file)])
    told = capsys.readouterr()
    assert (stopped.value.code, told.out, told.err.count("\n")) == (2, "", 1), told.err
    assert told.err.startswith("dressing-sim: ")
    assert told.err.strip().isprintable()


@pytest.mark.parametrize(
    ("old", "new", "part"),
    [
        ('"version": 1', '"version": 1, "version": 1', "'version' occurs twice"),
        ('"success": true', '"success": false, "success": true', "'success' occurs twice"),
        ('"strain": ', '"strain": NaN, "other": ', "NaN is not finite"),
        ('"strain": ', '"strain": -Infinity, "other": ', "-Infinity is not finite"),
        ('"strain": ', '"strain": 1e999, "other": ', "1e999 is not finite"),
        ('"index": 0', '"index": ' + "9" * 5000, "not JSON"),
        ("{", "[" * 100_000, "nested too deeply"),
    ],
)
def test_numbers_and_names_mean_one_thing(old, new, part, file):
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(InvalidInputError, match=part):
        read_submission(file)


def test_what_is_counted_does_not_hang_on_the_form_of_the_file(file):
    values = json.loads(file.read_text())
    file.write_text(json.dumps(values, indent=4))
    assert episodes_of(values).encode()
    assert read_submission(file).rows == values["rows"]
