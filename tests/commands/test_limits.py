"""What is typed must make sense: one line, what was got, what is valid, exit code 2."""

import json

import pytest

from dressing_sim.cli import main
from dressing_sim.episode import dressing as episode


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """A folder of one's own, and nothing is simulated."""
    monkeypatch.chdir(tmp_path)

    def fails(*_arguments, **_settings):
        raise AssertionError("a simulation was started")

    monkeypatch.setattr(episode.Dressing, "__init__", fails)
    return tmp_path


LONG = "x" * 5000


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ("planar --max-demonstrations 0", "max_demonstrations is 0, valid is more than the 3"),
        ("planar --max-demonstrations 3", "max_demonstrations is 3, valid is more than the 3"),
        ("planar --max-demonstrations -1", "max_demonstrations is -1, valid is a whole number"),
        ("planar --max-iterations 1000000000", "max_iterations is 1000000000, valid is"),
        ("planar --snr-db -1000", "snr_db is -1000.0, valid is a number from -300 to 300"),
        ("planar --snr-db nan", "snr_db is nan"),
        ("planar --components 100000", "n_components is 100000, valid is a whole number, 1 to"),
        ("planar --components 0", "n_components is 0"),
        ("planar --runs 1000000000", "runs is 1000000000"),
        ("planar --workers 100000", "workers is 100000, valid is"),
        ("planar --seed 99999999999999999999999", "seed is 9999"),
        (
            "dress --posture bent40 --robot R2D2",
            "unknown robot 'R2D2'; valid is one of panda",
        ),
        (
            "validate --postures 1000",
            "postures is 1000, valid is 1 to 50, as many",
        ),
        ("validate --postures 0", "postures is 0, valid is 1 or more"),
        ("validate --suite case_a --postures 3", "postures is 3, valid is 1 to 2"),
        ("validate --workers 100000", "workers is 100000, valid is"),
        ("import", "no files, valid are one or more recordings"),
        ("export one.h5 --to robomimic --out x.hdf5 --width 0", "valid is with --cameras"),
        ("evaluate --variation frames=1e300", "frames is '1e300', valid is a number from 0 to 1"),
        ("evaluate --variation friction=1e9", "friction is '1e9', valid is a number from 0 to 4"),
        ("evaluate --out new/../run", "new/../run/config.json: cannot be written (there is"),
        ("evaluate --workers 0", "workers is 0, valid is"),
        ("evaluate --seed 99999999999999999999999", "seed is 9999"),
        ("dress --posture bent10 --fps 0", "fps is 0, valid is 1 or more, up to 100"),
        ("dress --posture bent10 --fps 100000", "fps is 100000, valid is"),
        (
            "dress --posture bent10 --width 100000",
            "width is 100000, valid is 1 or more",
        ),
        ("dress --posture bent10 --height -1", "height is -1, valid is"),
        ("dress --posture bent10 --camera eye", "unknown camera 'eye'"),
        (["dress", "--posture", ""], "unknown posture ''"),
        (["dress", "--posture", LONG], "unknown posture 'xxx"),
        (["dress", "--posture", "a\x1b[2J\nb"], "unknown posture 'a\\x1b[2J\\nb'"),
        (["dress", "--posture", "nan,20,30,40"], "flexion_deg is nan"),
        (
            ["dress", "--posture", "bent10", "--policy", ""],
            "policy '': no such file, and no policy's",
        ),
        (["dress", "--posture", "bent10", "--policy", LONG], "no such file"),
        (["dress", "--posture", "bent10", "--policy", "a\x1b\nb"], "'a\\x1b\\nb'"),
        (["evaluate", "--suite", ""], "unknown suite ''"),
        (["evaluate", "--suite", LONG], "unknown suite 'xxx"),
        (["evaluate", "--suite", "a\x1b\nb"], "unknown suite 'a\\x1b\\nb'"),
        (["evaluate", "--policies", LONG], "unknown policy 'xxx"),
        (["evaluate", "--policies", "..:x"], "policy '..:x'"),
        (["demonstrate", "random:100000"], "N from 1 to 99999"),
        (
            ["demonstrate", "case_a", "--seed", "99999999999999999999"],
            "seed is 99999999999999999999",
        ),
    ],
)
def test_what_makes_no_sense_is_one_line(arguments, part, capsys, folder):
    with pytest.raises(SystemExit) as end:
        main(arguments.split() if isinstance(arguments, str) else arguments)
    told = capsys.readouterr()
    assert end.value.code == 2
    assert told.out == ""
    assert told.err.count("\n") == 1
    assert told.err.rstrip("\n").isprintable()
    assert len(told.err) < 4100
    assert part in told.err
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    ("policy", "part"),
    [
        ("tp-gmm?samples=1e8", "samples is '1e8', valid is a whole number"),
        ("tp-gmm?samples=100000000", "samples is 100000000, valid is"),
        ("tp-gmm?n_components=100000", "n_components is 100000, valid is"),
        ("tp-gmm?end_radius=nan", "end_radius is nan"),
        ("tp-gmm?position_floor=1e300", "floor is 1e+300"),
        ("tp-gmm-rf?max_demonstrations=0", "max_demonstrations is 0, valid is 1 or more"),
        ("tp-gmm-rf?max_iterations=1000000000", "max_iterations is 1000000000"),
        ("tp-gmm-noise?snr_db=-1000", "snr_db is -1000.0, valid is"),
        ("expert?speed=1e-300", "speed is 1e-300, valid is a number from 0.001 to 10"),
        ("expert?dt=1e-9", "dt is 1e-09, valid is"),
        ("expert?forearm_height=1e9", "forearm_height is 1000000000.0, valid is"),
    ],
)
def test_hyper_parameters_that_make_no_sense_are_refused(policy, part, capsys):
    with pytest.raises(SystemExit) as end:
        main(["dress", "--posture", "bent10", "--policy", policy])
    assert end.value.code == 2
    told = capsys.readouterr().err
    assert part in told
    assert told.count("\n") == 1


def test_all_that_a_suite_has_may_be_asked_for():
    from dressing_sim.benchmark.studies.convergence import convergence_plan

    assert len(convergence_plan("case_a").tested) == 2
    assert len(convergence_plan("case_a", 2).tested) == 2
    assert len(convergence_plan().tested) == 15


@pytest.mark.parametrize(
    "raised", ["KeyError('odd')", "SystemExit(3)", "RuntimeError('two\\nlines')"]
)
def test_a_module_that_cannot_be_imported_is_one_line(raised, folder, monkeypatch, capsys):
    (folder / "broken_policy_module.py").write_text(f"raise {raised}\n")
    monkeypatch.syspath_prepend(folder)
    with pytest.raises(SystemExit) as end:
        main(["learn", "none.h5", "--policy", "broken_policy_module:Policy"])
    assert end.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize(
    ("file", "content", "part"),
    [
        ("config.json", "[" * 100_000, "nested too deeply"),
        ("config.json", "[]", "not the config of a run"),
        ("config.json", "{", "not JSON"),
        ("config.json", "{}", "missing or damaged"),
        ("config.json", {"provenance": 5}, "an object"),
        ("config.json", {"provenance": {"numerics": 1.5}}, "numerics is 1.5"),
        ("config.json", {"provenance": {"numerics": {"blas": "x"}}}, "fingerprint is None"),
        ("config.json", {"provenance": {"sources": 3}}, "sources is 3"),
        ("config.json", {"own_demonstrations": {"case_a": 1.5}}, "1.5, valid is a checksum"),
        ("config.json", {"own_demonstrations": {"a": "../../../e"}}, "valid is a checksum"),
        ("config.json", {"own_demonstrations": [1]}, "own_demonstrations is [1]"),
        ("config.json", {"tested": [5]}, "posture 5"),
        ("config.json", {"seed": "x"}, "'x'"),
        ("episodes.jsonl", "[" * 100_000 + "\n", "line 1 is damaged"),
        ("episodes.jsonl", "5\n", "line 1 is damaged"),
        ("episodes.jsonl", '{"index": "x"}\n', "line 1 is damaged"),
    ],
)
def test_a_run_s_folder_that_was_edited_is_one_line(file, content, part, folder, capsys):
    from dressing_sim.benchmark.studies.evaluate import evaluation_plan

    plan = evaluation_plan("paper", "case_a", "expert", None, 0)
    config = json.loads(json.dumps(plan.to_dict()))
    run = folder / "run"
    run.mkdir()
    (run / "config.json").write_text(json.dumps(config))
    (run / "episodes.jsonl").write_text("")
    edited = content if isinstance(content, str) else json.dumps({**config, **content})
    (run / file).write_text(edited)
    with pytest.raises(SystemExit) as end:
        main(["replay", "run", "0"])
    told = capsys.readouterr().err
    assert end.value.code == 2
    assert told.count("\n") == 1
    assert part in told
