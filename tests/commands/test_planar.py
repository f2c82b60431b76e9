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


def test_a_missing_file_is_one_line_and_exit_code_2(tmp_path):
    run = shell("--demos", str(tmp_path / "none.npz"))
    assert run.returncode == 2
    assert run.stderr.strip().splitlines() == [f"dressing-sim: no file {tmp_path / 'none.npz'}"]
    assert run.stdout == ""
