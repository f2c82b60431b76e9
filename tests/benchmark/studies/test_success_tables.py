import json
import re
from dataclasses import replace

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

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.statistics import contrast, rate_interval_over_sets
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report.document import tabulate
from dressing_sim.benchmark.studies.success_changes import (
    HYPERPARAMETERS,
    STYLE,
    VARIATION,
    side_by_side,
)
from dressing_sim.benchmark.studies.success_summary import summarise
from dressing_sim.benchmark.studies.success_tables import (
    PAIRS,
    listing,
    sets_table,
    table,
    void_table,
)

FLOOR, RADIUS = "position_floor=1e-3&relative_floor=true", "end_radius=0"
COLUMNS = {
    "tp-gmm-rf, case_b": Entry("tp-gmm-rf", "case_b"),
    "tp-gmm, case_a": Entry("tp-gmm", "case_a"),
    "tp-gmm, case_b": Entry("tp-gmm", "case_b"),
    "tp-gmm, case_a, friction and arm varied": Entry("tp-gmm", "case_a", ("friction", "arm")),
    "expert": Entry("expert"),
}


def changed(entry, text):
    return replace(entry, policy=f"{entry.policy}?{text}" if text else entry.policy)


# Neither all rows with every setting, nor those as chosen first.
PROTOCOL = Protocol(
    "settings",
    "val50",
    (
        changed(COLUMNS["tp-gmm-rf, case_b"], RADIUS),
        *COLUMNS.values(),
        *(
            changed(entry, FLOOR)
            for name, entry in COLUMNS.items()
            if name not in ("tp-gmm, case_b", "expert")
        ),
        changed(COLUMNS["tp-gmm, case_a"], RADIUS),
    ),
    demonstration_sets=5,
)
LINES = {"as chosen": "", RADIUS: RADIUS, FLOOR: FLOOR}


@pytest.fixture(scope="module", params=range(5))
def measured(request):
    results = random_results(PROTOCOL, 30, seed=request.param)
    return results, summarise(PROTOCOL, results, {})


def cells_by_place(summary):
    heading, *lines = side_by_side(summary, HYPERPARAMETERS)
    return {
        (line[0], column): cell
        for line in lines
        for column, cell in zip(heading[1:], line[1:], strict=True)
    }


def test_lines_and_columns_come_as_they_first_appear_but_as_chosen_is_the_first(measured):
    heading, *lines = side_by_side(measured[1], HYPERPARAMETERS)
    assert heading == ["settings", *COLUMNS]
    assert [line[0] for line in lines] == list(LINES)


def test_every_rate_is_in_its_cell_and_what_was_not_run_is_a_dash(measured):
    _, summary = measured
    rates = dict(zip(PROTOCOL.entries, summary["rows"], strict=True))
    cells = cells_by_place(summary)
    assert len(cells) == len(LINES) * len(COLUMNS)
    for (line, column), cell in cells.items():
        entry = changed(COLUMNS[column], LINES[line])
        if entry in rates:
            assert cell.partition(" (")[0] == f"{rates[entry]['pc_success']:.3g} %"
        else:
            assert cell == "-"
    assert sum(cell != "-" for cell in cells.values()) == len(PROTOCOL.entries)


def test_differences_are_those_over_the_episodes_that_both_rows_have(measured):
    results, summary = measured
    rows = EpisodeTable.of(results).rows
    for (line, column), cell in cells_by_place(summary).items():
        told = re.fullmatch(r"[\d.]+ % \(([+-][\d.]+), ([+-]\d+) to ([+-]\d+)\)", cell)
        assert (told is not None) == (line != "as chosen" and cell != "-")
        if told is None:
            continue
        a, b = rows[changed(COLUMNS[column], LINES[line])], rows[COLUMNS[column]]
        pairs = [(a[key], b[key]) for key in a if a[key] is not None and b[key] is not None]
        difference, low, high = map(float, told.groups())
        expected = 100.0 * np.mean([int(x) - int(y) for x, y in pairs])
        assert difference == pytest.approx(expected, abs=0.05)
        # Another seed of the bootstrap may move a bound by an episode: a 30th, or more with void.
        again = contrast((a, b), (1, -1), np.random.default_rng(7)).interval
        assert (low, high) == pytest.approx([100.0 * bound for bound in again], abs=5.0)
        assert low <= difference <= high


def test_a_cell_reads_as_people_write_it():
    protocol = Protocol("p", "s", (Entry("a", "x"), Entry("a?b=1", "x")))
    results = results_of(protocol, [[SUCCESS, HIT, HIT, HIT] * 3, [SUCCESS] * 12])
    summary = summarise(protocol, results, {})
    (pair,) = summary["comparisons"]
    low, high = pair["pc_difference_ci95"]
    assert side_by_side(summary, HYPERPARAMETERS) == [
        ["settings", "a, x"],
        ["as chosen", "25 %"],
        ["b=1", f"100 % (+75, {low:+.0f} to {high:+.0f})"],
    ]


def test_void_rows_have_no_rate_and_nothing_to_compare_with():
    protocol = Protocol("p", "s", (Entry("a", "x"), Entry("a?b=1", "x"), Entry("a?b=2", "x")))
    results = results_of(protocol, [[VOID] * 2, [SUCCESS, HIT], [VOID] * 2])
    lines = side_by_side(summarise(protocol, results, {}), HYPERPARAMETERS)[1:]
    assert lines == [["as chosen", "-"], ["b=1", "50 %"], ["b=2", "-"]]


def test_settings_without_their_row_as_chosen_are_compared_with_nothing():
    protocol = Protocol("p", "s", (Entry("a?b=1", "x"), Entry("a?b=1", "y")))
    results = results_of(protocol, [[SUCCESS, HIT], [SUCCESS, SUCCESS]])
    lines = side_by_side(summarise(protocol, results, {}), HYPERPARAMETERS)[1:]
    assert lines == [["b=1", "50 %", "100 %"]]


def test_without_changes_there_is_no_table():
    summary = summarise(FULL, random_results(FULL, 10), {})
    assert side_by_side(summary, HYPERPARAMETERS) == side_by_side(summary, VARIATION) == []


def test_rows_of_other_operators_stand_below_the_usual_one():
    usual, quick = Entry("a", "x"), Entry("a", "x?speed=0.16&dt=0.05")
    protocol = Protocol("p", "s", (quick, usual, Entry("b", "y")))
    results = results_of(protocol, [[HIT] * 8, [SUCCESS, HIT] * 4, [SUCCESS] * 8])
    summary = summarise(protocol, results, {})
    (pair,) = summary["comparisons"]
    low, high = pair["pc_difference_ci95"]
    assert side_by_side(summary, STYLE) == [
        ["operator", "a, x", "b, y"],
        ["the usual", "50 %", "100 %"],
        ["speed=0.16&dt=0.05", f"0 % (-50, {low:+.0f} to {high:+.0f})", "-"],
    ]
    del summary["rows"][0]
    assert side_by_side(summary, STYLE) == []


def test_rows_under_variation_stand_below_the_nominal_world():
    nominal, varied = Entry("a?b=1", "x"), Entry("a?b=1", "x", ("friction", "arm"))
    protocol = Protocol("p", "s", (varied, nominal, Entry("expert", None, ("arm",))))
    results = results_of(protocol, [[HIT] * 8, [SUCCESS, HIT] * 4, [SUCCESS] * 8])
    summary = summarise(protocol, results, {})
    (pair,) = summary["comparisons"]
    low, high = pair["pc_difference_ci95"]
    assert side_by_side(summary, VARIATION) == [
        ["varied", "a?b=1, x", "expert"],
        ["nothing", "50 %", "-"],
        ["friction and arm", f"0 % (-50, {low:+.0f} to {high:+.0f})", "-"],
        ["arm", "-", "100 %"],
    ]


def test_a_summary_is_the_same_after_it_was_a_file(measured):
    _, summary = measured
    assert side_by_side(json.loads(json.dumps(summary)), HYPERPARAMETERS) == side_by_side(
        summary, HYPERPARAMETERS
    )


OUTCOMES = [
    [SUCCESS, SUCCESS, SUCCESS, SUCCESS, VOID],
    [SUCCESS, STUCK, HIT, UNREACHABLE, VOID],
    [VOID],
]
RESULTS = results_of(SMALL, OUTCOMES)


@pytest.fixture(scope="module")
def full():
    results = random_results(FULL, 50)
    return results, summarise(FULL, results, {})


def test_the_table_is_for_people():
    heading, expert, learned, broken = table(summarise(SMALL, RESULTS, {}))
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


def test_the_table_has_intervals_for_other_demonstrations_where_there_are_several_sets(full):
    results, summary = full
    measured = EpisodeTable.of(results).rows
    heading, *lines = table(summary)
    place = heading.index("over sets")
    for line, entry in zip(lines, FULL.entries, strict=True):
        if entry == EXPERT:
            assert line[place] == "-"
        else:
            expected = rate_interval_over_sets(measured[entry], np.random.default_rng(0))
            low, high = 100.0 * np.array(expected)
            assert line[place] == f"{low:.0f} - {high:.0f} %"


def test_rates_of_each_set_stand_side_by_side(full):
    _, summary = full
    heading, *lines = sets_table(summary)
    assert heading == ["policy", "shown", *(f"set {i}" for i in range(5))]
    assert len(lines) == len(FULL.entries) - 1
    rates = [f"{s['n_success']} / {s['n_episodes']}" for s in summary["rows"][1]["sets"]]
    assert lines[0] == ["tp-gmm", "case_a", *rates]
    assert len(sets_table(summarise(SMALL, RESULTS, {}))) == 1


def test_every_comparison_is_a_line(full):
    _, summary = full
    lines = tabulate(summary["comparisons"], PAIRS)[1:]
    for pair, line in zip(summary["comparisons"], lines, strict=True):
        low, high = pair["pc_difference_ci95"]
        assert line[2:7] == [
            str(pair["n_pairs"]),
            str(pair["n_only_a"]),
            str(pair["n_only_b"]),
            f"{pair['pc_difference']:+.3g}",
            f"{low:+.0f} to {high:+.0f}",
        ]


def test_a_pair_without_a_common_episode_has_no_difference():
    protocol = Protocol("p", "s", (Entry("tp-gmm-rf", "case_a"), Entry("tp-gmm", "case_a")))
    summary = summarise(protocol, results_of(protocol, [[SUCCESS], [VOID]]), {})
    assert tabulate(summary["comparisons"], PAIRS)[1][:7] == [
        "tp-gmm-rf on case_a",
        "tp-gmm on case_a",
        *("0", "0", "0", "-", "-100 to +100"),
    ]


def test_few_episodes_are_listed_one_by_one():
    title, cells = listing(EpisodeTable.of(RESULTS))
    assert title == "Episodes"
    strained = ["stuck, over_strain", "1.93", "0.08", "1.25 N"]
    assert ["6", "tp-gmm", "case_a", "arm1", "10 deg", *strained] in cells
    assert ["8", "tp-gmm", "case_a", "arm3", "30 deg", "ik_unreachable", "-", "-", "-"] in cells
    assert ["4", "expert", "-", "arm4", "40 deg", f"void: {VOID.invalid}", "-", "-", "-"] in cells


def test_many_episodes_are_listed_by_posture(full):
    results, _ = full
    title, cells = listing(EpisodeTable.of(results))
    assert title == "Postures"
    assert len(cells) == 51
    group = [r.outcome for r in results if r.posture.name == "val7"]
    valid = [outcome for outcome in group if outcome.invalid is None]
    (line,) = [line for line in cells if line[0] == "val7"]
    assert line[2] == f"{sum(outcome.success for outcome in valid)} / {len(valid)}"


def test_void_episodes_are_listed_with_why():
    assert void_table(EpisodeTable.of(RESULTS))[1:] == [
        ["4", "expert", "arm4", VOID.invalid],
        ["9", "tp-gmm on case_a", "arm4", VOID.invalid],
        ["10", "mine on case_b", "arm0", VOID.invalid],
    ]


def test_a_table_says_the_class_of_inputs_once_a_policy_that_learned_has_another():
    summary = summarise(SMALL, RESULTS, {})
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
