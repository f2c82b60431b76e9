import json
from dataclasses import replace

import pytest
from fake_benchmark import Threads, write_suite
from submitted import ADA, changed, fake_run, flip, others_run

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run import executors
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.benchmark.scoreboard import rules
from dressing_sim.benchmark.scoreboard.submission import read_submission, submit
from dressing_sim.benchmark.scoreboard.verification import verify
from dressing_sim.benchmark.studies.study import run_jobs
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.cli import main
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.sleeve import SleeveConfig


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A submitted result whose episodes are made up, and are made up again by threads."""
    path = tmp_path / "ada.json"
    path.write_text(submit(fake_run(tmp_path, monkeypatch), ADA))
    monkeypatch.setattr(executors, "Processes", Threads)
    monkeypatch.chdir(tmp_path)
    return path


def verified(file, **options):
    with Threads(2) as workers:
        return verify(read_submission(file), workers, **options)


def test_it_comes_out_again(file, capsys):
    main(["verify", str(file), "--seed", "3"])
    told = capsys.readouterr().out
    assert told == (
        "verified: of 10 episodes run again, drawn from 10 with seed 3, each is as recorded, to "
        "the bit\n"
    )
    main(["verify", str(file), "--json"])
    values = json.loads(capsys.readouterr().out)
    assert (values["verified"], values["identical"], values["differing"]) == (True, True, {})


def test_which_episodes_are_tried_is_drawn(file):
    tried = [verified(file, seed=seed, fewest=2).tried for seed in (1, 1, 2)]
    assert tried[0] == tried[1] != tried[2]
    assert len(tried[0]) == 2
    assert len(verified(file, share=0.41, fewest=1).tried) == 5
    assert verified(file, share=1.0).tried == tuple(range(10))
    seeds = {verified(file, fewest=1).seed for _ in range(3)}
    assert len(seeds) == 3  # nobody can foresee it


def metric(values):
    values["episodes"][7]["figures"]["strain"] += 1e-15


@pytest.mark.parametrize(
    ("change", "name"),
    [
        (flip, "episode 3 (expert, bent55)"),
        (metric, "episode 7 (tp-gmm on case_a, bent40)"),
        (
            lambda values: values["demonstrations"]["case_a"].update(sha256="0" * 64),
            "demonstrations case_a",
        ),
        (
            lambda values: values["config"]["protocol"]["entries"][1].update(inputs="elbow"),
            "inputs of tp-gmm",
        ),
    ],
)
def test_an_honest_looking_lie_is_found(change, name, file, capsys):
    changed(file, change)
    with pytest.raises(SystemExit) as stopped:
        main(["verify", str(file)])
    told = capsys.readouterr()
    assert stopped.value.code == 1
    assert told.out.startswith("not reproduced: ")
    assert f"  {name}: " in told.err
    found = verified(file)
    assert not found.holds
    assert list(found.differing) == [name]


def test_on_another_kind_of_processor_the_last_bits_are_no_difference(file, capsys):
    def elsewhere(values):
        numerics = values["config"]["provenance"]["numerics"]
        numerics |= {"fingerprint": "0123456789ab", "blas": "openblas \x1b[2J"}
        values["episodes"][7]["figures"]["strain"] *= 1.0 + 1e-9

    changed(file, elsewhere)
    main(["verify", str(file)])
    told = capsys.readouterr().out
    assert "each has its verdict again, and its numbers within 1e-09 of their size" in told
    assert told.strip().isprintable()
    changed(file, flip)
    assert list(verified(file).differing) == ["episode 3 (expert, bent55)"]


def test_other_versions_are_told_where_it_is_not_reproduced(file, capsys):
    def older(values):
        values["config"]["versions"]["mujoco"] = "3.9"
        flip(values)

    with pytest.raises(SystemExit):
        main(["verify", str(changed(file, older))])
    assert "  versions.mujoco: '3.9' then, '4." in capsys.readouterr().err


def test_other_peoples_code_is_run_only_if_asked_to(tmp_path, monkeypatch):
    path = tmp_path / "theirs.json"
    said = replace(ADA, package="nobodys-module==1.0")
    path.write_text(submit(others_run(tmp_path, monkeypatch), said))
    with pytest.raises(InvalidInputError, match=r"from nobodys-module==1\.0; read it, install"):
        verified(path)
    with pytest.raises(InvalidInputError, match=r"is nobodys-module==1\.0 installed\?"):
        verified(path, trust=True)


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["nowhere.json"], "nowhere.json: cannot be read"),
        (["ada.json", "--share", "1.5"], "share is 1.5, valid is a number from 0 to 1"),
        (["ada.json", "--seed", "-1"], "seed is -1"),
        (["ada.json", "--workers", "0"], "workers is 0"),
        (["ada.json", "--share", "nan"], "share is nan"),
    ],
)
def test_bad_input_is_one_line(arguments, part, file, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["verify", *arguments])
    told = capsys.readouterr().err
    assert (stopped.value.code, told.count("\n")) == (2, 1)
    assert part in told


#: A coarse sleeve, and rules that forgive nearly all: quick.
QUICK = EpisodeConfig(
    world=WorldConfig(sleeve=SleeveConfig(edge=0.05)),
    thresholds=Thresholds(armscye_s=-9.0, strain=9.0, grip_force=1e3, link_force=1e3),
    hold=0.2,
)


def test_a_simulated_run_comes_out_again(tmp_path, monkeypatch):
    suite = write_suite(tmp_path / "suite.json", 2)
    monkeypatch.setattr(rules, "TEST_SUITES", (suite,))
    monkeypatch.setattr(rules, "EpisodeConfig", lambda: QUICK)
    rules._test_postures.cache_clear()
    plan = make_plan(Protocol("tiny", suite, (Entry("tp-gmm", "case_a"),)), 0, QUICK)
    path = tmp_path / "ada.json"
    try:
        with Processes(1) as workers:
            with open_run(tmp_path / "run", plan) as run:
                run_jobs(Success(), run, workers)
            path.write_text(submit(tmp_path / "run", ADA))
            found = verify(read_submission(path), workers, seed=1, fewest=1)
            assert (found.holds, found.identical, len(found.tried)) == (True, True, 1)
            index = found.tried[0]
            changed(path, lambda v: v["episodes"][index]["figures"].update(strain=0.01))
            lied = verify(read_submission(path), workers, seed=1, fewest=1)
            assert f"episode {index} (tp-gmm on case_a, arm{index})" in lied.differing
    finally:
        rules._test_postures.cache_clear()
