from dataclasses import replace

import numpy as np
import pytest
from learning_tasks import PLANAR_FILE, needs_reference

from dressing_sim.errors import InvalidInputError
from dressing_sim.planar.files import load
from dressing_sim.planar.generator import PlanarData, generate
from dressing_sim.planar.sets import (
    SIZES,
    Ratio,
    gain,
    generated,
    leave_one_out,
    mean_cost,
    run_sets,
)
from dressing_sim.planar.sets_report import sets_markdown, sets_summary
from dressing_sim.planar.study import OPTIONS, StudyConfig, run_study

SHORT = StudyConfig(runs=1, components=4, options=replace(OPTIONS, max_iterations=3))
SETS = generated(5, 2)


@pytest.fixture(scope="module")
def studies():
    return run_sets(SETS, SHORT)


def test_a_ratio_is_a_geometric_mean_with_students_interval():
    ratio = Ratio.of(np.log([0.5, 2.0]))
    assert ratio.estimate == pytest.approx(1.0)
    # t(0.975, 1) = tan(0.475 pi); the deviation over the root of two is log 2.
    assert ratio.high == pytest.approx(np.exp(np.tan(0.475 * np.pi) * np.log(2.0)))
    assert ratio.low == pytest.approx(1.0 / ratio.high)
    alone = Ratio.of([np.log(0.9)])
    assert (alone.low, alone.high, alone.n) == (0.0, np.inf, 1)


def test_intervals_hold_the_mean_as_often_as_they_say():
    rng = np.random.default_rng(3)
    ratios = [Ratio.of(0.1 * rng.standard_normal(6)) for _ in range(1000)]
    held = np.mean([one.low <= 1.0 <= one.high for one in ratios])
    assert held == pytest.approx(0.95, abs=0.02)


def test_each_is_left_out_once():
    data = generate(0)
    folds = leave_one_out(data)
    everything = (*data.training, *data.validation)
    assert [fold.validation for fold in folds] == [(one,) for one in everything]
    for fold in folds:
        assert {*fold.training, *fold.validation} == {*everything}
        assert len(fold.training) == len(everything) - 1
    with pytest.raises(InvalidInputError, match="3 demonstrations or more, there are 2"):
        leave_one_out(PlanarData(data.training[:2], ()))


def test_sets_are_those_of_their_seeds_with_some_more_to_test():
    alone = generate(6)
    assert SIZES[:2] == (len(alone.training), len(alone.validation))
    np.testing.assert_array_equal(SETS[1].training[2].positions, alone.training[2].positions)
    np.testing.assert_array_equal(SETS[1].validation[0].positions, alone.validation[0].positions)
    assert len(SETS[1].test) == SIZES[2]
    with pytest.raises(InvalidInputError, match="sets"):
        generated(0, 0)


def test_a_set_does_not_depend_on_the_others(studies):
    alone = run_study(SETS[1], replace(SHORT, seed=SHORT.seed + 1))
    assert [run.test_cost for run in alone.runs] == [run.test_cost for run in studies[1].runs]


def test_gains_are_against_the_sets_own_initial_model(studies):
    for study in studies:
        cost = mean_cost(study, "rf", "original", "test")
        assert gain(study, "rf", "original", "test") == pytest.approx(
            np.log(cost / study.initial.cost(study.data.test))
        )
        assert gain(study, "copies", "original", "training") <= 0.0


def test_the_result_has_every_cell_and_says_how_demonstrations_vary(studies):
    result = sets_summary(studies, "tests")
    assert len(result["rows"]) == 2 * 4
    assert {kind: len(costs) for kind, costs in result["initial"].items()} == {
        "training": 2,
        "validation": 2,
        "test": 2,
    }
    for row in result["rows"]:
        percent = row["test"]["percent"]
        assert percent["low"] <= percent["mean"] <= percent["high"]
        assert len(row["test"]["percent_of_sets"]) == 2
    assert result["demonstrations"]["n"] == 2 * sum(SIZES)
    table = sets_markdown(result)
    for block in table.split("\n\n"):
        assert len({line.count("|") for line in block.splitlines()}) == 1 or "|" not in block


@needs_reference
def test_the_fourth_recording_has_the_costs_that_are_known():
    data = load(PLANAR_FILE, PLANAR_FILE.with_name("planar_fourth.npz"))
    (fold,) = [one for one in leave_one_out(data) if one.validation == data.validation]
    none = replace(
        SHORT, components=8, methods=("copies",), options=replace(OPTIONS, max_iterations=0)
    )
    for fusion, cost in (
        ("regression-then-product", 2.32465),
        ("product-then-regression", 3.99897),
    ):
        (study,) = run_sets([fold], replace(none, fusion=fusion))
        assert study.initial_validation_cost == pytest.approx(cost, abs=5e-5)
