import numpy as np
import pytest

from dressing_sim.benchmark.studies import screening
from dressing_sim.benchmark.studies.screening import (
    main,
    operator_demonstrations,
    path_figures,
    screen,
    steady_path,
)
from dressing_sim.suites.suites import load_suite

POSTURES = load_suite("paper5")


@pytest.mark.parametrize("posture", POSTURES, ids=lambda posture: posture.name)
def test_the_operators_own_path_would_dress(posture):
    expert = steady_path(posture)
    figures = path_figures(expert, expert, posture)
    assert figures.end_gap == figures.largest_gap == figures.mean_gap == 0.0
    assert figures.outside == figures.outside_expert
    assert figures.dresses


def test_a_path_that_stops_on_the_way_does_not_end(posture):
    expert = steady_path(posture)
    figures = path_figures(expert[: len(expert) // 2], expert, posture)
    assert not figures.ends
    assert not figures.dresses


def test_a_path_through_the_arm_has_no_clearance(posture):
    through = np.linspace(posture.wrist, posture.shoulder, 200)
    figures = path_figures(through, steady_path(posture), posture)
    assert figures.clearance == pytest.approx(-posture.arm_size.upper_arm_radius, abs=1e-3)
    assert not figures.dresses


def test_a_path_across_the_inside_of_a_bent_elbow_does_not_follow():
    bent = POSTURES[-1]
    expert = steady_path(bent)
    straight = np.linspace(expert[0], expert[-1], 300)
    figures = path_figures(straight, expert, bent)
    assert figures.ends
    assert figures.outside < figures.outside_expert
    assert figures.largest_gap > 0.05
    assert not figures.dresses


def test_figures_do_not_change_with_the_sampling_of_the_path(posture):
    expert = steady_path(posture)
    path = np.add(expert, [0.0, 0.0, 0.03])
    fine, coarse = path_figures(path, expert, posture), path_figures(path[::3], expert, posture)
    assert fine.largest_gap == pytest.approx(coarse.largest_gap, abs=0.005)
    assert fine.clearance == pytest.approx(coarse.clearance, abs=0.005)


def test_demonstrations_vary_with_the_seed_and_repeat():
    one, again, other = (operator_demonstrations("case_a", seed) for seed in (0, 0, 1))
    np.testing.assert_array_equal(one[0].positions, again[0].positions)
    assert one[0].positions.shape != other[0].positions.shape


def test_every_posture_is_asked_for_with_every_set():
    figures = screen("tp-gmm", "baseline7", POSTURES[:2], sets=2)
    assert len(figures) == 4
    assert figures[0] != figures[2]


def test_the_table_has_a_line_for_each_setting(monkeypatch, capsys):
    monkeypatch.setattr(screening, "ROWS", (("tp-gmm", "case_a"),))
    main("paper5", sets=1, settings=("", "end_radius=0"), full=True)
    table = capsys.readouterr().out.split("\n\n")[-1]
    assert "| default |" in table
    assert "| end_radius=0 | 0 (0) |" in table
