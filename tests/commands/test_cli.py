import json
import subprocess
import sys
from dataclasses import replace

import pytest

from dressing_sim.cli import main
from dressing_sim.commands.options import print_outcome
from dressing_sim.episode import dressing as episode
from dressing_sim.episode import record as record_module
from dressing_sim.episode.demonstration import load_demonstrations, save_demonstrations
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.record import DemonstrationFailed
from dressing_sim.policies.files import load_policy

COMMANDS = (
    "evaluate",
    "replay",
    "validate",
    "thresholds",
    "tune",
    "practise",
    "confidence",
    "demonstrate",
    "learn",
    "dress",
    "planar",
    "view",
    "doctor",
)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """Every command runs in a folder of its own."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def one(folder, posture):
    """A suite of one posture."""
    path = folder / "one.json"
    path.write_text(json.dumps({"postures": [posture.to_dict()]}))
    return str(path)


@pytest.fixture
def recorded(folder, demonstration):
    path = folder / "recorded.h5"
    save_demonstrations(path, [demonstration])
    return str(path)


@pytest.fixture
def no_physics(monkeypatch):
    """Whatever simulates fails, so that a test shows what is checked before."""

    def fails(*_arguments, **_settings):
        raise AssertionError("a simulation was started")

    monkeypatch.setattr(episode.Dressing, "__init__", fails)


def contents(folder):
    return {path: path.is_dir() or path.read_bytes() for path in folder.rglob("*")}


def assert_refused(capsys, folder, arguments, part):
    before = contents(folder)
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    output = capsys.readouterr()
    assert stopped.value.code == 2
    assert part in output.err
    assert output.err.startswith("dressing-sim: ")
    assert output.err.count("\n") == 1
    assert output.out == ""
    assert contents(folder) == before


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help_with_an_example(command, capsys):
    with pytest.raises(SystemExit) as stopped:
        main([command, "--help"])
    assert stopped.value.code == 0
    text = " ".join(capsys.readouterr().out.split())
    assert "example" in text
    assert f"dressing-sim {command}" in text.partition("example")[2]
    assert "--json" in text or command == "view"  # a page yields no numbers


def test_the_help_names_every_command(capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["--help"])
    assert stopped.value.code == 0
    text = capsys.readouterr().out
    assert all(command in text for command in COMMANDS)


@pytest.mark.parametrize("arguments", [[], ["undress"], ["dress"], ["evaluate", "--workers", "x"]])
def test_arguments_that_are_none_are_exit_code_2(arguments, capsys, folder):
    with pytest.raises(SystemExit) as stopped:
        main(arguments)
    assert stopped.value.code == 2
    assert capsys.readouterr().err
    assert contents(folder) == {}


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ("dress --posture nobody", "unknown posture 'nobody'; valid is one of"),
        ("dress --posture 70,20,30,500", "elbow_deg is 500.0, valid is 0 to 150"),
        ("dress --posture 70,20,30", "FLEXION,ABDUCTION,ROTATION,ELBOW"),
        ("dress --posture bent10 --policy none.npz", "'none.npz': no such file"),
        ("dress --posture bent10 --policy text.h5", "text.h5"),
        ("dress --posture bent10 --video film.avi", "valid is .mp4, .gif"),
        ("dress --posture bent10 --video film.mp4 --camera eye", "valid is front, close, above"),
        ("dress --posture bent10 --seed -1", "seed is -1"),
        ("demonstrate nowhere", "unknown suite 'nowhere'; valid is one of"),
        ("demonstrate random:0", "random:N"),
        ("demonstrate text.h5", "not JSON"),
        ("demonstrate case_a --operator tp-gmm", "operator is 'tp-gmm', valid is expert"),
        ("demonstrate case_a --operator expert?sped=1", "sped"),
        ("demonstrate case_a --out text.h5/a.h5", "cannot be written"),
        ("demonstrate case_a --out occupied", "occupied"),
        ("learn none.h5", "none.h5: no such file"),
        ("learn text.h5", "not HDF5"),
        ("learn text.h5 --policy nobody", "unknown policy 'nobody'; valid is one of"),
        ("planar --demos none.npz", "no file none.npz"),
        ("learn " + 300 * "x", "no such file"),
        ("dress --posture bent10 --policy " + 300 * "x", "no such file"),
        ("evaluate --out " + 300 * "x", "cannot be written"),
        ("dress --posture bent10 --video film.mp4 --width 641", "valid for MP4 are even numbers"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2_and_nothing_is_written(
    arguments, part, capsys, folder, no_physics
):
    (folder / "text.h5").write_text("not { HDF5")
    (folder / "occupied").mkdir()
    assert_refused(capsys, folder, arguments.split(), part)


def test_the_installed_command_reports_bad_input_in_one_line_too(folder):
    run = subprocess.run(
        [sys.executable, "-m", "dressing_sim", "dress", "--posture", "nobody"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert run.returncode == 2
    assert run.stdout == ""
    assert run.stderr.startswith("dressing-sim: unknown posture 'nobody'")
    assert run.stderr.count("\n") == 1


def test_a_damaged_file_of_demonstrations_is_bad_input(capsys, folder, recorded):
    content = (folder / "recorded.h5").read_bytes()
    (folder / "recorded.h5").write_bytes(content[: len(content) // 2])
    assert_refused(capsys, folder, ["learn", recorded], "recorded.h5: damaged")


@pytest.mark.parametrize("out", ["occupied", "recorded.h5/policy.npz"])
def test_a_policy_that_cannot_be_written_is_bad_input(capsys, folder, recorded, out):
    (folder / "occupied").mkdir()
    assert_refused(capsys, folder, ["learn", recorded, "--out", out], out)


def test_a_model_that_is_no_policy_is_bad_input(capsys, folder, demonstration, no_physics):
    from dressing_sim.learning import TPGMM, save_model

    save_model(TPGMM(2).fit([demonstration, demonstration]), folder / "mixture.npz")
    arguments = ["dress", "--posture", "bent10", "--policy", "mixture.npz"]
    assert_refused(capsys, folder, arguments, "cannot generate a path")


def test_a_failed_demonstration_writes_nothing(capsys, folder, one, monkeypatch):
    failed = Outcome(False, (Failure("stuck", "at the elbow"),))

    def demonstrate(*arguments):
        raise DemonstrationFailed("no demonstration", failed)

    monkeypatch.setattr(record_module, "demonstrate", demonstrate)
    with pytest.raises(SystemExit) as stopped:
        main(["demonstrate", one, "--out", "some.h5"])
    assert stopped.value.code == 2
    assert "failed (stuck)" in capsys.readouterr().err
    assert not (folder / "some.h5").exists()


@pytest.mark.parametrize(
    ("flags", "robot"),
    [([], "panda"), (["--robot", "panda"], "panda"), (["--robot", "ur10"], "UR10")],
)
def test_the_robot_that_is_named_demonstrates(flags, robot, one, monkeypatch):
    seen = []

    def demonstrate(_posture, _seed, _operator, config):
        seen.append(config.world.robot.name)
        raise DemonstrationFailed("no demonstration", Outcome(False))

    monkeypatch.setattr(record_module, "demonstrate", demonstrate)
    with pytest.raises(SystemExit):
        main(["demonstrate", one, *flags])
    assert seen == [robot]


def test_what_succeeded_is_written_and_what_failed_is_named(capsys, tmp_path, posture):
    far = replace(
        posture,
        name="far",
        shoulder_position=(0.66, -0.4, 0.38),
        size="male",
        flexion_deg=170,
        abduction_deg=0,
        elbow_deg=0,
    )
    suite = tmp_path / "suite.json"
    suite.write_text(json.dumps({"postures": [far.to_dict(), posture.to_dict()]}))
    out = tmp_path / "some.h5"
    with pytest.raises(SystemExit) as end:
        main(["demonstrate", str(suite), "--out", str(out), "--json"])
    assert end.value.code == 3
    (loaded,) = load_demonstrations(out)
    assert loaded.posture == posture
    told = capsys.readouterr()
    assert [one["posture"]["name"] for one in json.loads(told.out)["demonstrations"]] == [
        posture.name
    ]
    last = told.err.splitlines()[-1]
    assert "'far' failed (ik_unreachable)" in last
    assert "the other 1 are in" in last


def test_demonstrations_are_recorded_learned_from_and_used(
    capsys, folder, one, posture, demonstrated, monkeypatch
):
    monkeypatch.setattr(record_module, "demonstrate", lambda *arguments: demonstrated[0])
    main(["demonstrate", one, "--out", "some.h5", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == "some.h5"
    assert told["demonstrations"][0]["success"] is True
    (loaded,) = load_demonstrations("some.h5")
    assert loaded.positions.tobytes() == demonstrated[0].positions.tobytes()

    main(["learn", "some.h5", "--out", "new/policy.npz", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["n_demonstrations"] == 1
    path = load_policy(told["file"]).generate(posture.frames(), loaded.positions[0])
    assert path.positions.shape[1] == 3

    main(["dress", "--posture", posture.name, "--policy", told["file"], "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["posture"] == posture.to_dict()
    assert told["void"] is None
    assert {"duration", "strain", "grip_force"} <= set(told["figures"])


def test_dress_says_what_went_wrong(capsys):
    # Out of reach, so that there is nothing to simulate.
    main(["dress", "--posture", "-60,0,0,0", "--policy", "expert", "--json"])
    told = json.loads(capsys.readouterr().out)
    assert told["failures"][0]["reason"] == "ik_unreachable"
    main(["dress", "--posture", "-60,0,0,0", "--policy", "expert"])
    text = capsys.readouterr().out
    assert "failure" in text.splitlines()[0]
    assert "ik_unreachable" in text


def test_dress_takes_every_name_of_evaluate_and_lets_it_learn(
    capsys, tmp_path, demonstration, posture
):
    file = tmp_path / "shown.h5"
    save_demonstrations(file, [demonstration, demonstration])
    arguments = ["dress", "--posture", posture.name, "--demonstrations", str(file), "--json"]
    outcomes = []
    for policy in ("transport?phases=60", "default?phases=60"):
        main([*arguments, "--policy", policy])
        outcomes.append(json.loads(capsys.readouterr().out))
        assert outcomes[-1].pop("policy") == policy
    assert outcomes[0] == outcomes[1]
    main(["dress", "--posture", posture.name, "--policy", "expert?speed=0.12", "--json"])
    assert json.loads(capsys.readouterr().out)["figures"] != outcomes[0]["figures"]


def test_an_episode_that_was_not_tried_says_why(capsys):
    print_outcome("an arm", Outcome(False, abstained="too bent"))
    assert capsys.readouterr().out == "an arm: abstained\n  too bent\n"
    print_outcome("an arm", Outcome(False, invalid="the cloth broke"))
    assert capsys.readouterr().out == "an arm: void: the cloth broke\n"


def test_the_numbers_that_matter_stand_next_to_a_verdict_and_the_others_are_counted(capsys):
    metrics = {"armscye_s": 1.97, "torque": 12.0, "upper_arm_force": 3.0, "own_metric": 5.0}
    print_outcome("an arm", Outcome(False, (Failure("stuck", "caught", 3.0),), metrics))
    verdict, reason, s, own, more = capsys.readouterr().out.splitlines()
    assert (verdict, reason) == ("an arm: failure", "  stuck at 3.00 s: caught")
    assert s.split() == ["armscye_s", "1.970"]
    assert own.split() == ["own_metric", "5.000"]
    assert more == "  2 more metrics with --json"
