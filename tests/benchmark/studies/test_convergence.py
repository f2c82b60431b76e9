import json
from functools import partial

import numpy as np
import pytest
from fake_trials import fake_simulate

from dressing_sim.arm import Posture
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.progress import silent
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.convergence import Convergence, convergence_plan
from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Trial,
    path_of,
    settings,
    simulate,
)
from dressing_sim.benchmark.studies.protocols import find_protocol
from dressing_sim.cli import main
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import grip_start

POSTURE = Posture("p", flexion_deg=70.0, abduction_deg=20.0, rotation_deg=30.0, elbow_deg=40.0)


def test_the_study_varies_mesh_step_iterations_tolerance_and_solver_mostly_one_at_a_time():
    default, *others = settings()
    assert default.config == EpisodeConfig()
    plain = to_plain(default.config)
    changed = set()
    for other in others:
        theirs = to_plain(other.config)
        different = {
            key
            for usual, own in (
                (plain["world"]["solver"], theirs["world"]["solver"]),
                (plain["world"]["sleeve"], theirs["world"]["sleeve"]),
                (plain["tracking"], theirs["tracking"]),
            )
            for key in usual
            if usual[key] != own[key]
        }
        assert different
        together = {"CG", "CG with 10 iterations", "coarse mesh and double step"}
        if other.name not in {FINEST, *together}:
            assert len(different - {"contact_time"}) == 1
        # A contact heals in as many steps.
        ratio = theirs["world"]["sleeve"]["contact_time"] / theirs["world"]["solver"]["timestep"]
        assert ratio == pytest.approx(2.0)
        changed |= different
    assert {"timestep", "edge", "iterations", "tolerance", "solver"} <= changed
    edges = {s.name: s.config.world.sleeve.edge for s in settings()}
    ladder = ("coarse mesh", "longer edges", DEFAULT, "finer mesh", "fine mesh")
    assert [edges[name] for name in ladder] == sorted((edges[n] for n in ladder), reverse=True)
    assert len({edges[name] for name in ladder}) == len(ladder)
    steps = {s.name: s.config.world.solver.timestep for s in settings()}
    assert steps["half step"] == 0.5 * steps[DEFAULT] == 0.25 * steps["double step"]
    assert steps["quarter step"] == 0.5 * steps["half step"]
    assert len({s.name for s in settings()}) == len(settings())
    assert not any("," in s.name for s in settings())  # a comma separates the names of --settings


def test_paths_are_the_operators_straight_lower_and_higher():
    start = grip_start(POSTURE, EpisodeConfig().world.sleeve)
    paths = {kind: path_of(kind, POSTURE, start, 3)[0] for kind in PATHS}
    expert = paths["expert"]
    for path in paths.values():
        np.testing.assert_allclose(path[0], start)
    np.testing.assert_allclose(paths["straight"][-1], expert[-1])
    way = paths["straight"] - start
    assert np.linalg.norm(np.cross(way, way[-1]), axis=1).max() < 1e-12
    half = len(expert) // 2
    assert np.all(paths["too low"][half:, 2] < expert[half:, 2] - 0.05)
    assert np.all(paths["too high"][half:, 2] > expert[half:, 2] + 0.1)


def test_a_coarser_mesh_would_not_do():
    """Why edges are not longer: large triangles catch at an elbow that small ones pass.

    Pulled straight over the elbow of val02.
    """
    (posture,) = (p for p in load_suite("val50") if p.name == "val02")
    names = (DEFAULT, "coarse mesh", "finer mesh")
    pulls = {
        s.name: simulate(
            Trial(0, s.name, "straight", posture.name), s.config, posture, 0
        ).outcome.metrics["grip_force"]
        for s in settings()
        if s.name in names
    }
    assert pulls["coarse mesh"] > 1.3 * pulls[DEFAULT]
    assert pulls[DEFAULT] == pytest.approx(pulls["finer mesh"], rel=0.15)


def test_jobs_come_by_setting_path_and_posture_and_run_posture_by_posture(tmp_path):
    plan = convergence_plan(postures=2, only=["coarse mesh"])
    study = Convergence()
    jobs = study.jobs(plan)
    assert [job.index for job in jobs] == list(range(4 * len(PATHS) * 2))
    assert [job.setting for job in jobs[:: len(PATHS) * 2]] == [
        DEFAULT,
        FINEST,
        "coarse mesh",
        CONVERGED,
    ]
    with open_run(tmp_path / "run", plan) as folder:
        _, calls = study.calls(folder, jobs, None, silent)
    order = [job for job, _ in calls]
    assert {job.index for job in order} == {job.index for job in jobs}
    for first in range(0, len(order), 4):
        assert len({(job.posture, job.path) for job in order[first : first + 4]}) == 1


@pytest.fixture
def validate(monkeypatch, tmp_path):
    """The command line without physics."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(STUDIES, "convergence", partial(Convergence, fake_simulate))
    return lambda *arguments: main(["validate", "--workers", "1", *arguments])


@pytest.mark.parametrize("only", ["coarse mesh, default", f"coarse mesh,{FINEST}"])
def test_the_default_the_finest_and_a_converged_solver_are_always_tried(validate, only, tmp_path):
    validate("--postures", "3", "--settings", only, "--out", "here")
    plan = load_run(tmp_path / "here").plan
    assert plan.options == {"settings": [DEFAULT, FINEST, "coarse mesh", CONVERGED]}
    assert (len(plan.tested), plan.seed) == (3, 0)
    summary = json.loads((tmp_path / "here" / "summary.json").read_text())
    assert summary["passed"]
    assert summary["solver_error"] == 0.0
    assert (tmp_path / "here" / "convergence.svg").is_file()


def test_all_settings_are_tried_unless_some_are_chosen():
    plan = convergence_plan()
    assert plan.options == {"settings": [setting.name for setting in settings()]}
    assert len(plan.tested) == 15


def test_a_study_that_stopped_goes_on(validate, tmp_path):
    arguments = ("--postures", "1", "--settings", "CG", "--out", "here")
    validate(*arguments)
    file = tmp_path / "here" / "episodes.jsonl"
    whole = file.read_bytes()
    file.write_bytes(b"".join(whole.splitlines(keepends=True)[:5]))
    (tmp_path / "here" / "summary.json").unlink()
    validate(*arguments, "--resume")
    assert file.read_bytes() == whole


def test_a_solver_that_could_not_be_judged_is_exit_code_1(validate, capsys):
    with pytest.raises(SystemExit) as stopped:
        validate("--postures", "2", "--settings", "CG", "--seed", "7", "--json")
    assert stopped.value.code == 1
    assert json.loads(capsys.readouterr().out)["agreement"] == 1.0


def test_an_unknown_setting_is_one_line(validate, capsys, tmp_path):
    with pytest.raises(SystemExit) as stopped:
        validate("--settings", "coarse mesh,finer")
    assert stopped.value.code == 2
    error = capsys.readouterr().err
    assert f"unknown setting 'finer'; valid is one of {DEFAULT}" in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_a_folder_with_a_run_of_another_study_is_left_alone(validate, capsys, tmp_path):
    with open_run(tmp_path / "run", make_plan(find_protocol("paper"))):
        pass
    before = (tmp_path / "run" / "config.json").read_bytes()
    with pytest.raises(SystemExit) as stopped:
        validate("--out", "run")
    assert stopped.value.code == 2
    assert "run holds a run of another study, 'success'" in capsys.readouterr().err
    assert (tmp_path / "run" / "config.json").read_bytes() == before
