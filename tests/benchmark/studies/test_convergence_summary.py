import json
from dataclasses import replace

import pytest
from fake_trials import CHOSEN, NAMES, STUCK, outcome, row, trials

from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.report.write import write_report
from dressing_sim.benchmark.studies.convergence import compare
from dressing_sim.benchmark.studies.convergence_document import (
    convergence_document,
    convergence_plot,
    headline,
    validation_table,
)
from dressing_sim.benchmark.studies.convergence_trials import (
    CONVERGED,
    DEFAULT,
    FINEST,
    PATHS,
    Trial,
    settings,
)
from dressing_sim.episode.outcome import Failure, Outcome


def test_agreement_is_the_share_of_equal_verdicts():
    summary = compare(trials(default={3: outcome(STUCK)}), CHOSEN)
    assert row(summary, DEFAULT)["n_agree"] == 36
    assert summary["agreement"] == pytest.approx(0.9)
    assert not summary["passed"]
    assert row(summary, "coarse mesh")["agreement"] == 1.0
    assert [(d["setting"], d["posture"], d["verdict"]) for d in summary["differing"]] == [
        (DEFAULT, "p3", "stuck")
    ] * 4
    assert compare(trials(20, default={3: outcome(STUCK)}), CHOSEN)["passed"]


def test_other_reasons_for_the_same_verdict_agree_but_are_counted():
    summary = compare(
        trials(finest={0: outcome(STUCK)}, default={0: outcome((Failure("hit", "x"),))}), CHOSEN
    )
    assert summary["agreement"] == 1.0
    assert row(summary, DEFAULT)["same_reasons"] == pytest.approx(0.9)


@pytest.mark.parametrize("name", ["default", "finest"])
def test_a_void_episode_disagrees(name):
    summary = compare(trials(**{name: {0: outcome(void="solver warning")}}), CHOSEN)
    assert summary["agreement"] == pytest.approx(0.9)
    assert row(summary, name)["n_void"] == 4


def test_differences_are_medians_and_costs_relative():
    slow = [
        replace(t, seconds=3.0, outcome=outcome(strain=0.12)) if t.setting == FINEST else t
        for t in trials()
    ]
    summary = compare(slow, CHOSEN)
    assert row(summary, DEFAULT)["difference_strain"] == pytest.approx(0.02)
    assert row(summary, DEFAULT)["difference_grip_force"] == pytest.approx(0.2)
    assert row(summary, FINEST)["relative_cost"] == pytest.approx(3.0)
    assert row(summary, DEFAULT)["relative_cost"] == 1.0


@pytest.mark.parametrize(("strain", "error"), [(0.112, 0.04), (0.13, 0.1)])
def test_figures_may_differ_by_a_twentieth_of_their_limits(strain, error):
    """Pull is ten times the strain here, and its limit 10 N, so strain with 0.3 decides."""
    off = dict.fromkeys(range(10), outcome(strain=strain))
    summary = compare(trials(default=off, tolerance=off), CHOSEN)
    assert summary["figure_error"] == pytest.approx(error)
    assert row(summary, "coarse mesh")["figure_error"] == 0.0
    assert summary["passed"] == (error < 0.05)
    text = headline(summary)
    assert f"by up to {100 * error:.1f} % of their limits, 5 % are allowed" in text


SOLVERS = {s.name: s for s in settings()}


@pytest.mark.parametrize(("error", "passed"), [(0.02, True), (0.2, False)])
def test_the_solver_s_error_is_that_of_nine_of_ten_dressings(error, passed):
    """Against a converged solver, on the same mesh and step alone; failures do not count."""
    names = (DEFAULT, FINEST, CONVERGED, "half step", "CG")
    off = {DEFAULT: error, "CG": 0.5, FINEST: 0.1, "half step": 0.3, CONVERGED: 0.0}
    made = []
    for name in names:
        for i in range(11):
            for kind in PATHS:
                # One of eleven is far off, two of another path fail.
                strain = 0.1 * (1.0 + (5.0 if i == 3 and name == DEFAULT else off[name]))
                failures = STUCK if kind == "too low" and i < 2 else ()
                scale = 7.0 if failures and name == DEFAULT else 1.0
                made.append(
                    Trial(len(made), name, kind, f"p{i}", outcome(failures, scale * strain), 1.0)
                )
    summary = compare(made, [SOLVERS[name] for name in names])
    assert row(summary, DEFAULT)["solver_error"] == pytest.approx(error)
    assert summary["solver_error"] == row(summary, DEFAULT)["solver_error"]
    assert row(summary, CONVERGED)["solver_error"] == 0.0
    assert row(summary, "CG")["solver_error"] == pytest.approx(0.5)
    assert row(summary, FINEST)["solver_error"] is None
    assert row(summary, "half step")["solver_error"] is None
    assert summary["passed"] == passed
    text = headline(summary)
    assert f"{100 * error:.1f} % off a converged one, 5 % are allowed" in text


def test_without_a_dressing_that_succeeds_the_solver_is_not_judged_and_nothing_passes():
    caught = {i: outcome(STUCK) for i in range(10)}
    summary = compare(trials(**{name.split()[0]: caught for name in NAMES}), CHOSEN)
    assert summary["agreement"] == 1.0
    assert {row["solver_error"] for row in summary["rows"]} == {None}
    assert summary["solver_error"] is None
    assert not summary["passed"]
    assert "could not be judged" in headline(summary)


def test_the_report_says_what_the_summary_says(tmp_path):
    made = trials(default={3: outcome(STUCK, strain=0.4)})
    summary = compare(made, CHOSEN)
    write_report(tmp_path, convergence_document(made, summary, "the command"), summary)
    assert json.loads((tmp_path / "summary.json").read_text()) == summary
    text = (tmp_path / "report.md").read_text()
    assert "do NOT agree" in text
    assert "36 / 40 (90 %)" in text
    assert text.count("| default | straight | p3 | stuck | success | 0.40 against 0.10 |") == 1
    assert [line[0] for line in validation_table(summary)[1:]] == [s.name for s in CHOSEN]
    assert "None." in markdown(convergence_document(trials(), compare(trials(), CHOSEN), ""))


def test_the_picture_is_the_same_each_time():
    made = trials()
    picture = convergence_plot(made).svg
    assert picture.startswith("<?xml")
    assert picture == convergence_plot(made).svg


def test_settings_under_which_all_is_void_have_no_figures_and_make_valid_json(tmp_path):
    void = dict.fromkeys(range(10), Outcome(False, invalid="solver warning"))
    made = trials(coarse=void)
    summary = compare(made, CHOSEN)
    assert row(summary, "coarse mesh")["difference_strain"] is None
    assert row(summary, "coarse mesh")["figure_error"] is None
    write_report(tmp_path, convergence_document(made, summary, ""), summary)

    def refuse(constant):
        pytest.fail(f"{constant} is no JSON")

    json.loads((tmp_path / "summary.json").read_text(), parse_constant=refuse)
    cells = next(line for line in validation_table(summary) if line[0] == "coarse mesh")
    assert cells[5:10] == ["-"] * 5
