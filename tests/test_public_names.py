import ast
import subprocess
import sys
from pathlib import Path

import pytest

import dressing_sim

STUB = Path(dressing_sim.__file__).with_suffix(".pyi")


@pytest.mark.parametrize("name", dressing_sim.__all__)
def test_every_public_name_can_be_had(name):
    assert getattr(dressing_sim, name) is not None
    assert name in dir(dressing_sim)


def test_the_names_that_scripts_rely_on_are_public():
    assert {
        "Demonstration",
        "Dressing",
        "EpisodeConfig",
        "Operator",
        "Outcome",
        "Path",
        "Policy",
        "Posture",
        "demonstrate",
        "dress",
        "evaluate",
        "load_demonstrations",
        "load_suite",
        "record",
        "sample_postures",
        "save_demonstrations",
    } <= set(dressing_sim.__all__)


def test_type_checkers_know_the_same_names_from_the_same_modules():
    imports = [n for n in ast.parse(STUB.read_text()).body if isinstance(n, ast.ImportFrom)]
    typed = {alias.asname: node.module for node in imports for alias in node.names}
    assert typed == dressing_sim._PUBLIC


def test_a_type_checker_sees_no_any(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "from dressing_sim import Dressing, Posture, demonstrate, load_suite\n"
        "reveal_type(Dressing(load_suite('paper5')[0]).reset().grip_force)\n"
        "reveal_type(demonstrate(Posture('a', 70, 0, 40, 20), 0).outcome)\n"
    )
    mypy = pytest.importorskip("mypy.api")
    out, _, _ = mypy.run([str(script), "--strict", "--cache-dir", str(tmp_path / "cache")])
    revealed = [line for line in out.splitlines() if "Revealed type" in line]
    assert len(revealed) == 2
    assert "float" in revealed[0]
    assert "Outcome" in revealed[1]
    assert not any("Any" in line for line in revealed)


def test_another_name_is_an_error():
    with pytest.raises(AttributeError, match="undress"):
        _ = dressing_sim.undress


@pytest.mark.parametrize("module", ["dressing_sim", "dressing_sim.learning"])
def test_the_import_needs_neither_simulator_nor_robot(module):
    code = (
        f"import sys, {module}; "
        "print(sorted({'mujoco', 'pinocchio', 'h5py', 'matplotlib'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"


def test_the_package_itself_imports_nothing_heavy():
    code = "import sys, dressing_sim; print('numpy' in sys.modules)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "False"
