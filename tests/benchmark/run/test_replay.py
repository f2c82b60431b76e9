import json
from dataclasses import replace

import pytest

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.replay import replay_episode
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import read_results, run_jobs
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.benchmark.studies.thresholds import PROTOCOL, ThresholdStudy
from dressing_sim.benchmark.studies.thresholds_verdicts import verdict_of
from dressing_sim.cli import main
from dressing_sim.commands.filming import Filming
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.sleeve import SleeveConfig

#: A coarse sleeve and rules that forgive all: quick, and every demonstration can be learned from.
QUICK = EpisodeConfig(
    world=WorldConfig(sleeve=SleeveConfig(edge=0.05)),
    thresholds=replace(Thresholds(), armscye_s=-9.0, strain=9.0, grip_force=1e3, link_force=1e3),
    hold=0.2,
)
LEARNED, VARIED = 0, 1


def again_of(run, index, observer=None):
    return replay_episode(find_study(run.plan.protocol.study), run, index, observer)


def results_of(run):
    return read_results(find_study(run.plan.protocol.study), run)


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A run of two episodes, one of a policy that learned, one of the expert in a varied world."""
    folder = tmp_path_factory.mktemp("replay")
    arm = {"flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}
    for name, elbow in (("test", 10), ("shown", 15)):
        content = {"postures": [{"name": name, "elbow_deg": elbow, **arm}]}
        (folder / f"{name}.json").write_text(json.dumps(content))
    entries = (
        Entry("tp-gmm", str(folder / "shown.json")),
        Entry("expert", None, ("friction", "arm", "grasp")),
    )
    plan = make_plan(Protocol("tiny", str(folder / "test.json"), entries), 3, QUICK)
    with Processes(1) as workers, open_run(folder / "run", plan) as run:
        run_jobs(Success(), run, workers)
    return folder / "run"


@pytest.fixture
def tampered(finished):
    """The run with another figure in the learned episode, as other versions might give."""
    path = finished / "episodes.jsonl"
    before = path.read_text()
    first, second = before.splitlines()
    values = json.loads(first)
    values["figures"]["strain"] += 1e-15
    path.write_text(f"{json.dumps(values)}\n{second}\n")
    yield finished
    path.write_text(before)


@pytest.mark.parametrize("index", [LEARNED, VARIED])
def test_an_episode_comes_out_the_same_in_another_process(finished, index):
    run = load_run(finished)
    again = again_of(run, index)
    assert again.differences == []
    assert again.result == results_of(run)[index]
    assert (again.posture, again.config) == run.plan.jobs[index].situation(QUICK)[:2]


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """A run of the study of thresholds, of one episode."""
    folder = tmp_path_factory.mktemp("thresholds")
    arm = {"name": "test", "flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}
    (folder / "test.json").write_text(json.dumps({"postures": [arm | {"elbow_deg": 10}]}))
    suite, config = str(folder / "test.json"), replace(QUICK, protective_stop=False)
    protocol = replace(PROTOCOL, suite=suite, entries=(Entry("expert"),))
    plan = make_plan(protocol, 3, config)
    with Processes(1) as workers, open_run(folder / "run", plan) as run:
        run_jobs(ThresholdStudy(), run, workers)
    return folder / "run"


def test_an_episode_of_the_study_of_thresholds_comes_out_the_same_with_all_its_verdicts(judged):
    run, seen = load_run(judged), []
    again = again_of(run, 0, seen.append)
    assert again.differences == []
    assert again.result == results_of(run)[0]
    assert verdict_of(again.result, "moment", 1.0) is not None
    assert seen  # so that it can be filmed


def test_a_bit_that_differs_is_named(tampered):
    (difference,) = again_of(load_run(tampered), LEARNED).differences
    assert difference.startswith("figures.strain: ")


def test_a_demonstration_that_is_gone_is_an_error(finished):
    (file,) = (finished / "demonstrations").iterdir()
    moved = file.rename(finished / "elsewhere.h5")
    with pytest.raises(InvalidInputError, match=f"{file.name}: no such file"):
        again_of(load_run(finished), LEARNED)
    moved.rename(file)


def test_the_command_says_that_it_is_identical_and_films_it(finished, tmp_path, capsys, opengl):
    film = tmp_path / "film.gif"
    size = ["--width", "64", "--height", "48", "--fps", "2"]
    main(["replay", str(finished), str(VARIED), "--video", str(film), *size])
    output = capsys.readouterr().out
    assert output.splitlines()[0].startswith("expert, test: ")
    assert "identical to the recorded episode, to the bit" in output
    assert film.read_bytes().startswith(b"GIF")


def test_what_differs_is_told_though_there_is_no_film(
    tampered, capsys, tmp_path, monkeypatch, opengl
):
    def broken(*_):
        raise DressingSimError("no film today")

    monkeypatch.setattr(Filming, "write", broken)
    with pytest.raises(SystemExit) as stopped:
        main(["replay", str(tampered), str(LEARNED), "--video", str(tmp_path / "film.mp4")])
    assert stopped.value.code != 0
    output = capsys.readouterr().err
    assert "not the recorded outcome" in output
    assert "no film today" in output


def test_the_command_fails_if_the_outcome_is_another(tampered, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["replay", str(tampered), str(LEARNED), "--json"])
    assert stopped.value.code == 1
    output = capsys.readouterr()
    values = json.loads(output.out)
    assert values["identical"] is False
    assert values["policy"] == "tp-gmm"
    assert values["differences"][0] in output.err


@pytest.fixture
def elsewhere(tampered):
    """The tampered run, as if a processor of another kind had computed it."""
    path = tampered / "config.json"
    before = path.read_text()
    values = json.loads(before)
    values["provenance"]["numerics"] |= {"fingerprint": "0123456789ab", "blas": "openblas SkylakeX"}
    path.write_text(json.dumps(values))
    yield tampered
    path.write_text(before)


def test_on_another_kind_of_processor_the_last_bits_are_no_difference(elsewhere, capsys):
    assert again_of(load_run(elsewhere), LEARNED).differences == []
    main(["replay", str(elsewhere), str(LEARNED)])
    told = capsys.readouterr().out.splitlines()[-1]
    assert told.startswith("the same verdict as recorded, numbers within ")
    assert "openblas SkylakeX recorded, openblas" in told
    main(["replay", str(elsewhere), str(LEARNED), "--json"])
    values = json.loads(capsys.readouterr().out)
    assert (values["identical"], values["agrees"]) == (False, True)
    assert values["differences"][0].startswith("figures.strain: ")
    assert "SkylakeX" in values["numerics"]


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["nowhere", "0"], "nowhere: no run here"),
        (["run", "2"], "no episode 2; valid is an index of episodes.jsonl, 0 to 1"),
        (["run", "0", "--video", "film.avi"], "valid is .mp4, .gif"),
        (["run", "0", "--fps", "0"], "fps is 0"),
    ],
)
def test_bad_input_is_one_line(finished, capsys, monkeypatch, arguments, part):
    monkeypatch.chdir(finished.parent)
    with pytest.raises(SystemExit) as stopped:
        main(["replay", *arguments])
    assert stopped.value.code == 2
    errors = capsys.readouterr().err
    assert part in errors
    assert errors.count("\n") == 1
