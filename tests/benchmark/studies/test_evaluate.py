import json
import sys
from functools import partial
from types import SimpleNamespace

import fake_benchmark
import pytest
from fake_benchmark import fake_work, write_suite

from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.evaluate import evaluate, evaluation_plan, policy_name
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.cli import main
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.robots import with_robot


@pytest.fixture
def suite(tmp_path, monkeypatch):
    """Three postures, in a benchmark without physics."""
    monkeypatch.setitem(STUDIES, "success", partial(Success, fake_work(tmp_path)))
    monkeypatch.chdir(tmp_path)
    return write_suite(tmp_path / "suite.json", 3)


def test_the_numbers_are_those_of_the_command_line(suite, tmp_path, capsys):
    found = evaluate(["expert", "tp-gmm"], suite=suite, seed=2, workers=1)
    arguments = ["--suite", suite, "--policies", "expert,tp-gmm", "--seed", "2", "--workers", "1"]
    main(["evaluate", *arguments, "--out", "run", "--no-pictures", "--json"])
    printed = json.loads(capsys.readouterr().out)
    assert found.summary == printed
    for row, theirs in zip(found.rows, printed["rows"], strict=True):
        assert (row.policy, row.demonstrations) == (theirs["policy"], theirs["demonstrations"])
        assert (row.n_success, row.n_episodes) == (theirs["n_success"], theirs["n_episodes"])
        assert list(row.pc_success_ci95) == theirs["pc_success_ci95"]
        assert row.failures == theirs["failures"]
    assert len(found.episodes) == 4 * 3
    assert [e.index for e in found.episodes] == list(range(12))
    assert sum(e.outcome.success for e in found.episodes[:3]) == found.rows[0].n_success


def test_policies_learn_from_the_suites_that_are_named(suite):
    found = evaluate("expert,tp-gmm", suite=suite, demonstrations="case_b,baseline7:2", workers=1)
    rows = [(row.policy, row.demonstrations) for row in found.rows]
    assert rows == [("expert", None), ("tp-gmm", "case_b"), ("tp-gmm", "baseline7:2")]
    protocols = evaluate(suite=suite, demonstrations="case_a", workers=1)
    policies = [row.policy for row in protocols.rows]
    assert len(set(policies)) == len(policies) > 3
    # The row is the same whatever others there are.
    alone = evaluate("tp-gmm", suite=suite, demonstrations="case_b", workers=1)
    assert [e.seed for e in alone.episodes] == [e.seed for e in found.episodes[3:6]]


@pytest.mark.parametrize("named", ["case_x", "case_a,mine", "case_a,", "none.h5"])
def test_what_is_neither_a_suite_nor_a_file_is_named(suite, named):
    with pytest.raises(InvalidInputError, match=f"'{named}': no such file.*baseline7"):
        evaluate("tp-gmm", suite=suite, demonstrations=named, workers=1)
    with pytest.raises(InvalidInputError, match="case_a:"):
        evaluate("tp-gmm", suite=suite, demonstrations="case_a:9", workers=1)


def test_results_stay_in_a_folder_only_if_one_is_named(suite, tmp_path):
    before = {path.name for path in tmp_path.iterdir()}
    evaluate("expert", suite=suite, workers=1)
    kept = {path.name for path in tmp_path.iterdir()} - before
    assert all(name.startswith("tried-") for name in kept)
    evaluate("expert", suite=suite, workers=1, out=tmp_path / "kept")
    assert (tmp_path / "kept" / "report.html").is_file()
    again = evaluate("expert", suite=suite, workers=1, out=tmp_path / "kept", resume=True)
    assert len(fake_benchmark.tries(tmp_path, "0")) == 2
    assert len(again.episodes) == 3


def test_a_table_is_a_data_frame_if_pandas_is_there(suite, monkeypatch):
    monkeypatch.setitem(sys.modules, "pandas", SimpleNamespace(DataFrame=list))
    (line,) = evaluate("expert", suite=suite, workers=1).to_pandas()
    assert (line["policy"], line["n_episodes"], line["demonstrations"]) == ("expert", 3, None)


def test_without_pandas_the_error_says_what_to_install(suite, monkeypatch):
    found = evaluate("expert", suite=suite, workers=1)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InvalidInputError, match="pip install pandas"):
        found.to_pandas()


def test_the_robot_stands_in_the_run_s_config_and_the_default_in_none():
    usual = evaluation_plan("paper", None, "expert", None, 0)
    other = evaluation_plan("paper", None, "expert", None, 0, robot="ur10")
    assert other.config == with_robot(EpisodeConfig(), "ur10")
    assert Plan.from_dict(other.to_dict()) == other
    assert evaluation_plan("paper", None, "expert", None, 0, robot="panda") == usual
    assert usual.config == EpisodeConfig()


def test_a_run_names_its_robot_and_does_not_go_on_with_another(suite, tmp_path, capsys):
    command = ["evaluate", "--suite", suite, "--policies", "expert", "--workers", "1"]
    command += ["--no-pictures", "--out", "run"]
    main([*command, "--robot", "ur10"])
    rows = json.loads((tmp_path / "run/summary.json").read_text())["rows"]
    assert [row["robot"] for row in rows] == ["UR10"]
    assert "The robot is UR10" in (tmp_path / "run/report.md").read_text()
    done = (tmp_path / "run/episodes.jsonl").read_bytes()
    for flags in ([], ["--robot", "panda"]):
        capsys.readouterr()
        with pytest.raises(SystemExit) as stopped:
            main([*command, *flags, "--resume"])
        assert stopped.value.code == 2
        told = capsys.readouterr().err
        assert "another config" in told
        assert "UR10" in told
    main([*command, "--robot", "ur10", "--resume"])
    assert (tmp_path / "run/episodes.jsonl").read_bytes() == done
    (row,) = evaluate("expert", suite=suite, workers=1).rows
    assert row.robot == "panda"


def test_a_class_goes_by_its_module_and_name():
    name = policy_name(fake_benchmark.FakePolicy)
    assert name == "fake_benchmark:FakePolicy"
    assert policy_name(" tp-gmm?end_radius=0 ") == "tp-gmm?end_radius=0"


def test_a_class_that_others_could_not_import_is_refused():
    class Hidden:
        pass

    with pytest.raises(InvalidInputError, match="valid is a class at the top of a module"):
        policy_name(Hidden)


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ({"protocol": "nothing"}, "unknown protocol 'nothing'"),
        ({"protocol": "paper-cost"}, "dresses nobody"),
        ({"suite": "nowhere"}, "unknown suite"),
        ({"policies": ["nobody"]}, "unknown policy 'nobody'"),
        ({"workers": 0}, "workers is 0"),
        ({"seed": -1}, "seed is -1"),
    ],
)
def test_a_mistake_is_an_error_before_anything_runs(arguments, part):
    with pytest.raises(InvalidInputError, match=part):
        evaluate(**arguments)
