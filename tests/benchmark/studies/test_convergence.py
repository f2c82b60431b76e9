import json

import numpy as np
import pytest
from fake_trials import STUCK, outcome

from dressing_sim.arm import Posture
from dressing_sim.benchmark.studies import convergence as validation
from dressing_sim.benchmark.studies.convergence import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Trial,
    path_of,
    settings,
    simulate,
)
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
            for part in ("solver", "sleeve")
            for key in plain["world"][part]
            if plain["world"][part][key] != theirs["world"][part][key]
        }
        assert different
        together = {"CG", "CG with 10 iterations", "coarse mesh and double step"}
        if other.name not in {FINEST, *together}:
            assert len(different) == 1
        changed |= different
    assert {"timestep", "edge", "iterations", "tolerance", "solver"} <= changed
    edges = {s.name: s.config.world.sleeve.edge for s in settings()}
    ladder = ("coarse mesh", DEFAULT, "fine mesh", "finer mesh", FINEST)
    assert [edges[name] for name in ladder] == sorted((edges[n] for n in ladder), reverse=True)
    assert len({edges[name] for name in ladder}) == len(ladder)
    steps = {s.name: s.config.world.solver.timestep for s in settings()}
    assert steps["half step"] == 0.5 * steps[DEFAULT] == 0.25 * steps["double step"]
    assert len({s.name for s in settings()}) == len(settings())
    assert not any("," in s.name for s in settings())  # a comma separates the names of --only


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

    Pulled straight over the elbow of val02 (measured: 5.8 N with the finest settings).
    """
    (posture,) = (p for p in load_suite("val50") if p.name == "val02")
    chosen = {s.name: s for s in settings()}
    outcomes = {
        name: simulate(chosen[name], "straight", posture, 0).outcome
        for name in (DEFAULT, "coarse mesh")
    }
    assert outcomes[DEFAULT].success
    assert "stuck" in outcomes["coarse mesh"].reasons


@pytest.fixture
def ran(monkeypatch, tmp_path):
    """The command line without physics; settings and number of postures are collected."""
    asked = []

    def study(postures, chosen, crew, seed, progress):
        asked.append(([setting.name for setting in chosen], len(postures), seed))
        outcomes = outcome(STUCK) if seed == 7 else outcome()
        return [
            Trial(s.name, kind, p.name, outcomes, 1.0)
            for s in chosen
            for kind in PATHS
            for p in postures
        ]

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(validation, "validate", study)
    return asked


@pytest.mark.parametrize("only", ["coarse mesh", "coarse mesh, default", f"coarse mesh,{FINEST}"])
def test_the_default_the_finest_and_a_converged_solver_are_always_tried(ran, only, tmp_path):
    main(["validate", "--workers", "1", "--postures", "3", "--only", only, "--out", "here"])
    assert ran == [([DEFAULT, FINEST, "coarse mesh", CONVERGED], 3, 0)]
    summary = json.loads((tmp_path / "here" / "summary.json").read_text())
    assert summary["passed"]
    assert summary["solver_error"] == 0.0


def test_all_settings_are_tried_unless_some_are_chosen(ran):
    main(["validate", "--workers", "1"])
    assert ran == [([setting.name for setting in settings()], 15, 0)]


def test_a_solver_that_could_not_be_judged_is_exit_code_1(ran, capsys):
    with pytest.raises(SystemExit) as stopped:
        main(["validate", "--workers", "1", "--only", "CG", "--seed", "7", "--json"])
    assert stopped.value.code == 1
    assert json.loads(capsys.readouterr().out)["agreement"] == 1.0


def test_an_unknown_setting_is_one_line(ran, capsys, tmp_path):
    with pytest.raises(SystemExit) as stopped:
        main(["validate", "--only", "coarse mesh,finer"])
    assert stopped.value.code == 2
    error = capsys.readouterr().err
    assert f"unknown setting 'finer'; valid is one of {DEFAULT}" in error
    assert error.count("\n") == 1
    assert ran == []
    assert not list(tmp_path.iterdir())


def test_a_folder_with_a_run_of_another_command_is_left_alone(ran, capsys, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "settings.json").write_text("{}")
    with pytest.raises(SystemExit) as stopped:
        main(["validate", "--workers", "1", "--out", "run"])
    assert stopped.value.code == 2
    assert "run holds a run of another command" in capsys.readouterr().err
    assert ran == []
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["settings.json"]
