import json
from concurrent.futures import BrokenExecutor, Future
from dataclasses import replace

import numpy as np
import pytest
from fake_benchmark import Threads, steady_demonstrate

from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.report.write import write_report
from dressing_sim.benchmark.run.executors import Processes, worker_numerics
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.progress import silent
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies import cost
from dressing_sim.benchmark.studies.cost import (
    PAPER_COST,
    PAPER_DISCARDED,
    Cost,
    CostRun,
    run_seed,
    summarise_runs,
)
from dressing_sim.benchmark.studies.cost_document import cost_document, cost_plot, cost_table
from dressing_sim.benchmark.studies.protocols import find_protocol
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.errors import DressingSimError
from dressing_sim.learning import AugmentOptions
from dressing_sim.policies.paper import AUGMENTED, AugmentedTPGMMConfig

QUICK = AugmentedTPGMMConfig(options=AugmentOptions(max_iterations=12), samples=60)


JOB = CostRun(0, Entry("tp-gmm-rf", "case_a"), 0)


def made(costs, tried):
    return replace(JOB, costs=costs, tried=tried, seconds=1.0)


def run_cost(folder, workers, seed=3, runs=3, config=QUICK, progress=silent, entries=None):
    """The summary of the study, of demonstrations that were made without a world."""
    protocol = find_protocol("paper-cost")
    plan = make_plan(
        replace(protocol, entries=entries or protocol.entries), seed, options={"runs": runs}
    )
    study = Cost(Work(demonstrate=steady_demonstrate), config)
    return run_study(study, plan, workers, folder, progress=progress).summary


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("cost") / "run"


@pytest.fixture(scope="module")
def summary(folder):
    with Threads(1) as workers:
        return run_cost(folder, workers)


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


def test_the_summary_does_not_depend_on_the_number_of_workers(tmp_path, summary):
    with Threads(3) as workers:
        again = run_cost(tmp_path / "run", workers)
    assert without_seconds(again) == without_seconds(summary)
    assert json.loads(json.dumps(summary)) == summary


def test_a_run_whose_worker_died_is_run_once_more(tmp_path, summary):
    class FirstDies(Threads):
        calls = 0

        def submit(self, fn, /, *args, **kwargs):
            self.calls += fn is not worker_numerics
            if self.calls != 1 or fn is worker_numerics:
                return super().submit(fn, *args, **kwargs)
            future = Future()
            future.set_exception(BrokenExecutor("killed"))
            return future

    with FirstDies(2) as workers:
        again = run_cost(tmp_path / "run", workers)
    assert without_seconds(again) == without_seconds(summary)


def test_a_finished_study_goes_on_without_another_run(folder, summary):
    study, plan = Cost(Work(None, None, None), QUICK), load_run(folder).plan
    with Threads(1) as workers:
        again = run_study(study, plan, workers, folder, resume=True).summary
    assert again == summary
    assert len(load_run(folder).lines) == 18


def test_runs_can_be_sent_to_processes(tmp_path):
    config = replace(
        QUICK, options=AugmentOptions(max_iterations=1), free_axes="arm-plane", situations="arms"
    )
    entries = tuple(Entry(policy, "case_a") for policy in AUGMENTED)
    told = []
    with Processes(1) as workers:
        result = run_cost(
            tmp_path / "run", workers, 0, 1, config, lambda *call: told.append(call), entries
        )
    assert result["config"]["policy"]["free_axes"] == "arm-plane"
    runs = [call for call in told if call[0] == "runs"]
    assert runs == [("runs", done, len(AUGMENTED), "") for done in range(len(AUGMENTED) + 1)]


def test_a_job_that_kills_its_workers_is_an_error():
    with pytest.raises(DressingSimError, match="job 0: worker died twice"):
        Cost().lost(None, JOB, "worker died twice")


def test_every_run_has_its_own_seed():
    seeds = {run_seed(seed, run) for seed in range(5) for run in range(20)}
    assert len(seeds) == 100


def test_a_run_that_does_not_get_there_is_counted_honestly():
    runs = [made((4.0, 2.0, 1.0), (0, 3, 9)), made((4.0, 3.0), (0, 1))]
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
        runs = [made((value,), (0,)) for value in rng.normal(5.0, 1.0, n)]
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
    runs = [made((4.0,), (0,))]
    row = {**summary["rows"][0], "n_runs": 1}
    row["steps"] = summarise_runs(runs, 1, np.random.default_rng(0))
    last = cost_table({**summary, "rows": [row]})[-1]
    assert last[3:6] == ["0 / 1", "-", "-"]
    assert last[6].startswith("4.0000")


def test_more_demonstrations_than_are_kept_have_one_step(tmp_path):
    entries = (Entry("tp-gmm-rf", "train200:8"),)
    with Threads(1) as workers:
        found = run_cost(tmp_path / "run", workers, runs=1, entries=entries)
    (row,) = found["rows"]
    assert row["n_demonstrations"] == 8
    assert len(row["steps"]) == 1
    assert (tmp_path / "run" / "report.md").exists()
