import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from fake_benchmark import write_suite

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.run import store
from dressing_sim.benchmark.run.folder import locked
from dressing_sim.benchmark.run.lines import episode_values, parse_episode
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.episode.demonstration import Demonstration, save_demonstrations
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.provenance import versions

OUTCOMES = [
    Outcome(True, metrics={"strain": 0.1 + 0.2, "armscye_s": -1e-300}),
    Outcome(False, (Failure("stuck", "at the\nelbow \u2028", 1 / 3, None),), {"strain": 2.0}),
    Outcome(False, invalid="worker died twice"),
]


@pytest.fixture
def plan(tmp_path):
    suite = write_suite(tmp_path / "suite.json", 3)
    return make_plan(Protocol("p", suite, (Entry("expert"), Entry("tp-gmm", "case_a"))), seed=4)


@pytest.fixture
def results(plan):
    return [
        EpisodeResult(j.index, j.entry, j.posture, 0, j.seed, {"friction": 0.3}, outcome)
        for j, outcome in zip(plan.jobs, OUTCOMES + OUTCOMES, strict=True)
    ]


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "some" / "run"


def fill(folder, plan, results, **settings):
    with open_run(folder, plan, **settings) as run:
        for result in results:
            run.append(episode_values(plan, result))


def json_line(plan, result):
    return json.dumps(episode_values(plan, result))


def parsed(run):
    return [parse_episode(run.plan, line) for line in run.lines]


def finish(folder):
    (folder / "summary.json").write_text("{}")


def test_a_line_holds_all_of_an_episode_and_can_be_read_back(plan, results):
    for result in results:
        line = json_line(plan, result)
        assert line.isascii()
        assert "\n" not in line
        assert parse_episode(plan, json.loads(line)) == result
    values = json.loads(line)
    assert (values["index"], values["protocol"], values["policy"]) == (5, "p", "tp-gmm")
    assert values["versions"] == versions()


@pytest.mark.parametrize(
    "line", ["[]", '{"index": 0}', '{"index": 99, "policy": 0, "demonstrations": 0}']
)
def test_a_damaged_line_is_an_error(plan, line):
    with pytest.raises(InvalidInputError, match="not an episode"):
        parse_episode(plan, json.loads(line))


@pytest.mark.parametrize("key", ["variation", "extra", "figures"])
def test_a_line_whose_values_have_no_names_is_an_error(plan, results, key):
    values = {**json.loads(json_line(plan, results[0])), key: -1}
    with pytest.raises(InvalidInputError, match=f"not an episode.*{key} is -1"):
        parse_episode(plan, values)


def test_a_run_that_never_begins_leaves_no_folder_and_no_lock(plan, folder):
    with pytest.raises(OSError, match="full"), locked(folder):
        raise OSError("full")
    assert not folder.exists()
    folder.mkdir()
    with pytest.raises(OSError, match="full"), locked(folder):
        raise OSError("full")
    assert list(folder.iterdir()) == []
    (folder / "mine").touch()
    with pytest.raises(OSError, match="full"), locked(folder):
        raise OSError("full")
    assert (folder / "mine").exists()


def test_a_line_of_another_run_is_an_error(plan, results):
    line = json_line(plan, replace(results[0], entry=Entry("other", "case_a")))
    with pytest.raises(InvalidInputError, match="another run"):
        parse_episode(plan, json.loads(line))


def test_an_episode_is_in_the_file_as_soon_as_it_is_appended(plan, results, folder):
    with open_run(folder, plan) as run:
        for count, result in enumerate(results, start=1):
            assert parse_episode(plan, run.append(episode_values(plan, result))) == result
            lines = (folder / "episodes.jsonl").read_text().splitlines()
            assert lines == [json_line(plan, r) for r in results[:count]]


def test_an_episode_is_forced_to_the_disk(plan, results, folder, monkeypatch):
    forced = []
    with open_run(folder, plan) as run:
        monkeypatch.setattr(
            store.os, "fsync", lambda _: forced.append((folder / "episodes.jsonl").read_bytes())
        )
        for result in results[:2]:
            run.append(episode_values(plan, result))
    assert [content.count(b"\n") for content in forced] == [1, 2]


def test_a_disk_that_is_full_is_an_error_that_names_the_file(plan, results, folder, monkeypatch):
    def full(_):
        raise OSError(28, "No space left on device")

    with open_run(folder, plan) as run:
        run.append(episode_values(plan, results[0]))
        before = (folder / "episodes.jsonl").read_bytes()
        monkeypatch.setattr(store.os, "fsync", full)
        with pytest.raises(
            InvalidInputError, match=r"episodes\.jsonl: cannot be written \(No space"
        ):
            run.append(episode_values(plan, results[1]))
    assert (folder / "episodes.jsonl").read_bytes() == before


def test_a_run_that_goes_on_knows_what_is_done(plan, results, folder):
    fill(folder, plan, [results[4], results[1]])
    with open_run(folder, plan, resume=True) as run:
        assert run.finished == {1, 4}
        assert parsed(run) == [results[1], results[4]]
        run.append(episode_values(plan, results[0]))
    assert parsed(load_run(folder)) == [results[0], results[1], results[4]]
    assert load_run(folder).plan == plan


def test_sorted_lines_do_not_depend_on_the_order_of_their_ends(plan, results, tmp_path, rng):
    contents = set()
    for number in range(3):
        shuffled = [results[i] for i in rng.permutation(len(results))]
        with open_run(tmp_path / str(number), plan) as run:
            for result in shuffled:
                run.append(episode_values(plan, result))
            run.sort()
        contents.add((tmp_path / str(number) / "episodes.jsonl").read_bytes())
    assert len(contents) == 1
    assert [json.loads(line)["index"] for line in contents.pop().splitlines()] == list(range(6))


def test_a_line_that_was_torn_at_any_byte_is_dropped(plan, results, folder):
    fill(folder, plan, results[:2])
    path = folder / "episodes.jsonl"
    whole = path.read_bytes()
    first = whole.index(b"\n") + 1
    for cut in {*range(first, len(whole), 37), len(whole) - 1}:
        path.write_bytes(whole[:cut])
        assert load_run(folder).finished == {0}
        with open_run(folder, plan, resume=True) as run:
            assert run.finished == {0}
            run.append(episode_values(plan, results[1]))
        assert path.read_bytes() == whole


def test_damage_within_the_file_is_an_error_that_names_the_line(plan, results, folder):
    fill(folder, plan, results[:3])
    path = folder / "episodes.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text(lines[0] + lines[1][20:] + lines[2])
    before = path.read_bytes()
    with pytest.raises(InvalidInputError, match="line 2 is damaged"), open_run(folder, plan, True):
        pass
    assert path.read_bytes() == before


def test_an_unfinished_run_is_not_replaced(plan, results, folder):
    fill(folder, plan, results[:1])
    with pytest.raises(InvalidInputError, match=r"unfinished.*--resume.*--out"):
        fill(folder, plan, results)
    assert parsed(load_run(folder)) == results[:1]


@pytest.mark.parametrize("forced", [True, False])
def test_a_finished_run_is_replaced_and_other_files_are_left(plan, results, folder, forced):
    fill(folder, plan, results)
    run = load_run(folder)
    own = run.demonstration_file(plan.demonstrated["case_a"][0], 0)
    own.parent.mkdir()
    others = [folder / "notes.txt", own.parent / "mine.h5"]
    for file in [own, folder / "report.md", *others]:
        file.write_text("something")
    finish(folder)
    other = replace(plan, seed=5)
    with (
        pytest.raises(InvalidInputError, match=r"another config \(seed: 4 there, 5 now\)"),
        open_run(folder, other),
    ):
        pass
    assert own.exists()
    with open_run(folder, other if forced else plan, force=forced) as run:
        assert run.finished == frozenset()
    assert not own.exists()
    assert not (folder / "summary.json").exists()
    assert not (folder / "report.md").exists()
    assert all(file.exists() for file in others)
    assert load_run(folder).plan == (other if forced else plan)


def test_a_finished_run_can_be_resumed_without_loss(plan, results, folder):
    fill(folder, plan, results)
    finish(folder)
    with open_run(folder, plan, resume=True) as run:
        assert parsed(run) == results
    assert (folder / "summary.json").exists()


def test_there_is_no_need_of_a_run_to_resume(plan, folder):
    with open_run(folder, plan, resume=True) as run:
        assert run.finished == frozenset()


@pytest.mark.parametrize("done", [True, False])
def test_another_config_is_refused_with_every_difference(plan, results, folder, done):
    fill(folder, plan, results[:1])
    if done:
        finish(folder)
    before = {path: path.read_bytes() for path in folder.iterdir()}
    config = replace(plan.config, hold=2.0)
    tested = (replace(plan.tested[0], elbow_deg=7.0), *plan.tested[1:])
    with (
        pytest.raises(InvalidInputError) as caught,
        open_run(folder, replace(plan, seed=5, config=config, tested=tested), resume=True),
    ):
        pass
    heading, *lines = str(caught.value).splitlines()
    assert str(folder) in heading
    assert [line.strip() for line in lines] == [
        "seed: 4 there, 5 now",
        "episode.hold: 1.0 there, 2.0 now",
        "tested.0.elbow_deg: 5.0 there, 7.0 now",
    ]
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


def test_other_versions_are_refused(plan, folder):
    fill(folder, plan, [])
    settings = json.loads((folder / "config.json").read_text())
    settings["versions"]["mujoco"] = "3.0"
    (folder / "config.json").write_text(json.dumps(settings))
    with (
        pytest.raises(InvalidInputError, match=r"versions.mujoco: '3.0' then"),
        open_run(folder, plan, resume=True),
    ):
        pass


@pytest.mark.parametrize("resume", [False, True])
def test_a_run_of_another_study_is_not_replaced(plan, results, folder, resume):
    fill(folder, plan, results)
    finish(folder)
    before = (folder / "episodes.jsonl").read_bytes()
    other = replace(plan, protocol=replace(plan.protocol, study="thresholds"))
    with (
        pytest.raises(InvalidInputError, match="choose another --out"),
        open_run(folder, other, resume),
    ):
        pass
    assert (folder / "episodes.jsonl").read_bytes() == before


def test_a_new_run_removes_the_plots_of_its_study_and_no_other_pictures(plan, results, folder):
    fill(folder, plan, results)
    finish(folder)
    for name in ("success-rates.svg", "mine.svg", "success-episode7.mp4", "success-mine.mp4"):
        (folder / name).write_text("<svg/>")
    fill(folder, plan, [])
    assert [path.name for path in folder.glob("*.svg")] == ["mine.svg"]
    assert [path.name for path in folder.glob("*.mp4")] == ["success-mine.mp4"]


def test_a_run_stays_locked_while_its_report_is_made(plan, folder):
    with open_run(folder, plan) as run:
        run.sort()  # this replaces the file of its episodes
        with (
            pytest.raises(InvalidInputError, match="another process"),
            open_run(folder, plan, resume=True),
        ):
            pass
    with open_run(folder, plan, resume=True):
        pass


def test_two_processes_cannot_write_to_one_run(plan, folder, tmp_path):
    code = (
        "import fcntl, sys; file = open(sys.argv[1] + '/.lock', 'a');"
        "fcntl.flock(file, fcntl.LOCK_EX); print(flush=True); sys.stdin.read()"
    )
    fill(folder, plan, [])
    command = [sys.executable, "-c", code, str(folder)]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe) as other:
        other.stdout.readline()
        with (
            pytest.raises(InvalidInputError, match="another process"),
            open_run(folder, plan, resume=True),
        ):
            pass
        other.communicate()
    with open_run(folder, plan, resume=True):
        pass


def test_a_folder_that_cannot_be_made_is_an_error(plan, tmp_path):
    (tmp_path / "file").write_text("")
    with (
        pytest.raises(InvalidInputError, match="cannot be written"),
        open_run(tmp_path / "file" / "run", plan),
    ):
        pass


@pytest.mark.parametrize("content", ["{", "[]", "{}", '{"protocol": {}}', "\x00"])
def test_a_damaged_config_is_an_error(plan, folder, content):
    fill(folder, plan, [])
    (folder / "config.json").write_text(content)
    with pytest.raises(InvalidInputError, match="config"):
        load_run(folder)


def test_a_folder_without_a_run_is_an_error(tmp_path):
    with pytest.raises(InvalidInputError, match="no run here"):
        load_run(tmp_path)


def test_an_episode_that_is_not_there_is_an_error(plan, results, folder):
    fill(folder, plan, results[:1])
    run = load_run(folder)
    assert run.line(0) == episode_values(plan, results[0])
    with pytest.raises(InvalidInputError, match=r"no episode 1; valid is .* 0 to 0"):
        run.line(1)


def made_up(posture, seed=0):
    line = np.linspace(posture.wrist, posture.shoulder, 30)
    return Demonstration(line, 0.05, posture, seed, np.zeros((30, 7)))


def test_demonstrations_have_a_file_a_posture_and_set(plan, folder):
    fill(folder, plan, [])
    run = load_run(folder)
    first, second = plan.demonstrated["case_a"]
    strange = replace(first, name="../\u2603 " * 99)
    twin = replace(second, name=first.name)
    places = [(p, k) for p in (first, second, strange, twin) for k in (0, 1)]
    for number, place in enumerate(places):
        save_demonstrations(run.demonstration_file(*place), [made_up(place[0], number)])
    assert len(list((folder / "demonstrations").iterdir())) == len(places)
    assert [run.load_demonstration(*place).seed for place in places] == list(range(len(places)))


def test_a_demonstration_on_another_posture_is_an_error(plan, folder):
    fill(folder, plan, [])
    run = load_run(folder)
    first, second = plan.demonstrated["case_a"]
    save_demonstrations(run.demonstration_file(first, 0), [made_up(second)])
    with pytest.raises(InvalidInputError, match=first.name):
        run.load_demonstration(first, 0)
