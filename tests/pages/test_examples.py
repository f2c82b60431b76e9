"""Every example runs, and says what it promises."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples").glob("*.py"))

SAYS = {
    "01_step_a_dressing.py": "both branches repeat to the bit",
    "02_react_to_force.py": "grip_force",
    "03_gymnasium.py": "the rewards add up to",
    "04_learn_by_trial.py": "6 episodes; the return went from",
    "05_a_recording.py": "played again: True",
    "06_a_study_of_your_own.py": "friction 0.3: dressed 1 of 1",
    "07_a_second_task.py": "| take | 2 | straight line |",
    "08_a_failure_map.py": ": 1",
    "09_on_a_cluster.py": "1 episodes, the same bytes",
}

#: So that they take seconds.
BRIEFLY = {
    "04_learn_by_trial.py": ["--generations", "1", "--population", "4", "--out", "a.png"],
    "05_a_recording.py": ["--out", "a.csv", "--plot", "a.png"],
    "06_a_study_of_your_own.py": ["--suite", "random:1", "--frictions", "0.3"],
    "07_a_second_task.py": ["--counts", "2", "--splits", "1", "--plot", "a.png"],
    "08_a_failure_map.py": ["--suite", "random:1", "--plot", "a.png"],
    "09_on_a_cluster.py": ["--suite", "random:1"],
}

#: More lines than this are no example.
LINES = {"04_learn_by_trial.py": 200, "07_a_second_task.py": 200}

#: What an example needs and not every installation has.
NEEDS = {"03_gymnasium.py": ["gymnasium"], "04_learn_by_trial.py": ["gymnasium", "cmaes"]}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.name)
def test_an_example_runs(example, tmp_path):
    for package in NEEDS.get(example.name, ()):
        pytest.importorskip(package)
    command = [sys.executable, example, *BRIEFLY.get(example.name, ())]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert SAYS[example.name] in done.stdout
    assert len(example.read_text(encoding="utf-8").splitlines()) <= LINES.get(example.name, 80)
    wrote = {path.name for path in tmp_path.iterdir()}
    assert wrote == {name for name in command if str(name).endswith((".png", ".csv"))}


def test_there_are_examples_and_the_page_lists_them():
    assert {path.name for path in EXAMPLES} == set(SAYS)
    page = (EXAMPLES[0].parents[1] / "docs" / "examples.md").read_text(encoding="utf-8")
    assert {f"../examples/{name}" for name in SAYS} <= set(re.findall(r"\]\((.*?)\)", page))
