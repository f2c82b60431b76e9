import json
from dataclasses import replace

import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim.errors import InvalidInputError
from dressing_sim.planar.figures import draw
from dressing_sim.planar.generator import START, PlanarData, generate
from dressing_sim.planar.report import markdown, summary
from dressing_sim.planar.study import OPTIONS, StudyConfig, run_study, situation_sampler

DATA = generate(2)
SIX = replace(OPTIONS, max_iterations=6)
TWO = replace(OPTIONS, max_iterations=2)
SETTINGS = StudyConfig(runs=2, options=SIX, components=5)


@pytest.fixture(scope="module")
def study():
    return run_study(DATA, SETTINGS)


def test_every_method_and_selection_is_there(study):
    result = summary(study)
    assert {(row["selection"], row["method"]) for row in result["rows"]} == {
        (selection, method)
        for selection in ("original", "generalisation")
        for method in ("noise", "rf", "rf+noise", "copies")
    }
    for row in result["rows"]:
        assert row["runs"] == 2
        assert 0 <= row["accepted_mean"] <= 5
        criterion = "training" if row["selection"] == "original" else "validation"
        assert row[f"{criterion}_cost_best"] <= result[f"initial_{criterion}_cost"]
        assert row[f"{criterion}_cost_best"] <= row[f"{criterion}_cost_mean"] + 1e-12


def test_the_result_does_not_depend_on_the_number_of_workers(study):
    assert summary(run_study(DATA, SETTINGS, workers=2)) == summary(study)


def test_a_run_does_not_depend_on_what_else_is_run(study):
    alone = run_study(DATA, StudyConfig(methods=("rf",), runs=1, options=SIX, components=5))
    costs = [c.cost for c in alone.of("rf", "original")[0].augmentation.history]
    assert costs == [c.cost for c in study.of("rf", "original")[0].augmentation.history]


def test_runs_differ_from_each_other(study):
    a, b = study.of("noise", "original")
    assert a.augmentation.history[0].cost != b.augmentation.history[0].cost


def test_without_a_validation_set_there_is_none_in_the_result():
    data = PlanarData(DATA.training, ())
    result = summary(run_study(data, StudyConfig(runs=1, options=TWO, methods=("noise",))))
    assert [row["selection"] for row in result["rows"]] == ["original"]
    assert result["initial_validation_cost"] is None
    assert result["rows"][0]["validation_cost_mean"] is None
    assert result["rows"][0]["training_cost_mean"] is not None
    assert "| - |" in markdown(result)


def test_the_result_is_json_and_a_table(study):
    result = summary(study)
    assert json.loads(json.dumps(result)) == result
    table = markdown(result)
    widths = {line.count("|") for line in table.splitlines() if line.startswith("|")}
    assert len(widths) == 1
    assert "2.17" in table


def test_progress_is_told_of_every_run_in_order():
    seen = []
    study = run_study(DATA, SETTINGS, on_run=seen.append)
    assert tuple(seen) == study.runs


def test_figures_are_drawn_with_and_without_a_validation_set(study, tmp_path):
    names = ["demonstrations", "reproductions", "generalisation", "frames", "cost"]
    assert [path.stem for path in draw(study, tmp_path)] == names
    assert all((tmp_path / f"{name}.png").stat().st_size > 5000 for name in names)
    data = PlanarData(DATA.training, ())
    plain = run_study(data, StudyConfig(runs=1, options=TWO, methods=("rf+noise",)))
    (tmp_path / "plain").mkdir()
    assert len(draw(plain, tmp_path / "plain")) == 5


def test_the_papers_situations_keep_the_start_and_the_goals_handedness():
    sampler = situation_sampler(DATA, "paper")
    rng = np.random.default_rng(0)
    for _ in range(50):
        start, goal = sampler.sample(rng)
        np.testing.assert_allclose(start.A, START.A)
        np.testing.assert_allclose(start.b, START.b)
        assert np.linalg.det(goal.A) == pytest.approx(-0.1)
        assert ((goal.b >= 0) & (goal.b <= 0.75)).all()


def test_other_tasks_need_their_own_situations():
    data = PlanarData(tuple(reaching_demonstrations(2)), ())
    with pytest.raises(InvalidInputError, match="--situations demonstrations"):
        situation_sampler(data, "paper")
    assert len(situation_sampler(data, "demonstrations").sample(np.random.default_rng(0))) == 2


@pytest.mark.parametrize("settings", [{"runs": 0}, {"seed": -1}])
def test_unusable_settings_are_errors(settings):
    with pytest.raises(InvalidInputError):
        StudyConfig(**settings)
    with pytest.raises(InvalidInputError, match="workers"):
        run_study(DATA, SETTINGS, workers=0)
