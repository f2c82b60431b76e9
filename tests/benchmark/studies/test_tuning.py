from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.benchmark.studies.tuning import (
    ROWS,
    Screening,
    Tuning,
    screen,
    shares_table,
    tuning_plan,
)
from dressing_sim.benchmark.studies.tuning_paths import (
    operator_demonstrations,
    path_metrics,
    steady_path,
    tried,
)
from dressing_sim.errors import PolicyError
from dressing_sim.suites.suites import load_suite

POSTURES = load_suite("paper5")
CASE_A = load_suite("case_a")


@pytest.mark.parametrize("posture", POSTURES, ids=lambda posture: posture.name)
def test_the_operators_own_path_would_dress(posture):
    expert = steady_path(posture)
    metrics = path_metrics(expert, expert, posture)
    assert metrics.end_gap == metrics.largest_gap == metrics.mean_gap == 0.0
    assert metrics.outside == metrics.outside_expert
    assert metrics.dresses


def test_a_path_that_stops_on_the_way_does_not_end(posture):
    expert = steady_path(posture)
    metrics = path_metrics(expert[: len(expert) // 2], expert, posture)
    assert not metrics.ends
    assert not metrics.dresses


def test_a_path_through_the_arm_has_no_clearance(posture):
    through = np.linspace(posture.wrist, posture.shoulder, 200)
    metrics = path_metrics(through, steady_path(posture), posture)
    assert metrics.clearance == pytest.approx(-posture.arm_size.upper_arm_radius, abs=1e-3)
    assert not metrics.dresses


def test_a_path_across_the_inside_of_a_bent_elbow_does_not_follow():
    bent = POSTURES[-1]
    expert = steady_path(bent)
    straight = np.linspace(expert[0], expert[-1], 300)
    metrics = path_metrics(straight, expert, bent)
    assert metrics.ends
    assert metrics.outside < metrics.outside_expert
    assert metrics.largest_gap > 0.05
    assert not metrics.dresses


def test_a_path_scores_by_whether_it_dresses_and_by_its_smallest_margin(posture):
    expert = steady_path(posture)
    up = np.linspace(0.0, 1.0, len(expert))[:, None] * [0.0, 0.0, 1.0]
    scores = [
        path_metrics(expert + end * up, expert, posture) for end in (0.0, 0.04, 0.079, 0.081, 0.5)
    ]
    values = [metrics.score for metrics in scores]
    assert values == sorted(values, reverse=True)
    assert [metrics.dresses for metrics in scores[2:4]] == [True, False]
    assert values[2] - values[3] == pytest.approx(0.5, abs=0.02)
    assert values[-1] == 0.0
    assert 0.5 < values[0] <= 1.0


class Unsure:
    dt = 0.1

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        raise PolicyError("does not know")


def test_a_policy_without_an_answer_stays_where_it_is():
    ((_, path, expert, metrics),) = tried(f"{__name__}:Unsure", CASE_A, POSTURES[:1], 0)
    np.testing.assert_array_equal(path, expert[:1])
    assert not metrics.dresses


def test_metrics_do_not_change_with_the_sampling_of_the_path(posture):
    expert = steady_path(posture)
    path = np.add(expert, [0.0, 0.0, 0.03])
    fine, coarse = path_metrics(path, expert, posture), path_metrics(path[::3], expert, posture)
    assert fine.largest_gap == pytest.approx(coarse.largest_gap, abs=0.005)
    assert fine.clearance == pytest.approx(coarse.clearance, abs=0.005)


def test_demonstrations_vary_with_the_seed_and_repeat():
    one, again, other = (operator_demonstrations(CASE_A, seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one[0].positions, again[0].positions)
    assert one[0].positions.shape != other[0].positions.shape


def test_every_posture_is_asked_for_with_every_set():
    job = Screening(0, Entry("tp-gmm", "case_a"), 0)
    first = screen(job, CASE_A, POSTURES[:2])
    second = screen(replace(job, demonstration_set=1), CASE_A, POSTURES[:2])
    assert len(first.paths) == len(second.paths) == 2
    assert first.paths[0] != second.paths[0]


def test_another_seed_of_the_plan_demonstrates_otherwise():
    job = Screening(0, Entry("tp-gmm", "case_a"), 0)
    first, same, other = (screen(job, CASE_A, POSTURES[:1], seed) for seed in (0, 0, 5))
    assert first == same != other
    called = {
        seed: [
            arguments
            for _, arguments in Tuning().calls(
                SimpleNamespace(plan=tuning_plan("paper5", 1, ("",), seed)), [job], None, None
            )[1]
        ]
        for seed in (0, 5)
    }
    assert [calls[0][-1] for calls in called.values()] == [0, 5]


def test_every_row_is_screened_under_every_change():
    plan = tuning_plan("paper5", 2, ("", "end_radius=0"))
    jobs = Tuning().jobs(plan)
    assert [job.index for job in jobs] == list(range(2 * 2 * len(ROWS)))
    assert [job.demonstration_set for job in jobs[:3]] == [0, 1, 0]
    assert jobs[-1].entry == Entry("tp-gmm?end_radius=0", "baseline7")


def test_the_table_has_a_line_for_each_change(tmp_path):
    plan = tuning_plan("paper5", 1, ("", "end_radius=0"))
    entries = tuple(e for e in plan.protocol.entries if e.stem == "tp-gmm")
    plan = replace(plan, protocol=replace(plan.protocol, entries=entries))
    with Processes(1) as workers:
        finished = run_study(Tuning(), plan, workers, tmp_path / "run")
    heading, chosen, creeping = shares_table(finished.summary["rows"])
    assert heading == ["hyper-parameters", "tp-gmm case_a", "tp-gmm case_b", "tp-gmm baseline7"]
    assert chosen[0] == "as chosen"
    assert creeping == ["`end_radius=0`", *["0 (0)"] * 3]
    assert "| `end_radius=0` | 0 (0) |" in (tmp_path / "run" / "report.md").read_text()
