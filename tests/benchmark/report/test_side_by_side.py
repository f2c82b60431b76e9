import json
import re
import runpy
from dataclasses import replace
from itertools import chain
from pathlib import Path

import numpy as np
import pytest
from dressing_sim.benchmark.report.side_by_side import settings_table, side_by_side, variation_table
from fake_results import FULL, HIT, ROBUST, SMALL, SUCCESS, VOID, random_results, results_of

from dressing_sim.benchmark.analysis.comparisons import rows_by_entry
from dressing_sim.benchmark.analysis.statistics import contrast
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report import markdown_table, summarise
from dressing_sim.benchmark.report.html import page
from dressing_sim.benchmark.report.markdown import markdown

ROOT = Path(__file__).resolve().parents[3]
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
    heading, *lines = settings_table(summary)
    return {
        (line[0], column): cell
        for line in lines
        for column, cell in zip(heading[1:], line[1:], strict=True)
    }


def test_lines_and_columns_come_as_they_first_appear_but_as_chosen_is_the_first(measured):
    heading, *lines = settings_table(measured[1])
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
    rows = rows_by_entry(results)
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
    assert settings_table(summary) == [
        ["settings", "a, x"],
        ["as chosen", "25 %"],
        ["b=1", f"100 % (+75, {low:+.0f} to {high:+.0f})"],
    ]


def test_void_rows_have_no_rate_and_nothing_to_compare_with():
    protocol = Protocol("p", "s", (Entry("a", "x"), Entry("a?b=1", "x"), Entry("a?b=2", "x")))
    results = results_of(protocol, [[VOID] * 2, [SUCCESS, HIT], [VOID] * 2])
    lines = settings_table(summarise(protocol, results, {}))[1:]
    assert lines == [["as chosen", "-"], ["b=1", "50 %"], ["b=2", "-"]]


def test_settings_without_their_row_as_chosen_are_compared_with_nothing():
    protocol = Protocol("p", "s", (Entry("a?b=1", "x"), Entry("a?b=1", "y")))
    results = results_of(protocol, [[SUCCESS, HIT], [SUCCESS, SUCCESS]])
    lines = settings_table(summarise(protocol, results, {}))[1:]
    assert lines == [["b=1", "50 %", "100 %"]]


def test_without_changes_there_is_no_table():
    summary = summarise(FULL, random_results(FULL, 10), {})
    assert settings_table(summary) == variation_table(summary) == []
    assert side_by_side(summary) == []


def test_rows_under_variation_stand_below_the_nominal_world():
    nominal, varied = Entry("a?b=1", "x"), Entry("a?b=1", "x", ("friction", "arm"))
    protocol = Protocol("p", "s", (varied, nominal, Entry("expert", None, ("arm",))))
    results = results_of(protocol, [[HIT] * 8, [SUCCESS, HIT] * 4, [SUCCESS] * 8])
    summary = summarise(protocol, results, {})
    (pair,) = summary["comparisons"]
    low, high = pair["pc_difference_ci95"]
    assert variation_table(summary) == [
        ["varied", "a?b=1, x", "expert"],
        ["nothing", "50 %", "-"],
        ["friction and arm", f"0 % (-50, {low:+.0f} to {high:+.0f})", "-"],
        ["arm", "-", "100 %"],
    ]


def test_a_summary_is_the_same_after_it_was_a_file(measured):
    _, summary = measured
    assert settings_table(json.loads(json.dumps(summary))) == settings_table(summary)


def reports(protocol, results):
    summary = summarise(protocol, results, {})
    arguments = Path("results/run"), protocol, results, summary, "dressing-sim evaluate"
    return markdown(*arguments), page(*arguments).replace("\u00a0", " "), summary


@pytest.mark.parametrize(
    ("protocol", "kinds"),
    [(PROTOCOL, ["settings", "variation"]), (ROBUST, ["variation"]), (FULL, []), (SMALL, [])],
    ids=lambda value: getattr(value, "name", None),
)
def test_the_reports_have_the_tables_of_changes_that_there_are(protocol, kinds):
    text, html, summary = reports(protocol, random_results(protocol, 8))
    assert [one.kind for one in side_by_side(summary)] == kinds
    assert re.findall(r'<section id="(settings|variation)">', html) == kinds
    for one in side_by_side(summary):
        assert f"## {one.title}\n\n{markdown_table(one.cells)}\n\n{one.rule}\n" in text
        section = html.partition(f'<section id="{one.kind}">')[2].partition("</section>")[0]
        assert one.rule in section
        found = re.findall(r"<t[dh]\b[^>]*>(.*?)</t[dh]>", section)
        assert [cell.replace("&amp;", "&") for cell in found] == [*chain(*one.cells)]


@pytest.mark.parametrize("kind", ["settings", "variation"])
def test_a_page_of_the_documentation_can_have_the_table(measured, kind):
    _, summary = measured
    blocks = runpy.run_path(str(ROOT / "scripts" / "fill_tables.py"))["BLOCKS"]
    (one,) = (one for one in side_by_side(summary) if one.kind == kind)
    assert blocks[kind](summary) == markdown_table(one.cells)
