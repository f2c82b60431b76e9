import base64
import re
from dataclasses import replace
from html.parser import HTMLParser
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from dressing_sim.benchmark.analysis.paper_table import PAPER_TABLE
from dressing_sim.benchmark.report.figures import hardest
from dressing_sim.benchmark.report.text import pair_label
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

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.report import summarise
from dressing_sim.benchmark.report.html import page
from dressing_sim.episode.rules import REASONS, Failure, Outcome
from dressing_sim.errors import DressingSimError
from dressing_sim.files import assets

VOID_ELEMENTS = {"meta", "img", "br", "link", "input", "hr"}
COMMAND = "dressing-sim evaluate --protocol full"


class Parsed(HTMLParser):
    """Elements in order, their attributes, and the text in each; fails on a wrong end tag."""

    def __init__(self, html):
        super().__init__()
        self.elements, self._open = [], []
        self.feed(html)
        self.close()
        assert not self._open, f"not closed: {[e['tag'] for e in self._open]}"

    def handle_starttag(self, tag, attributes):
        element = {"tag": tag, "text": "", **dict(attributes)}
        self.elements.append(element)
        if tag not in VOID_ELEMENTS:
            self._open.append(element)

    def handle_startendtag(self, tag, attributes):
        self.elements.append({"tag": tag, "text": "", **dict(attributes)})

    def handle_endtag(self, tag):
        assert self._open, f"</{tag}> closes nothing"
        assert self._open[-1]["tag"] == tag, f"</{tag}> closes {self._open[-1]['tag']}"
        self._open.pop()
        if tag in ("td", "th", "p"):
            self.handle_data(" ")

    def handle_data(self, data):
        for element in self._open:
            element["text"] += data

    def all(self, tag, **attributes):
        return [
            e
            for e in self.elements
            if e["tag"] == tag and all(e.get(k) == v for k, v in attributes.items())
        ]

    def words(self, tag, **attributes):
        return [" ".join(e["text"].split()) for e in self.all(tag, **attributes)]


#: What the eye sees of linear RGB without one kind of cones (Machado et al. 2009), and with all.
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


def render(protocol, results, picture=None):
    summary = summarise(protocol, results, {"seed": 3})
    html = page(Path("results/run"), protocol, results, summary, COMMAND, picture)
    return html, Parsed(html), summary


@pytest.fixture(scope="module")
def full():
    return render(FULL, random_results(FULL, 50))


@pytest.fixture(scope="module", params=[BUDGET, ROBUST], ids=lambda p: p.name)
def some_page(request):
    return render(request.param, random_results(request.param, 12))


def test_the_page_stands_alone(some_page):
    html, parsed, _ = some_page
    assert html.startswith("<!doctype html>")
    assert not {e["tag"] for e in parsed.elements} & {"script", "link", "iframe", "object", "base"}
    for element in parsed.elements:
        assert not any(name.startswith("on") for name in element)
        for name in ("src", "href", "srcset", "data", "poster"):
            assert element.get(name, "data:").startswith(("data:", "#"))
    assert "@import" not in html
    assert not re.findall(r"url\((?!['\"]?data:)", html)
    (policy,) = [e for e in parsed.all("meta") if "content-security-policy" in str(e).lower()]
    assert policy["content"].startswith("default-src 'none'")


def test_every_picture_is_told_in_words_too(some_page):
    _, parsed, _ = some_page
    figures = parsed.all("svg")
    assert figures
    assert all(e.get("aria-label") or e.get("aria-hidden") == "true" for e in figures)


def test_places_in_figures_are_within_them(some_page):
    html, _, _ = some_page
    places = [float(p) for p in re.findall(r' (?:x|x1|x2|cx)="(-?[\d.]+)%"', html)]
    assert len(places) > 100
    assert min(places) >= 0.0
    assert max(places) <= 100.0


def test_the_table_has_every_row_with_the_numbers_of_the_summary(full):
    _, parsed, summary = full
    lines = parsed.words("tr")
    for row in summary["rows"]:
        shown = f" shown {row['demonstrations']}" if row["demonstrations"] else ""
        void = f" ({row['n_void']} void)" if row["n_void"] else ""
        printed = PAPER_TABLE.get((row["policy"], row["demonstrations"] or ""))
        paper = f" {printed[0]} / {printed[1]}" if printed else ""
        rate = f"{row['pc_success']:.3g} %"
        told = (
            f"{row['policy']}{shown} {row['n_success']} / {row['n_episodes']}{void} {rate}{paper}"
        )
        assert told in lines


def test_intervals_are_drawn_where_the_summary_has_them(full):
    html, _, summary = full
    for row in summary["rows"]:
        low, high = row.get("pc_success_ci95_sets", row["pc_success_ci95"])
        assert f'x="{low:.2f}%" width="{high - low:.2f}%" y="7"' in html
        assert f'class="median" x1="{row["pc_success"]:.2f}%"' in html
    assert html.count('class="printed"') == len(PAPER_TABLE)
    assert 'class="printed" cx="80.00%"' in html


def test_every_reason_is_counted_as_in_the_summary(full):
    _, parsed, summary = full
    reasons = [r for r in REASONS if any(r in row["failures"] for row in summary["rows"])]
    assert f"policy {' '.join(reasons)}" in parsed.words("thead")
    row = summary["rows"][1]
    counts = " ".join(str(row["failures"].get(reason, "·")) for reason in reasons)
    assert f"tp-gmm on case_a {counts}" in parsed.words("tr")


def test_claims_and_comparisons_are_those_of_the_summary(full):
    _, parsed, summary = full
    assert parsed.words("div", **{"class": "verdict confirmed"}) == [
        c["verdict"] for c in summary["claims"] if c["verdict"] == "confirmed"
    ]
    text = " ".join(" ".join(e["text"].split()) for e in parsed.all("main"))
    for claim in summary["claims"]:
        assert claim["statement"] in text
        assert claim["detail"] in text.replace("\u00a0", " ")
    lines = parsed.words("tr")
    assert summary["comparisons"]
    for pair in summary["comparisons"]:
        a, b = (pair_label(pair[side]) for side in "ab")
        (line,) = [line for line in lines if line.startswith(f"{a} less {b} ")]
        assert f" {pair['n_only_a']} / {pair['n_only_b']} " in line
        assert line.endswith(f" {pair['pc_difference']:+.3g}")


def test_sets_settings_versions_and_the_command_are_there(full):
    _, parsed, summary = full
    assert COMMAND in parsed.words("code")
    assert any('"seed": 3' in text for text in parsed.words("code"))
    terms = dict(zip(parsed.words("dt"), parsed.words("dd"), strict=True))
    assert terms == {"seed": "3", **summary["versions"]}
    sets = " ".join(f"{s['n_success']} / {s['n_episodes']}" for s in summary["rows"][1]["sets"])
    assert f"tp-gmm on case_a {sets}" in parsed.words("tr")


def test_the_same_results_in_any_order_give_the_same_bytes():
    results = random_results(ROBUST, 20)
    first = render(ROBUST, results)[0]
    assert render(ROBUST, results[::-1])[0] == first


def test_names_are_text_and_never_markup():
    evil = "<script>alert(1)</script>"
    entry = Entry(f"mine:{evil}", f'"><img src=x onerror="{evil}">')
    protocol = Protocol(f"<b>{evil}", "'>&amp;<", (entry,))
    results = [
        replace(result, posture=arm(f'{evil}" onload="x'))
        for result in results_of(protocol, [[HIT]])
    ]
    summary = summarise(protocol, results, {"note": f"</code>{evil}"})
    html = page(Path(evil), protocol, results, summary, evil, lambda result: b"png")
    parsed = Parsed(html)
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
def test_one_row_is_a_page_whatever_became_of_it(outcomes):
    protocol = Protocol("p", "s", (Entry("tp-gmm", "case_a"),))
    _, parsed, summary = render(protocol, results_of(protocol, [outcomes]))
    (row,) = summary["rows"]
    rate = "-" if row["pc_success"] is None else f"{row['pc_success']:.3g} %"
    assert any(
        line.startswith("tp-gmm shown case_a") and rate in line for line in parsed.words("tr")
    )
    assert len(parsed.all("section", id="hardest")) == (HIT in outcomes)
    assert not parsed.all("section", id="comparisons")
    why = [line for line in parsed.words("td") if line == VOID.invalid]
    assert len(why) == outcomes.count(VOID)


def test_a_run_without_an_episode_is_a_page():
    html, parsed, _ = render(SMALL, [])
    assert "No episode could be judged." in html
    assert len(parsed.all("tr")) > len(SMALL.entries)


def test_a_budget_is_drawn_and_only_there():
    assert render(BUDGET, random_results(BUDGET, 8))[1].all("section", id="budget")
    assert not render(ROBUST, random_results(ROBUST, 8))[1].all("section", id="budget")


def test_a_varied_row_says_so_and_is_not_held_against_the_paper():
    _, parsed, _ = render(ROBUST, random_results(ROBUST, 8))
    (table,) = [t for t in parsed.words("table") if "arms dressed [%]" in t]
    assert "tp-gmm shown case_a friction varied" in table
    assert "tp-gmm shown case_a arm, grasp varied" in table
    assert len(parsed.all("circle", **{"class": "printed"})) == 1


def test_the_hardest_postures_are_pictured_with_what_replays_them(full):
    results = random_results(FULL, 50)
    asked = []

    def picture(result):
        asked.append(result)
        return f"png {result.index}".encode()

    parsed = Parsed(page(Path("results/run"), FULL, results, full[2], COMMAND, picture))
    found = hardest(results)
    assert asked == [hard.pictured for hard in found]
    assert len(asked) == 6
    images = parsed.all("img")
    sources = [base64.b64decode(e["src"].removeprefix("data:image/png;base64,")) for e in images]
    assert sources == [f"png {result.index}".encode() for result in asked]
    for image, result in zip(images, asked, strict=True):
        assert result.posture.name in image["alt"]
        assert f"dressing-sim replay results/run {result.index} --video film.mp4" in parsed.words(
            "code"
        )


def test_without_opengl_the_page_says_so():
    def fails(result):
        raise DressingSimError("no offscreen OpenGL works here: install EGL")

    html, parsed, _ = render(SMALL, results_of(SMALL, [[SUCCESS], [HIT], [HIT]]), fails)
    assert "pictures left out: no offscreen OpenGL works here" in html
    assert not parsed.all("img")
    assert parsed.all("section", id="hardest")


def test_a_picture_that_cannot_be_had_leaves_the_others():
    results = results_of(SMALL, [[SUCCESS] * 2, [HIT, HIT], [HIT, SUCCESS]])
    html, parsed, _ = render(SMALL, results, lambda r: b"png" if r.posture.name == "arm1" else None)
    assert len(parsed.all("img")) == 1
    assert "no picture" in html
    assert "pictures left out" not in html


def test_the_style_knows_every_class_of_the_figures():
    style = (assets() / "report" / "report.css").read_text(encoding="utf-8")
    for place in range(len(REASONS)):
        assert f".reason-{place} {{" in style
    used = re.findall(
        r'class="([\w -]+)"', (assets() / "report" / "plots.jinja").read_text(encoding="utf-8")
    )
    for name in {name for names in used for name in names.split()}:
        assert name == "reason-" or f".{name}" in style or name == "interval", name


def test_every_reason_has_a_colour_of_its_own():
    outcomes = [Outcome(False, (Failure(reason, "why", 1.0),), METRICS) for reason in REASONS]
    _, parsed, _ = render(SMALL, results_of(SMALL, [outcomes] * len(SMALL.entries)))
    classes = [e["class"] for e in parsed.all("i") if e.get("class", "").startswith("reason-")]
    bars = [e["class"] for e in parsed.all("rect") if e.get("class", "").startswith("reason-")]
    assert len(set(classes)) == len(classes) == len(REASONS)
    assert bars == classes * len(SMALL.entries)


@pytest.mark.parametrize("theme", ["light", "dark"])
@pytest.mark.parametrize("seen_by", VISIONS)
def test_colours_of_reasons_and_the_page_are_told_apart_by_everybody(seen_by, theme):
    style = (assets() / "report" / "report.css").read_text(encoding="utf-8")
    light, dark = re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    variables = dict(re.findall(r"(--[\w-]+): (#\w+);", light + (dark if theme == "dark" else "")))
    colours = [variables["--paper"]]
    for place in range(len(REASONS)):
        found = re.search(rf"\.reason-{place} {{ fill: (.+?); background: (.+?); }}", style)
        assert found[1] == found[2]
        colours.append(variables.get(found[1].removeprefix("var(").rstrip(")"), found[1]))
    seen = [perceived(colour, VISIONS[seen_by]) for colour in colours]
    for a, b in combinations(range(len(seen)), 2):
        assert np.linalg.norm(seen[a] - seen[b]) > 0.07, (colours[a], colours[b])


def test_the_expert_is_drawn_apart(full):
    html, _, _ = full
    # Once in the table of rates, once over the elbow's bend.
    assert html.count('<g class="expert">') == 2 * sum(e == EXPERT for e in FULL.entries)
