import json
import subprocess
import sys

import numpy as np
import pytest
from learning_tasks import PLANAR_FILE, needs_reference

from dressing_sim.commands.planar import planar
from dressing_sim.errors import InvalidInputError

SHORT = {"runs": 1, "max_iterations": 2, "method": "noise"}


def shell(*arguments):
    return subprocess.run(
        [sys.executable, "-m", "dressing_sim", "planar", *arguments],
        capture_output=True,
        text=True,
        check=False,
    )


def test_json_is_all_that_goes_to_standard_output(capsys):
    planar(json=True, **SHORT)
    output = capsys.readouterr()
    result = json.loads(output.out)
    assert result["initial_training_cost"] > 0
    assert result["rows"][0]["method"] == "noise"
    assert "Algorithm 1" in output.err or "noise" in output.err


def test_a_study_that_fails_leaves_the_one_line_of_the_error_alone(capsys, monkeypatch):
    def fails(*arguments):
        raise InvalidInputError("a component's covariance became singular")

    monkeypatch.setattr(sys.modules["dressing_sim.commands.planar"], "run_study", fails)
    with pytest.raises(InvalidInputError):
        planar(**SHORT)
    assert capsys.readouterr().err == ""


def test_a_table_and_files(capsys, tmp_path):
    planar(out=tmp_path / "a" / "b", **SHORT)
    table = capsys.readouterr().out
    assert table == (tmp_path / "a" / "b" / "table.md").read_text()
    names = {path.name for path in (tmp_path / "a" / "b").iterdir()}
    assert {"summary.json", "table.md", "cost.png"} <= names


@needs_reference
@pytest.mark.parametrize(
    ("fusion", "cost"),
    [("regression-then-product", 2.1695696), ("product-then-regression", 1.48576)],
)
def test_the_papers_file_on_the_command_line(fusion, cost):
    arguments = ["--runs", "1", "--max-iterations", "1", "--fusion", fusion]
    run = shell("--demos", str(PLANAR_FILE), "--components", "8", "--json", *arguments)
    assert run.returncode == 0, run.stderr
    result = json.loads(run.stdout)
    assert result["initial_training_cost"] == pytest.approx(cost, abs=5e-6)
    assert result["initial_validation_cost"] is None


@pytest.mark.parametrize("components", [1, 3, 20])
def test_any_number_of_components(components, capsys):
    planar(components=components, json=True, **SHORT)
    assert np.isfinite(json.loads(capsys.readouterr().out)["initial_training_cost"])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"components": 0}, "n_components"),
        ({"components": 1000}, "too few"),
        ({"runs": 0}, "runs"),
        ({"workers": 0}, "workers"),
    ],
)
def test_unusable_arguments_are_errors(arguments, message):
    with pytest.raises(InvalidInputError, match=message):
        planar(**{**SHORT, **arguments})


def test_several_sets_are_judged_and_written(capsys, tmp_path):
    planar(sets=2, components=3, out=tmp_path / "out", json=True, **{**SHORT, "method": "all"})
    result = json.loads(capsys.readouterr().out)
    assert result == json.loads((tmp_path / "out" / "summary.json").read_text())
    assert result["settings"]["sets"] == 2
    assert {row["verdict"] for row in result["claims"]} <= {"confirmed", "refuted", "undecided"}
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"summary.json", "table.md"}


@needs_reference
def test_recordings_are_left_out_one_by_one(capsys):
    fourth = PLANAR_FILE.with_name("planar_fourth.npz")
    planar(demos=PLANAR_FILE, validation=fourth, leave_one_out=True, json=True, **SHORT)
    result = json.loads(capsys.readouterr().out)
    assert result["settings"]["sets"] == 4
    assert result["demonstrations"]["n"] == 4
    assert result["initial"]["training"][3] == pytest.approx(2.1695696, abs=5e-6)
    assert result["initial"]["validation"][3] == pytest.approx(2.32465, abs=5e-5)


def test_options_that_do_not_go_together_are_errors(tmp_path):
    file = tmp_path / "demos.npz"
    with pytest.raises(InvalidInputError, match="--leave-one-out needs --demos"):
        planar(leave_one_out=True, **SHORT)
    with pytest.raises(InvalidInputError, match="--sets counts generated sets"):
        planar(demos=file, sets=2, **SHORT)
    with pytest.raises(InvalidInputError, match="sets is 0"):
        planar(sets=0, **SHORT)


def test_a_missing_file_is_one_line_and_exit_code_2(tmp_path):
    run = shell("--demos", str(tmp_path / "none.npz"))
    assert run.returncode == 2
    assert run.stderr.strip().splitlines() == [f"dressing-sim: no file {tmp_path / 'none.npz'}"]
    assert run.stdout == ""
