import subprocess
import sys

import pytest

import dressing_sim


@pytest.mark.parametrize("name", dressing_sim.__all__)
def test_every_public_name_can_be_had(name):
    assert getattr(dressing_sim, name) is not None
    assert name in dir(dressing_sim)


def test_the_names_that_scripts_rely_on_are_public():
    assert {
        "Demonstration",
        "Policy",
        "Posture",
        "dress",
        "load_demonstrations",
        "load_suite",
        "sample_postures",
        "save_demonstrations",
    } <= set(dressing_sim.__all__)


def test_another_name_is_an_error():
    with pytest.raises(AttributeError, match="undress"):
        _ = dressing_sim.undress


def test_the_learning_library_needs_neither_simulator_nor_robot():
    code = (
        "import sys, dressing_sim.learning; "
        "print(sorted({'mujoco', 'pinocchio', 'h5py', 'matplotlib'} & set(sys.modules)))"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "[]"
