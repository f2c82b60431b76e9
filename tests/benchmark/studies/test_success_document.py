import base64
import re
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from fake_pages import Parsed
from fake_results import (
    BUDGET,
    EXPERT,
    FULL,
    HIT,
    METRICS,
    ROBUST,
    SMALL,
    STUCK,
    SUCCESS,
    VOID,
    arm,
    random_results,
    results_of,
)

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.failures import hardest
from dressing_sim.benchmark.analysis.hypotheses import PAPER_TABLE
from dressing_sim.benchmark.analysis.ranks import FEWEST
from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import tabulate
from dressing_sim.benchmark.report.html import html
from dressing_sim.benchmark.report.markdown import markdown, markdown_table
from dressing_sim.benchmark.studies.protocols import PROTOCOLS
from dressing_sim.benchmark.studies.success_changes import (
    HYPERPARAMETERS,
    VARIATION,
    side_by_side,
)
from dressing_sim.benchmark.studies.success_document import Pictures, headline, success_document
from dressing_sim.benchmark.studies.success_plots import (
    differences_plot,
    elbow_plot,
    failures_plot,
    friction_plot,
    rates_plot,
)
from dressing_sim.benchmark.studies.success_summary import summarise
from dressing_sim.benchmark.studies.success_tables import (
    PAIRS,
    PAIRS_OPTIONAL,
    RANKS,
    listing,
    next_to_paper,
    sets_table,
    table,
)
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rules import REASONS, rule_colour
from dressing_sim.files import assets
from dressing_sim.policies.registry import DEFAULT

COMMAND = "dressing-sim evaluate --protocol full"
FOLDER = Path("results/run")


#: What the eye perceives of linear RGB without one kind of cones (Machado et al. 2009), and with
#: all.
VISIONS = {
    "all": np.eye(3),
    "protanopes": [[0.152, 1.053, -0.205], [0.115, 0.786, 0.099], [-0.004, -0.048, 1.052]],
    "deuteranopes": [[0.367, 0.861, -0.228], [0.280, 0.673, 0.047], [-0.012, 0.043, 0.969]],
    "tritanopes": [[1.256, -0.077, -0.179], [-0.078, 0.931, 0.148], [0.005, 0.691, 0.304]],
}


def perceived(colour, vision):
    """A colour #rrggbb in Oklab (Ottosson 2020), where 0.02 is just noticed."""
    encoded = np.array([int(colour[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(encoded < 0.04, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    cones = [[0.4122, 0.5363, 0.0514], [0.2119, 0.6807, 0.1074], [0.0883, 0.2817, 0.6300]]
    lab = [[0.2105, 0.7936, -0.0041], [1.9780, -2.4286, 0.4506], [0.0259, 0.7828, -0.8087]]
    return np.array(lab) @ np.cbrt(np.array(cones) @ np.clip(np.array(vision) @ linear, 0, 1))


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("eyes", VISIONS)
def test_reasons_and_the_page_are_told_apart_by_everybody(eyes, theme):
    style = (assets() / "report" / "report.css").read_text(encoding="utf-8")
    page = dict(
        re.findall(r"(--\w+): (#\w+);", re.findall(r":root \{(.*?)\}", style, re.DOTALL)[theme])
    )
    themed = {"#000000": page["--black"]}
    colours = [
        page["--paper"],
        *(themed.get(colour, colour) for colour in map(rule_colour, REASONS)),
    ]
    seen = [perceived(colour, VISIONS[eyes]) for colour in colours]
    for a, b in combinations(seen, 2):
        assert np.linalg.norm(a - b) > 0.07


def report(protocol, results, pictures=None):
    summary = summarise(protocol, results, {"seed": 3})
    return success_document(FOLDER, protocol, results, summary, COMMAND, pictures), summary


def render(protocol, results, pictures=None):
    document, summary = report(protocol, results, pictures)
    return html(document).replace("\u00a0", " "), summary


@pytest.fixture(scope="module")
def full():
    results = random_results(FULL, 50)
    return results, *report(FULL, results)


@pytest.mark.parametrize("write", [html, markdown])
def test_tables_claims_and_the_command_are_in_every_report(full, write):
    results, document, summary = full
    text = write(document).replace("\u00a0", " ").replace("&#39;", "'")
    assert COMMAND in text
    assert '"seed": 3' in text.replace("&#34;", '"')
    assert "mujoco 4.0" in text
    for claim in summary["claims"]:
        assert claim["statement"] in text
        assert claim["detail"] in text
    for cells in (table(summary), sets_table(summary), listing(EpisodeTable.of(results))[1]):
        assert_table(text, cells, write)
    assert summary["comparisons"]
    first = tabulate(summary["comparisons"][:6], PAIRS, optional=PAIRS_OPTIONAL)
    assert_table(text, first, write)


def test_many_methods_are_ranked_and_held_against_ours():
    policies = [*map(str, range(FEWEST - 1)), DEFAULT]
    protocol = Protocol("p", "s", tuple(Entry(name, "x") for name in policies))
    outcomes = [[SUCCESS] * (n + 1) + [HIT] * (len(policies) - n - 1) for n in range(len(policies))]
    results = results_of(protocol, outcomes)
    summary = summarise(protocol, results, {})
    assert [one["policy"] for one in summary["ranks"]] == policies[::-1]
    text = markdown(success_document(Path("p"), protocol, results, summary, "c"))
    assert markdown_table(tabulate(summary["ranks"], RANKS)) in text
    assert "| 1 | 1 - " in text
    assert "p (Holm)" in text
    assert "First less the default policy, shown the same demonstrations" in text


def assert_table(text, cells, write):
    if write is markdown:
        assert markdown_table(cells) in text
    else:
        lines = Parsed(text).words("tr")
        assert all(" ".join(line) in lines for line in cells)


@pytest.mark.parametrize("protocol", [FULL, BUDGET, ROBUST, SMALL], ids=lambda p: p.name)
def test_every_plot_is_told_in_words(protocol):
    text, _ = render(protocol, random_results(protocol, 12))
    drawn = Parsed(text).all("svg")
    assert len(drawn) >= 3
    assert all(e["aria-label"] for e in drawn)


def test_the_plot_of_rates_says_what_the_summary_says(full):
    _, _, summary = full
    plot = rates_plot(summary)
    for row in summary["rows"]:
        low, high = row.get("pc_success_ci95_sets", row["pc_success_ci95"])
        printed = PAPER_TABLE.get((row["policy"], row["demonstrations"] or ""))
        paper = f"; the paper's {printed[0]} of {printed[1]}" if printed else ""
        assert (
            f"{label_of(row)}: {row['n_success']} of {row['n_episodes']} dressed, "
            f"{row['pc_success']:.3g} %, interval {low:.0f} to {high:.0f} %{paper}"
        ) in plot.alt


def test_a_varied_row_is_not_held_against_the_paper():
    _, summary = report(ROBUST, random_results(ROBUST, 8))
    assert rates_plot(summary).alt.count("the paper's") == 1


def test_the_plot_of_differences_says_what_the_summary_says(full):
    _, _, summary = full
    pairs = summary["comparisons"]
    alt = differences_plot(pairs, "differences", "").alt
    for pair in pairs:
        low, high = pair["pc_difference_ci95"]
        names = f"{label_of(pair['a'])} less {label_of(pair['b'])}"
        numbers = f"{pair['pc_difference']:+.3g} points, interval {low:+.0f} to {high:+.0f}"
        assert f"{names}: {numbers}" in alt


def test_every_reason_has_a_colour_of_its_own_and_is_drawn_with_it():
    assert len(set(map(rule_colour, REASONS))) == len(REASONS)
    outcomes = [Outcome(False, (Failure(reason, "why", 1.0),), METRICS) for reason in REASONS]
    results = results_of(SMALL, [outcomes] * len(SMALL.entries))
    plot = failures_plot(SMALL, EpisodeTable.of(results))
    for reason in REASONS:
        assert f"{reason} 1" in plot.alt
        colour = rule_colour(reason).replace("#000000", plots.BLACK)
        assert plot.svg.count(f"fill: {colour}") >= len(SMALL.entries) + 1


def test_a_rule_that_is_not_ours_is_counted_and_drawn_like_ours():
    outcome = Outcome(False, (Failure("dropped", "why", 1.0),), METRICS)
    results = results_of(SMALL, [[outcome, HIT], [SUCCESS], [SUCCESS]])
    assert "expert: first hit 1, dropped 1" in failures_plot(SMALL, EpisodeTable.of(results)).alt
    assert "| row | hit | dropped |" in markdown(report(SMALL, results)[0])


def test_success_over_friction_is_drawn_for_the_rows_in_which_it_varies():
    results = results_of(ROBUST, [[SUCCESS, HIT, SUCCESS]] * 3)
    varied = [
        replace(r, variation={"friction": 0.2 + 0.3 * (r.index % 3)})
        if "friction" in r.entry.variation
        else r
        for r in results
    ]
    alt = friction_plot(ROBUST, EpisodeTable.of(varied)).alt
    assert alt == (
        "tp-gmm on case_a, friction varied: dressed 1 of 1 at 0.2 friction, "
        "0 of 1 at 0.5 friction, 1 of 1 at 0.8 friction"
    )
    assert friction_plot(ROBUST, EpisodeTable.of(results)) is None


def test_success_over_the_elbow_s_bend_is_told_bin_by_bin():
    protocol = Protocol("p", "s", (Entry("tp-gmm", "case_a"), EXPERT))
    results = results_of(protocol, [[SUCCESS, HIT, VOID], [VOID] * 3])
    alt = elbow_plot(protocol, EpisodeTable.of(results)).alt
    assert "tp-gmm on case_a: dressed 1 of 1 at 0 degrees, 0 of 1 at 10 degrees" in alt
    assert "expert: dressed none, as there are no episodes" in alt


def test_the_same_results_in_any_order_give_the_same_bytes():
    results = random_results(ROBUST, 20)
    assert render(ROBUST, results[::-1])[0] == render(ROBUST, results)[0]


def test_names_are_text_and_never_markup():
    evil = "<script>alert(1)</script>"
    entry = Entry(f"mine:{evil}", f'"><img src=x onerror="{evil}">')
    protocol = Protocol(f"<b>{evil}", "'>&amp;<", (entry,))
    results = [
        replace(result, posture=arm(f'{evil}" onload="x'))
        for result in results_of(protocol, [[HIT]])
    ]
    summary = summarise(protocol, results, {"note": f"</code>{evil}"})
    drawn = Pictures({0: b"png"})
    document = success_document(Path(evil), protocol, results, summary, evil, drawn)
    parsed = Parsed(html(document))
    assert not parsed.all("script")
    assert not parsed.all("b")
    assert len(parsed.all("img")) == 1
    assert not any(name.startswith("on") for e in parsed.elements for name in e)
    assert parsed.words("h1") == [f"Protocol <b>{evil} on suite '>&amp;<"]
    assert entry.policy in " ".join(parsed.words("th"))


@pytest.mark.parametrize(
    "outcomes",
    [[SUCCESS, SUCCESS], [HIT, STUCK], [VOID, VOID], [VOID, SUCCESS]],
    ids=["all dressed", "none dressed", "all void", "one void"],
)
def test_one_row_is_a_report_whatever_became_of_it(outcomes):
    protocol = Protocol("p", "s", (Entry("tp-gmm", "case_a"),))
    text, summary = render(protocol, results_of(protocol, [outcomes]))
    parsed = Parsed(text)
    assert " ".join(table(summary)[1]) in parsed.words("tr")
    assert len(parsed.all("section", id="the-hardest-postures")) == (HIT in outcomes)
    assert not parsed.all("section", id="pairs-of-rows-posture-by-posture")
    why = [line for line in parsed.words("td") if line == VOID.invalid]
    assert len(why) == outcomes.count(VOID)


def test_a_run_without_an_episode_is_a_report():
    text, _ = render(SMALL, [])
    assert "No episode could be judged." in text
    assert len(Parsed(text).all("tr")) > len(SMALL.entries)


def test_a_budget_is_drawn_and_only_there():
    title = "Success against the number of demonstrations"
    for protocol in (BUDGET, ROBUST):
        document, _ = report(protocol, random_results(protocol, 8))
        assert (title in [s.title for s in document.sections]) == (protocol is BUDGET)


SETTINGS = Protocol(
    "settings",
    "val50",
    tuple(
        Entry(f"{policy}{change}", "case_a", variation)
        for policy in ("tp-gmm", "tp-gmm-rf")
        for change in ("", "?end_radius=0")
        for variation in ((), ("arm",))
    ),
)


@pytest.mark.parametrize(
    ("protocol", "titles"),
    [
        (SETTINGS, ["Settings of policies", "Robustness"]),
        (ROBUST, ["Robustness"]),
        (FULL, []),
        (SMALL, []),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_the_report_has_the_tables_of_changes_that_there_are(protocol, titles):
    document, summary = report(protocol, random_results(protocol, 8))
    assert [s.title for s in document.sections if "in brackets" in str(s)] == titles
    text = markdown(document)
    for cells in filter(None, (side_by_side(summary, c) for c in (HYPERPARAMETERS, VARIATION))):
        assert markdown_table(cells) in text


def test_only_the_papers_protocol_is_put_next_to_the_papers_table(full):
    paper = PROTOCOLS["paper"]
    document, summary = report(paper, random_results(paper, 5))
    assert markdown_table(next_to_paper(summary["rows"])) in markdown(document)
    assert "the paper's table" not in markdown(full[1])


def test_a_title_names_the_protocol_or_the_policies_in_place_of_its_rows():
    paper = PROTOCOLS["paper"]
    own = paper.with_policies(["transport", "expert"])
    for protocol, title in ((paper, "Protocol paper"), (own, "transport and expert")):
        document, _ = report(protocol, random_results(protocol, 2))
        assert document.title == f"{title} on suite paper5"


def test_the_hardest_postures_are_pictured_with_what_replays_them(full):
    results, _, summary = full
    found = hardest(EpisodeTable.of(results))
    drawn = Pictures({h.pictured.index: f"png {h.pictured.index}".encode() for h in found})
    document = success_document(FOLDER, FULL, results, summary, COMMAND, drawn)
    parsed = Parsed(html(document))
    images = parsed.all("img")
    sources = [base64.b64decode(e["src"].removeprefix("data:image/png;base64,")) for e in images]
    assert sources == list(drawn.png.values())
    assert len(sources) == 6
    for image, hard in zip(images, found, strict=True):
        command = f"dressing-sim replay results/run {hard.pictured.index} --video film.mp4"
        assert hard.pictured.posture.name in image["alt"]
        assert command in parsed.words("code")
        assert f"`{command}`" in markdown(document)


def test_a_page_without_pictures_says_why():
    results = results_of(SMALL, [[SUCCESS], [HIT], [HIT]])
    text, _ = render(SMALL, results, Pictures(missing="pictures left out: no OpenGL"))
    assert "pictures left out: no OpenGL" in text
    assert not Parsed(text).all("img")
    assert "the robot touched head" in text


def test_a_picture_that_cannot_be_had_leaves_the_others():
    results = results_of(SMALL, [[SUCCESS] * 2, [HIT, HIT], [HIT, SUCCESS]])
    text, _ = render(SMALL, results, Pictures({3: b"png"}))
    assert len(Parsed(text).all("img")) == 1
    assert text.count("No picture") == 1
    assert "pictures left out" not in text


def test_the_headline_names_the_best_that_learned_and_the_expert():
    results = results_of(SMALL, [[SUCCESS] * 4, [SUCCESS, STUCK, HIT, HIT], [VOID]])
    text = headline(SMALL, summarise(SMALL, results, {}))
    assert "tp-gmm on case_a did best: 1 of 4 arms (25 %" in text
    assert "expert, who sees the whole arm, dressed 4 of 4 arms (100 %" in text


def test_the_headline_names_all_that_are_best():
    protocol = Protocol("p", "s", (Entry("a", "x"), Entry("b", "x"), Entry("c", "x")))
    tied = summarise(protocol, results_of(protocol, [[SUCCESS], [HIT], [SUCCESS]]), {})
    assert "a on x and c on x did equally well: 100 % dressed" in headline(protocol, tied)
    equal = summarise(protocol, results_of(protocol, [[HIT], [HIT], [HIT]]), {})
    assert "No policy that learned dressed an arm." in headline(protocol, equal)
    void = summarise(protocol, results_of(protocol, [[VOID], [VOID], [VOID]]), {})
    assert headline(protocol, void) == "No episode could be judged."


def test_the_headline_of_a_run_under_variation_alone_is_of_its_rows():
    protocol = Protocol("p", "s", (Entry("tp-gmm", "case_a", ("friction",)),))
    text = headline(protocol, summarise(protocol, results_of(protocol, [[SUCCESS, HIT]]), {}))
    assert "1 of 2 arms" in text


def test_the_expert_alone_is_a_report():
    protocol = Protocol("p", "s", (EXPERT,))
    document, summary = report(protocol, results_of(protocol, [[SUCCESS]]))
    assert (summary["comparisons"], summary["claims"]) == ([], [])
    assert "hardest" not in markdown(document)
