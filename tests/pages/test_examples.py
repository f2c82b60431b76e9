"""Every example runs, and says what it promises."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))

SAYS = {
    "01_step_a_dressing.py": "both branches repeat to the bit",
    "02_react_to_force.py": "grip_force",
}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_an_example_runs(example, tmp_path):
    done = subprocess.run(
        [sys.executable, example], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert SAYS[example.name] in done.stdout
    assert len(example.read_text(encoding="utf-8").splitlines()) <= 80
    assert not list(tmp_path.iterdir())


def test_there_are_examples():
    assert {path.name for path in EXAMPLES} == set(SAYS)
