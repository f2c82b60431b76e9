import json

import pytest

from dressing_sim import doctor, learning
from dressing_sim.cli import main
from dressing_sim.errors import DressingSimError
from dressing_sim.pictures import rendering


def findings():
    return {finding.name: finding for finding in doctor.examine()}


@pytest.fixture
def quick(monkeypatch):
    """Only the checks of packages and pictures, and of those only what the test makes of them."""
    monkeypatch.setattr(doctor, "_simulation", lambda: "skipped")
    monkeypatch.setattr(rendering, "probe", lambda backend: None)


def test_this_installation_is_well():
    found = findings()
    assert {
        *("python", "packages", "compiled loops"),
        *("robot description", "simulation", "suites"),
    } <= set(found)
    ill = [finding for finding in found.values() if finding.needed and not finding.ok]
    assert ill == []
    assert "mujoco 4.0" in found["packages"].detail
    assert "panda.urdf" in found["robot description"].detail
    assert "settled" in found["simulation"].detail
    assert "paper5 (5)" in found["suites"].detail


def test_what_fails_is_reported_and_the_rest_is_checked_too(quick, monkeypatch):
    def missing():
        raise DressingSimError("the robot is not installed")

    monkeypatch.setattr(doctor, "_robot", missing)
    found = findings()
    assert not found["robot description"].ok
    assert "the robot is not installed" in found["robot description"].detail
    assert found["suites"].ok


def test_a_broken_installation_is_exit_code_1_and_each_finding_a_line(quick, monkeypatch, capsys):
    def missing():
        raise DressingSimError("the robot is not installed")

    monkeypatch.setattr(doctor, "_robot", missing)
    with pytest.raises(SystemExit) as stopped:
        main(["doctor"])
    assert stopped.value.code == 1
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("FAILED   robot description: ") for line in lines)
    assert any(line.startswith("ok       suites: ") for line in lines)


def test_loops_that_compute_something_else_are_found(quick, monkeypatch):
    monkeypatch.setattr(learning, "dtw_distance", lambda *paths: 0.7)
    assert not findings()["compiled loops"].ok


def test_without_pictures_evaluation_still_works(quick, monkeypatch, capsys):
    monkeypatch.setattr(rendering, "probe", lambda backend: f"no {backend}")
    main(["doctor", "--json"])
    found = {finding["name"]: finding for finding in json.loads(capsys.readouterr().out)}
    assert not found["pictures"]["ok"]
    assert not found["pictures"]["needed"]
    assert "apt install" in found["pictures"]["detail"]
    assert found["pictures through egl"]["detail"] == "no egl"


def test_a_backend_that_was_asked_for_and_does_not_work_is_told(quick, monkeypatch):
    monkeypatch.setattr(rendering, "probe", lambda name: "broken" if name == "osmesa" else None)
    assert "pictures" not in findings()
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    found = findings()["pictures"]
    assert not found.ok
    assert "MUJOCO_GL=osmesa" in found.detail
