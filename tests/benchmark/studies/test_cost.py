import json
from concurrent.futures import BrokenExecutor, Future
from dataclasses import replace

import numpy as np
import pytest
from fake_benchmark import Threads

from dressing_sim.benchmark.report.write import write_report
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.studies import cost
from dressing_sim.benchmark.studies.cost import (
    PAPER_COST,
    PAPER_DISCARDED,
    CostRun,
    run_paper_cost,
    run_seed,
    summarise_runs,
)
from dressing_sim.benchmark.studies.cost_document import cost_document, cost_plot, cost_table
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.operator import Operator
from dressing_sim.learning import AugmentOptions
from dressing_sim.policies.paper import AUGMENTED, AugmentedTPGMMConfig
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import WorldConfig, grip_start

QUICK = AugmentedTPGMMConfig(options=AugmentOptions(max_iterations=12), samples=60)


@pytest.fixture(scope="module")
def shown():
    """What the operator would do on the postures of both cases, recorded without a world."""
    operator, rng = Operator(), np.random.default_rng(0)
    sets = {}
    for name in ("case_a", "case_b"):
        sets[name] = []
        for posture in load_suite(name):
            path = operator.path(posture, grip_start(posture, WorldConfig().sleeve), rng)
            sets[name].append(Demonstration(path, 0.02, posture, 0, np.zeros((len(path), 7))))
    return sets


@pytest.fixture(scope="module")
def summary(shown):
    with Threads(1) as workers:
        return run_paper_cost(workers, shown, seed=3, config=QUICK, runs=3)


def without_seconds(summary):
    rows = [{k: v for k, v in row.items() if k != "seconds_median"} for row in summary["rows"]]
    return {**summary, "rows": rows}


def test_there_is_a_row_for_each_case_and_method(summary):
    rows = [(row["demonstrations"], row["policy"]) for row in summary["rows"]]
    assert rows == [(case, policy) for case in ("case_a", "case_b") for policy in AUGMENTED]
    for row in summary["rows"]:
        assert [step["n"] for step in row["steps"]] == [0, 1, 2, 3, 4, 5]
        assert row["n_runs"] == 3
        assert row["seconds_median"] > 0


def test_without_synthetic_demonstrations_all_methods_cost_the_same(summary):
    for case in ("case_a", "case_b"):
        first = {
            row["steps"][0]["cost"] for row in summary["rows"] if row["demonstrations"] == case
        }
        assert len(first) == 1


def test_the_cost_of_all_runs_never_rises(summary):
    fell = False
    for row in summary["rows"]:
        costs = [step["cost_of_all"] for step in row["steps"]]
        assert (np.diff(costs) <= 0).all()
        fell = fell or costs[-1] < costs[0]
    assert fell


def test_the_summary_does_not_depend_on_the_number_of_workers(shown, summary):
    with Threads(3) as workers:
        again = run_paper_cost(workers, shown, seed=3, config=QUICK, runs=3)
    assert without_seconds(again) == without_seconds(summary)
    assert json.loads(json.dumps(summary)) == summary


def test_a_run_whose_worker_died_is_run_once_more(shown, summary):
    class FirstDies(Threads):
        calls = 0

        def submit(self, fn, /, *args, **kwargs):
            self.calls += 1
            if self.calls > 1:
                return super().submit(fn, *args, **kwargs)
            future = Future()
            future.set_exception(BrokenExecutor("killed"))
            return future

    with FirstDies(2) as workers:
        again = run_paper_cost(workers, shown, seed=3, config=QUICK, runs=3)
    assert without_seconds(again) == without_seconds(summary)


def test_runs_can_be_sent_to_processes(shown):
    config = replace(
        QUICK, options=AugmentOptions(max_iterations=1), free_axes="arm-plane", situations="arms"
    )
    told = []
    with Processes(1) as workers:
        result = run_paper_cost(
            workers,
            {"case_a": shown["case_a"]},
            config=config,
            runs=1,
            progress=lambda *call: told.append(call),
        )
    assert result["config"]["policy"]["free_axes"] == "arm-plane"
    assert told == [("runs", done, len(AUGMENTED), ()) for done in range(len(AUGMENTED) + 1)]


def test_every_run_has_its_own_seed():
    seeds = {run_seed(seed, run) for seed in range(5) for run in range(20)}
    assert len(seeds) == 100


def test_a_run_that_does_not_get_there_is_counted_honestly():
    runs = [CostRun((4.0, 2.0, 1.0), (0, 3, 9), 1.0), CostRun((4.0, 3.0), (0, 1), 1.0)]
    none, one, two, three = summarise_runs(runs, 3, np.random.default_rng(0))
    assert (none["n_reached"], none["cost"], none["discarded"]) == (2, 4.0, 0.0)
    assert none["cost_ci95"] == [4.0, 4.0]
    assert (one["n_reached"], one["cost"], one["discarded"]) == (2, 2.5, 1.0)
    assert one["cost_ci95"] == [2.0, 3.0]
    assert (two["n_reached"], two["cost"], two["discarded"]) == (1, 1.0, 7.0)
    assert two["cost_of_all"] == 2.0
    assert three["n_reached"] == 0
    assert three["cost"] is three["cost_ci95"] is three["discarded"] is None
    assert three["cost_of_all"] == 2.0


def test_intervals_narrow_with_the_number_of_runs(rng):
    def width(n):
        runs = [CostRun((value,), (0,), 1.0) for value in rng.normal(5.0, 1.0, n)]
        low, high = summarise_runs(runs, 0, np.random.default_rng(0))[0]["cost_ci95"]
        return high - low

    # The standard error of the mean, times 2 x 1.96.
    assert width(400) == pytest.approx(3.92 / 20, rel=0.2)
    assert width(100) == pytest.approx(3.92 / 10, rel=0.3)


def test_the_paper_has_a_number_for_each_step():
    assert len(PAPER_COST) == len(PAPER_DISCARDED) == 6
    assert (np.diff(PAPER_COST) < 0).all()
    assert (np.diff(PAPER_DISCARDED) > 0).all()
    assert cost.RUNS == 20


def test_the_report_is_written_whole(summary, tmp_path):
    document = cost_document(summary, "dressing-sim evaluate --protocol <cost>")
    write_report(tmp_path / "out", document, summary)
    files = {path.name: path.read_text() for path in (tmp_path / "out").iterdir()}
    assert set(files) == {"summary.json", "report.md", "report.html", "cost.svg"}
    assert json.loads(files["summary.json"]) == summary
    for row in cost_table(summary):
        assert "| " + " | ".join(row) + " |" in files["report.md"]
    assert "0.051 (38.9 discarded)" in files["report.md"]
    assert "tp-gmm-rf-noise" in files["report.html"]
    assert "&lt;cost&gt;" in files["report.html"]
    assert "<svg" in files["report.html"]
    assert '"position_floor"' in files["report.md"]
    assert "src=" not in files["report.html"]


def test_the_plot_is_the_same_each_time(summary):
    assert cost_plot(summary) == cost_plot(summary)


def test_a_step_that_no_run_reached_has_no_number_in_the_table(summary):
    runs = [CostRun((4.0,), (0,), 1.0)]
    row = {**summary["rows"][0], "n_runs": 1}
    row["steps"] = summarise_runs(runs, 1, np.random.default_rng(0))
    last = cost_table({**summary, "rows": [row]})[-1]
    assert last[3:6] == ["0 / 1", "-", "-"]
    assert last[6].startswith("4.0000")
