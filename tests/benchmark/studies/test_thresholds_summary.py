import json
import re
from dataclasses import replace
from functools import partial

import pytest
from fake_benchmark import fake_work
from fake_thresholds import episodes, fake_judge, turning

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.statistics import wilson_interval
from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.report.plots import STYLES
from dressing_sim.benchmark.report.write import write_report
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.thresholds import PROTOCOL, ThresholdStudy, summarise
from dressing_sim.benchmark.studies.thresholds_document import (
    headline,
    sensitivity_plot,
    sensitivity_table,
    thresholds_document,
    turned_table,
)
from dressing_sim.benchmark.studies.thresholds_verdicts import (
    FACTORS,
    NAMES,
    TOLERATED,
    VERDICTS,
    dress_and_judge,
)
from dressing_sim.cli import main
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.thresholds import Thresholds, threshold_sources
from dressing_sim.suites.suites import load_suite

RULES = Thresholds()
POSTURES = load_suite("val50")[:40]
PAIR = replace(PROTOCOL, entries=(Entry("expert"), Entry("tp-gmm", "case_a")))


def summary_of(successes, protocol=PAIR, void=()):
    results = episodes(successes, protocol, POSTURES, void)
    return summarise(protocol, results, RULES, {"seed": 0})


def threshold_of(summary, name):
    return next(t for t in summary["thresholds"] if t["name"] == name)


def test_rates_are_counted_by_threshold_factor_and_row():
    summary = summary_of(
        lambda row, name, factor: 30 - 10 * row + (2 if factor > 1 and name == "strain" else 0),
        void=((1, 0), (1, 39)),
    )
    assert [t["name"] for t in summary["thresholds"]] == list(NAMES)
    assert summary["n_void"] == 2
    assert summary["config"] == {"protocol": "thresholds", "suite": "val50", "seed": 0}
    first, second = threshold_of(summary, "strain")["rows"]
    assert (first["policy"], second["demonstrations"]) == ("expert", "case_a")
    assert first["n_success"] == [32 if factor > 1 else 30 for factor in FACTORS]
    assert second["n_episodes"] == 38
    assert second["n_success"] == [21 if factor > 1 else 19 for factor in FACTORS]
    assert second["pc_success"][0] == pytest.approx(50.0)
    low, high = wilson_interval(19, 38)
    assert second["pc_success_ci95"][0] == pytest.approx([100 * low, 100 * high])
    assert threshold_of(summary, "moment")["rows"][0]["n_success"] == [30] * len(FACTORS)
    assert all(t["acceptable"] and t["turned"] == [] for t in summary["thresholds"])
    assert json.loads(json.dumps(summary)) == summary


def test_the_summary_does_not_depend_on_the_order_of_results():
    results = episodes(
        lambda row, name, factor: 20 + row * round(10 * (factor - 1.05)), PAIR, POSTURES
    )
    straight = summarise(PAIR, results, RULES, {})
    assert summarise(PAIR, results[::-1], RULES, {}) == straight
    assert any(t["turned"] for t in straight["thresholds"])


@pytest.mark.parametrize(
    ("at", "lead", "factors", "beyond", "acceptable"),
    [
        (1.1, 15, [1.1, 1.2, 1.35, 1.5, 2.0], True, False),
        (1.35, 15, [1.35, 1.5, 2.0], True, True),
        (1.1, 1, [1.1, 1.2, 1.35, 1.5, 2.0], False, True),
        (3.0, 15, [], True, True),
    ],
)
def test_a_ranking_that_turns_near_the_threshold_is_not_acceptable(
    at, lead, factors, beyond, acceptable
):
    summary = summary_of(turning(at, lead))
    found = threshold_of(summary, "strain")
    assert [turn["factor"] for turn in found["turned"]] == factors
    assert all(turn["beyond_intervals"] == beyond for turn in found["turned"])
    assert all(turn["above"]["policy"] == "expert" for turn in found["turned"])
    for turn in found["turned"]:
        assert turn["before"]["pc_difference"] == -turn["after"]["pc_difference"] > 0
    assert found["acceptable"] == acceptable
    assert all(t["acceptable"] for t in summary["thresholds"] if t["name"] != "strain")
    assert ("strain" in headline(summary)) == (not acceptable)


def test_rows_that_become_equal_have_not_turned():
    summary = summary_of(lambda row, name, factor: 20 + (10 if row == 0 and factor >= 1 else 0))
    assert all(t["turned"] == [] for t in summary["thresholds"])


def test_a_turn_must_be_beyond_the_intervals_before_and_after():
    def successes(row, name, factor):
        return 20 + ((1 if factor <= 1 else 0) if row == 0 else (0 if factor <= 1 else 15))

    found = threshold_of(summary_of(successes), "moment")
    assert found["turned"]
    assert found["acceptable"]
    pair = found["turned"][0]
    assert pair["before"]["pc_difference_ci95"][0] < 0 > pair["after"]["pc_difference_ci95"][1]


def test_rows_without_a_valid_episode_have_no_rate(tmp_path):
    void = tuple((1, column) for column in range(len(POSTURES)))
    summary = summary_of(lambda row, name, factor: 20, void=void)
    row = summary["thresholds"][0]["rows"][1]
    assert row["n_episodes"] == 0
    assert row["pc_success"] == [None] * len(FACTORS)
    write_report(tmp_path, thresholds_document(summary, "dressing-sim thresholds"), summary)
    assert "- / - / -" in (tmp_path / "report.md").read_text()


def test_every_threshold_is_documented():
    told = threshold_sources()
    assert tuple(told) == NAMES
    assert all(len(text) > 20 for text in told.values())
    units = {t["name"]: t["unit"] for t in summary_of(lambda *_: 20)["thresholds"]}
    assert units["gripper_distance"] == "m"
    assert units["grip_force"] == units["link_force"] == "N"
    assert units["armscye_s"] == "-"


def test_the_table_has_a_line_for_each_threshold_and_a_column_for_each_row():
    summary = summary_of(turning(1.1, 15))
    heading, *lines = sensitivity_table(summary, sources=True)
    assert [line[0] for line in lines] == list(NAMES)
    assert {len(line) for line in lines} == {len(heading)}
    strain = dict(zip(heading, lines[NAMES.index("strain")], strict=True))
    assert strain["value"] == f"{RULES.strain:g}"
    assert strain["expert"] == "87.5 / 87.5 / 50 %"
    assert strain["tp-gmm on case_a"] == "50 / 50 / 87.5 %"
    assert strain["ranking turned by 20 %"] == "yes"
    assert strain["meaning and source"] == threshold_sources()["strain"]
    assert len(sensitivity_table(summary)[0]) == len(heading) - 1
    assert len(turned_table(summary)) == 1 + 5


def test_a_ranking_that_turns_by_little_is_told_as_such():
    lines = sensitivity_table(summary_of(turning(1.1, 1)))
    assert {line[0]: line[-1] for line in lines}["strain"] == "within intervals"
    assert {line[0]: line[-1] for line in lines}["moment"] == "no"


def test_the_same_summary_makes_the_same_plot():
    summary = summary_of(turning(1.1, 15))
    first = sensitivity_plot(summary).svg
    assert first == sensitivity_plot(summary).svg
    assert first != sensitivity_plot(summary_of(turning(1.2, 15))).svg
    width = re.search(r'<svg[^>]* width="([0-9.]+)pt"', first)
    assert float(width[1]) == pytest.approx(270.0)  # 360 pixels


def test_more_rows_than_styles_are_drawn():
    entries = tuple(Entry(f"policy{i}", "case_a") for i in range(len(STYLES) + 1))
    protocol = replace(PAIR, entries=entries)
    assert "<svg" in sensitivity_plot(summary_of(lambda *_: 20, protocol=protocol)).svg


def test_the_report_is_written_whole(tmp_path):
    summary = summary_of(turning(1.1, 15))
    document = thresholds_document(summary, "dressing-sim thresholds --seed 0")
    write_report(tmp_path, document, summary)
    assert {file.name for file in tmp_path.iterdir()} == {
        "report.html",
        "report.md",
        "summary.json",
        "thresholds.svg",
    }
    assert json.loads((tmp_path / "summary.json").read_text()) == summary
    text = (tmp_path / "report.md").read_text()
    for part in ("dressing-sim thresholds --seed 0", "thresholds.svg", *NAMES):
        assert part in text
    for row in summary["thresholds"][0]["rows"]:
        assert label_of(row) in text


@pytest.fixture
def thresholds(monkeypatch, tmp_path):
    """The command line without physics, on a protocol of so many postures."""
    monkeypatch.chdir(tmp_path)

    def run(n_postures, *arguments):
        work = replace(fake_work(tmp_path), dress=partial(fake_judge, n_postures))
        monkeypatch.setitem(STUDIES, "thresholds", partial(ThresholdStudy, work))
        main(["thresholds", "--workers", "1", *arguments])

    return run


def test_jobs_of_the_study_dress_and_judge():
    assert ThresholdStudy().work == Work(dress=dress_and_judge)


def test_the_command_measures_the_study_beyond_protective_stops(thresholds, tmp_path, capsys):
    thresholds(50, "--seed", "3", "--out", "here", "--json")
    summary = json.loads(capsys.readouterr().out)
    assert json.loads((tmp_path / "here" / "summary.json").read_text()) == summary
    plan = load_run(tmp_path / "here").plan
    assert plan.protocol == PROTOCOL
    assert plan.config == EpisodeConfig(protective_stop=False)
    assert plan.seed == summary["config"]["seed"] == 3
    assert [label_of(row) for row in summary["thresholds"][0]["rows"]] == [
        "expert",
        "tp-gmm on case_a",
        "tp-gmm-rf on case_a",
        "tp-gmm-rf-noise on case_a",
        "tp-gmm on case_b",
        "tp-gmm-rf-noise on case_b",
        "tp-gmm on baseline7",
    ]
    strain = threshold_of(summary, "strain")["rows"]
    assert strain[0]["n_success"] == [35 if factor < 1.1 else 20 for factor in FACTORS]


def test_the_command_takes_other_policies_and_postures(thresholds, tmp_path, capsys):
    thresholds(5, "--suite", "paper5", "--policies", "expert, tp-gmm")
    plan = load_run(tmp_path / "results/thresholds").plan
    assert plan.tested == make_plan(replace(PROTOCOL, suite="paper5")).tested
    suites = ("case_a", "case_b", "baseline7")
    assert plan.protocol.entries == (Entry("expert"), *(Entry("tp-gmm", name) for name in suites))
    assert "written to results/thresholds" in capsys.readouterr().out


def test_an_interrupted_study_says_how_to_continue(thresholds, monkeypatch, capsys):
    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(ThresholdStudy, "jobs", interrupted)
    with pytest.raises(SystemExit) as stopped:
        thresholds(50)
    assert stopped.value.code == 130
    assert "--resume" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["--suite", "nowhere"], "nowhere"),
        (["--policies", "nobody"], "nobody"),
        (["--workers", "0"], "workers is 0"),
        (["--seed", "-1"], "seed is -1"),
    ],
)
def test_a_wrong_option_is_one_line(thresholds, capsys, tmp_path, arguments, part):
    with pytest.raises(SystemExit) as stopped:
        thresholds(50, *arguments)
    assert stopped.value.code == 2
    error = capsys.readouterr().err
    assert part in error
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


def test_bootstrap_intervals_start_anew_for_each_pair():
    summary = summary_of(turning(1.1, 15))
    turns = threshold_of(summary, "strain")["turned"]
    assert len({json.dumps(turn["before"]) for turn in turns}) == 1
    assert TOLERATED == (0.8, 1.2)


def test_a_verdict_that_is_not_known_counts_neither_way_and_only_for_its_factor():
    results = episodes(lambda row, name, factor: 20, PAIR, POSTURES)
    del results[0].extra[VERDICTS]["strain"][f"{FACTORS[-1]:g}"]
    summary = summarise(PAIR, results, RULES, {})
    strain, force = (threshold_of(summary, name)["rows"][0] for name in ("strain", "grip_force"))
    assert strain["n_episodes"] == force["n_episodes"] == 40
    assert strain["n_success"] == [20] * (len(FACTORS) - 1) + [19]
    assert strain["pc_success"][-1] == pytest.approx(100.0 * 19 / 39)
    assert force["n_success"] == [20] * len(FACTORS)
    assert summary["n_void"] == 0
