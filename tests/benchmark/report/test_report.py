import json
import os
from pathlib import Path

import numpy as np
import pytest
from fake_results import (
    EXPERT,
    FULL,
    HIT,
    ROBUST,
    SMALL,
    STUCK,
    SUCCESS,
    UNREACHABLE,
    VOID,
    random_results,
    results_of,
)

from dressing_sim.benchmark.analysis.claims import judge_claims
from dressing_sim.benchmark.analysis.comparisons import comparisons, rows_by_entry
from dressing_sim.benchmark.analysis.paper_table import next_to_paper
from dressing_sim.benchmark.analysis.statistics import rate_interval_over_sets, wilson_interval
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report import markdown_table, summarise, table, write_report
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.report.text import headline
from dressing_sim.benchmark.studies.success import PROTOCOLS
from dressing_sim.errors import InvalidInputError
from dressing_sim.provenance import versions

FOLDER = Path("results/run")
OUTCOMES = [
    [SUCCESS, SUCCESS, SUCCESS, SUCCESS, VOID],
    [SUCCESS, STUCK, HIT, UNREACHABLE, VOID],
    [VOID],
]
RESULTS = results_of(SMALL, OUTCOMES)
COMMAND = "dressing-sim evaluate --seed 4"


@pytest.fixture
def summary():
    return summarise(SMALL, RESULTS, {"seed": 4})


@pytest.fixture(scope="module")
def full():
    results = random_results(FULL, 50)
    return results, summarise(FULL, results, {"seed": 4})


def test_a_row_counts_episodes_successes_and_reasons_and_void_ones_apart(summary):
    low, high = wilson_interval(1, 4)
    assert summary["rows"][1] == {
        "policy": "tp-gmm",
        "demonstrations": "case_a",
        "variation": [],
        "n_episodes": 4,
        "n_success": 1,
        "pc_success": 25.0,
        "pc_success_ci95": [100 * low, 100 * high],
        "failures": {"ik_unreachable": 1, "stuck": 1, "hit": 1, "over_strain": 1},
        "n_void": 1,
        "inputs": "frames",
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
    assert summary["config"] == {
        "protocol": "small",
        "suite": "five",
        "demonstration_sets": 1,
        "seed": 4,
    }
    assert [row["policy"] for row in summary["rows"]] == ["expert", "tp-gmm", "mine"]


def test_a_row_that_learned_has_a_rate_for_each_set_and_they_add_up(full):
    results, summary = full
    assert "sets" not in summary["rows"][0]
    for entry, row in zip(FULL.entries[1:], summary["rows"][1:], strict=True):
        assert [one["demonstration_set"] for one in row["sets"]] == [0, 1, 2, 3, 4]
        for name in ("n_episodes", "n_success"):
            assert sum(one[name] for one in row["sets"]) == row[name]
        third = [r.outcome for r in results if r.entry == entry and r.demonstration_set == 3]
        assert row["sets"][3]["n_success"] == sum(outcome.success for outcome in third)


def test_a_row_that_learned_from_several_sets_has_an_interval_for_others_too(full):
    results, summary = full
    measured = rows_by_entry(results)
    heading, *lines = table(summary)
    place = heading.index("over sets")
    for row, line, entry in zip(summary["rows"], lines, FULL.entries, strict=True):
        expected = rate_interval_over_sets(measured[entry], np.random.default_rng(0))
        if entry.demonstrations is None:
            assert "pc_success_ci95_sets" not in row
            assert line[place] == "-"
        else:
            low, high = 100.0 * np.array(expected)
            assert row["pc_success_ci95_sets"] == pytest.approx([low, high])
            assert line[place] == f"{low:.0f} - {high:.0f} %"


def test_the_headline_of_a_run_under_variation_alone_is_of_its_rows():
    protocol = Protocol("p", "s", (Entry("tp-gmm", "case_a", ("friction",)),))
    text = headline(protocol, summarise(protocol, results_of(protocol, [[SUCCESS, HIT]]), {}))
    assert "1 of 2 arms" in text


def test_one_set_is_not_told_apart(summary):
    assert all("sets" not in row for row in summary["rows"])


def test_rows_of_one_policy_under_different_variation_are_kept_apart():
    results = results_of(ROBUST, [[SUCCESS], [HIT], [VOID]])
    rows = summarise(ROBUST, results, {})["rows"]
    assert [row["variation"] for row in rows] == [[], ["friction"], ["arm", "grasp"]]
    assert [row["n_success"] for row in rows] == [1, 0, 0]
    assert [row["n_void"] for row in rows] == [0, 0, 1]


def test_comparisons_and_claims_are_part_of_a_summary(full):
    results, summary = full
    again = comparisons(results, np.random.default_rng(0))
    assert summary["comparisons"] == again
    claims = judge_claims(results, np.random.default_rng(0))
    assert summary["claims"] == [claim.to_dict() for claim in claims]
    # The same comparison reads the same in both.
    intervals = {
        (*(pair[side][key] for side in "ab" for key in ("policy", "demonstrations")),): pair
        for pair in again
    }
    found = 0
    for claim in summary["claims"]:
        rows = claim["numbers"].get("rows", ())
        key = tuple(row[key] for row in rows for key in ("policy", "demonstrations"))
        if key in intervals and "n_candidates" not in claim["numbers"]:
            found += 1
            assert claim["numbers"]["pc_difference_ci95"] == intervals[key]["pc_difference_ci95"]
    assert found > 5
    assert summary["comparisons"]
    assert summary["claims"]


def test_a_summary_is_plain_and_the_same_in_whatever_order_episodes_ended(full):
    results, summary = full
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary
    again = summarise(FULL, results[::-1], {"seed": 4})
    assert json.dumps(again) == json.dumps(summary)


def test_the_table_is_for_people(summary):
    heading, expert, learned, broken = table(summary)
    assert len({len(line) for line in (heading, expert, learned, broken)}) == 1
    assert "varied" not in heading
    assert expert[:4] == ["expert", "-", "4 / 4", "100 %"]
    assert learned[2:5] == ["1 / 4", "25 %", "5 - 70 %"]
    assert learned[5] == "ik_unreachable 1, stuck 1, hit 1, over_strain 1, 1 void"
    assert broken[3] == "-"
    assert expert[5] == "1 void"


def test_the_table_has_a_column_for_variation_if_there_is_any():
    results = results_of(ROBUST, [[SUCCESS], [HIT], [HIT]])
    heading, *lines = table(summarise(ROBUST, results, {}))
    column = heading.index("varied")
    assert [line[column] for line in lines] == ["-", "friction", "arm, grasp"]
    assert {len(line) for line in lines} == {len(heading)}


def test_a_markdown_table_has_a_line_a_row():
    assert markdown_table([["a", "b"], ["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_text_with_bars_and_line_ends_stays_in_its_cell():
    text = markdown_table([["a"], ["x | y\nz"]])
    assert text.splitlines()[2:] == ["| x \\| y z |"]


def test_the_headline_names_the_best_that_learned_and_the_expert(summary):
    text = headline(SMALL, summary)
    assert "tp-gmm on case_a did best: 1 of 4 arms (25 %" in text
    assert "expert, who sees the whole arm, dressed 4 of 4 arms (100 %" in text


def test_the_headline_names_all_that_are_best():
    protocol = Protocol("p", "s", (Entry("a", "x"), Entry("b", "x"), Entry("c", "x")))
    tied = summarise(protocol, results_of(protocol, [[SUCCESS], [HIT], [SUCCESS]]), {})
    assert "a on x and c on x did equally well: 100 % dressed" in headline(protocol, tied)
    equal = summarise(protocol, results_of(protocol, [[HIT], [HIT], [HIT]]), {})
    assert "all did equally well: 0 % dressed" in headline(protocol, equal)
    void = summarise(protocol, results_of(protocol, [[VOID], [VOID], [VOID]]), {})
    assert headline(protocol, void) == "No episode could be judged."


def test_few_episodes_are_listed_with_how_to_get_them_again(summary):
    text = markdown(FOLDER, SMALL, RESULTS, summary, COMMAND)
    lines = text.splitlines()
    assert f"    {COMMAND}" in lines
    assert markdown_table(table(summary)) in text
    assert (
        "| 6 | tp-gmm | case_a | arm1 | 10 deg | stuck, over_strain | 1.93 | 0.08 | 1.25 N |"
        in lines
    )
    assert "| 8 | tp-gmm | case_a | arm3 | 30 deg | ik_unreachable | - | - | - |" in lines
    assert f"| 4 | expert | - | arm4 | 40 deg | void: {VOID.invalid} | - | - | - |" in lines
    assert '"seed": 4' in text
    assert "mujoco 4.0" in text


def test_many_episodes_are_listed_by_posture(full):
    results, summary = full
    lines = markdown(FOLDER, FULL, results, summary, COMMAND).splitlines()
    group = [r.outcome for r in results if r.posture.name == "val7"]
    valid = [outcome for outcome in group if outcome.invalid is None]
    (line,) = [line for line in lines if line.startswith("| val7 |") and "replay" not in line]
    assert f"| {sum(outcome.success for outcome in valid)} / {len(valid)} |" in line
    assert len([line for line in lines if line.startswith("| val")]) <= 50 + 6
    assert "## Episodes" not in lines


def test_claims_comparisons_sets_and_hard_postures_are_in_the_report(full):
    results, summary = full
    text = markdown(FOLDER, FULL, results, summary, COMMAND)
    for claim in summary["claims"]:
        assert f"**{claim['verdict']}**: {claim['statement']}. {claim['detail']}" in text
    for pair in summary["comparisons"]:
        low, high = pair["pc_difference_ci95"]
        difference = f"{pair['pc_difference']:+.3g} | {low:+.0f} to {high:+.0f}"
        counts = f"| {pair['n_pairs']} | {pair['n_only_a']} | {pair['n_only_b']} |"
        assert f"{counts} {difference} |" in text
    sets = " | ".join(f"{s['n_success']} / {s['n_episodes']}" for s in summary["rows"][1]["sets"])
    assert f"| tp-gmm on case_a | {sets} |" in text
    assert text.count("`dressing-sim replay results/run ") == 6


def test_only_the_papers_protocol_is_put_next_to_the_papers_table(full):
    paper = PROTOCOLS["paper"]
    results = random_results(paper, 5)
    summary = summarise(paper, results, {})
    cells = next_to_paper(summary["rows"])
    assert markdown_table(cells) in markdown(FOLDER, paper, results, summary, COMMAND)
    assert "the paper's table" not in markdown(FOLDER, FULL, *full, COMMAND)


def test_a_pair_without_a_common_episode_has_no_difference():
    protocol = Protocol("p", "s", (Entry("tp-gmm-rf", "case_a"), Entry("tp-gmm", "case_a")))
    results = results_of(protocol, [[SUCCESS], [VOID]])
    summary = summarise(protocol, results, {})
    text = markdown(FOLDER, protocol, results, summary, COMMAND)
    assert "| tp-gmm-rf on case_a | tp-gmm on case_a | 0 | 0 | 0 | - | -100 to +100 |" in text


def test_a_report_is_three_files(tmp_path, summary):
    folder = tmp_path / "a" / "b"
    write_report(folder, SMALL, RESULTS, summary, COMMAND)
    names = sorted(path.name for path in folder.iterdir())
    assert names == ["report.html", "report.md", "summary.json"]
    assert json.loads((folder / "summary.json").read_text()) == summary
    assert (folder / "report.md").read_text().startswith("# Protocol small on suite five")
    assert "<h1>Protocol small on suite five</h1>" in (folder / "report.html").read_text()


def test_pictures_go_into_the_page(tmp_path, summary):
    write_report(tmp_path, SMALL, RESULTS, summary, COMMAND, lambda result: b"picture")
    assert 'src="data:image/png;base64,cGljdHVyZQ=="' in (tmp_path / "report.html").read_text()


def test_the_summary_tells_that_a_run_is_finished_so_it_comes_last(tmp_path, summary, monkeypatch):
    order = []
    replace = os.replace

    def noted(source, target, **options):
        order.append(Path(target).name)
        replace(source, target, **options)

    monkeypatch.setattr(os, "replace", noted)
    write_report(tmp_path, SMALL, RESULTS, summary, COMMAND)
    assert order[-1] == "summary.json"


def test_a_report_that_cannot_be_written_leaves_the_old_one(tmp_path, summary, monkeypatch):
    write_report(tmp_path, SMALL, RESULTS, summary, "before")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}

    def fails(*_arguments):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises((OSError, InvalidInputError), match="disk full"):
        write_report(tmp_path, SMALL, RESULTS[:1], summary, "after")
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_the_expert_alone_is_a_report():
    protocol = Protocol("p", "s", (EXPERT,))
    results = results_of(protocol, [[SUCCESS]])
    summary = summarise(protocol, results, {})
    assert (summary["comparisons"], summary["claims"]) == ([], [])
    assert "hardest" not in markdown(FOLDER, protocol, results, summary, COMMAND)


def test_a_table_says_the_class_of_inputs_once_a_policy_that_learned_has_another(summary):
    assert "inputs" not in table(summary)[0]
    rows = [
        {**row, "inputs": "elbow" if row["policy"] == "mine" else "frames"}
        for row in summary["rows"]
    ]
    cells = table({**summary, "rows": rows})
    place = cells[0].index("inputs")
    assert [line[place] for line in cells[1:]] == [row["inputs"] for row in rows]
    assert "elbow" in [line[place] for line in cells[1:]]
    expert = [{**row, "inputs": "frames"} for row in rows]
    expert[0]["inputs"] = "posture"
    assert "inputs" not in table({**summary, "rows": expert})[0]
