import json
import os

import pytest

from dressing_sim.arm import Posture
from dressing_sim.benchmark.protocol import Entry, Protocol
from dressing_sim.benchmark.report import (
    episode_line,
    markdown,
    markdown_table,
    summarise,
    table,
    write_report,
)
from dressing_sim.benchmark.runner import EpisodeResult
from dressing_sim.benchmark.statistics import wilson_interval
from dressing_sim.demonstration import versions
from dressing_sim.errors import InvalidInputError
from dressing_sim.judge import Failure, Outcome

FIGURES = {"armscye_s": 1.93, "strain": 0.081, "grip_force": 1.25}
SUCCESS = Outcome(True, figures=FIGURES)
STUCK = Outcome(False, (Failure("stuck", "at the elbow", 3.0, 1.0),), FIGURES)
BOTH = Outcome(
    False, (Failure("stuck", "at the elbow"), Failure("over_strain", "too far")), FIGURES
)
UNREACHABLE = Outcome(False, (Failure("ik_unreachable", "far"),), {"tracking_error": 0.5})
VOID = Outcome(False, void="solver warning BADQACC at 1.20 s")

EXPERT, LEARNED, BROKEN = Entry("expert"), Entry("tp-gmm", "case_a"), Entry("mine", "case_b")
PROTOCOL = Protocol("paper", "paper5", (EXPERT, LEARNED, BROKEN))
OUTCOMES = {
    EXPERT: [SUCCESS, SUCCESS, SUCCESS, SUCCESS, VOID],
    LEARNED: [SUCCESS, STUCK, BOTH, UNREACHABLE, VOID],
    BROKEN: [VOID],
}
RESULTS = [
    EpisodeResult(entry, Posture(f"arm{i}", 70, 20, 30, 10.0 * i), 4, outcome)
    for entry, outcomes in OUTCOMES.items()
    for i, outcome in enumerate(outcomes)
]


@pytest.fixture
def summary():
    return summarise(PROTOCOL, RESULTS, {"seed": 4})


def test_a_row_counts_episodes_successes_and_reasons_and_void_ones_apart(summary):
    row = summary["rows"][1]
    low, high = wilson_interval(1, 4)
    assert row == {
        "policy": "tp-gmm",
        "demonstrations": "case_a",
        "n_episodes": 4,
        "n_success": 1,
        "pc_success": 25.0,
        "pc_success_ci95": [100 * low, 100 * high],
        "failures": {"ik_unreachable": 1, "stuck": 2, "over_strain": 1},
        "n_void": 1,
    }
    assert summary["rows"][0]["pc_success"] == 100.0
    assert summary["rows"][0]["failures"] == {}


def test_a_row_of_void_episodes_has_no_rate(summary):
    row = summary["rows"][2]
    assert (row["n_episodes"], row["n_success"], row["n_void"]) == (0, 0, 1)
    assert row["pc_success"] is None
    assert row["pc_success_ci95"] == [0.0, 100.0]


def test_a_summary_says_what_it_depends_on(summary):
    assert summary["versions"] == versions()
    assert summary["config"] == {"protocol": "paper", "suite": "paper5", "seed": 4}
    assert [row["policy"] for row in summary["rows"]] == ["expert", "tp-gmm", "mine"]


def test_a_line_holds_all_of_an_episode():
    result = RESULTS[6]
    line = episode_line(PROTOCOL, result)
    assert "\n" not in line
    values = json.loads(line)
    assert values["protocol"] == "paper"
    assert (values["policy"], values["demonstrations"]) == ("tp-gmm", "case_a")
    assert Posture.from_dict(values["posture"]) == result.posture
    assert values["seed"] == 4
    assert values["success"] is False
    assert values["failures"] == [
        {"reason": "stuck", "detail": "at the elbow", "time": 3.0, "s": 1.0}
    ]
    assert values["figures"] == FIGURES
    assert values["versions"] == versions()


def test_the_table_is_for_people(summary):
    heading, expert, learned, broken = table(summary)
    assert len({len(line) for line in (heading, expert, learned, broken)}) == 1
    assert expert[:4] == ["expert", "-", "4 / 4", "100 %"]
    assert learned[2:5] == ["1 / 4", "25 %", "5 - 70 %"]
    assert learned[5] == "ik_unreachable 1, stuck 2, over_strain 1, 1 void"
    assert broken[3] == "-"
    assert expert[5] == "1 void"


def test_a_markdown_table_has_a_line_a_row():
    assert markdown_table([["a", "b"], ["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_the_report_shows_every_episode_and_how_to_get_it_again(summary):
    text = markdown(PROTOCOL, RESULTS, summary, "dressing-sim evaluate --seed 4")
    lines = text.splitlines()
    assert "    dressing-sim evaluate --seed 4" in lines
    assert markdown_table(table(summary)) in text
    assert (
        "| tp-gmm | case_a | arm2 | 20 deg | stuck, over_strain | 1.93 | 0.08 | 1.25 N |" in lines
    )
    assert "| tp-gmm | case_a | arm3 | 30 deg | ik_unreachable | - | - | - |" in lines
    assert f"| expert | - | arm4 | 40 deg | void: {VOID.void} | - | - | - |" in lines
    assert '"seed": 4' in text
    assert "mujoco 4.0" in text


def test_a_run_leaves_three_files(tmp_path, summary):
    folder = tmp_path / "a" / "b"
    write_report(folder, PROTOCOL, RESULTS, summary, "dressing-sim evaluate")
    assert sorted(path.name for path in folder.iterdir()) == [
        "episodes.jsonl",
        "report.md",
        "summary.json",
    ]
    lines = (folder / "episodes.jsonl").read_text().splitlines()
    assert lines == [episode_line(PROTOCOL, result) for result in RESULTS]
    assert json.loads((folder / "summary.json").read_text()) == summary
    assert (folder / "report.md").read_text().startswith("# Protocol paper on suite paper5")


def test_a_report_that_cannot_be_written_leaves_the_old_one(tmp_path, summary, monkeypatch):
    write_report(tmp_path, PROTOCOL, RESULTS, summary, "before")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}

    def fails(*_arguments):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises((OSError, InvalidInputError), match="disk full"):
        write_report(tmp_path, PROTOCOL, RESULTS[:1], summary, "after")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before
