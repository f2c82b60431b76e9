import re
from pathlib import Path

import pytest
from fake_pages import Parsed

from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import (
    Cards,
    Code,
    Document,
    Film,
    Items,
    Paragraph,
    Picture,
    Plot,
    Section,
    Table,
)
from dressing_sim.benchmark.report.html import html
from dressing_sim.files import assets

EVIL = '"><script>alert(1)</script><img src=x onerror="alert(1)">'
CELLS = [["what", "rate", "words"], ["a | b", "20 %", "`code` and **strong**"], ["c", "-", "3"]]


def svg(label="a row"):
    return plots.intervals([plots.Interval(label, 1.0, 2.0, 3.0)], "x", (0.0, 4.0))


def everything(text="words"):
    """A document with every kind of block, and this text wherever there can be one."""
    return Document(
        text,
        text,
        (Paragraph(text), Table(CELLS, text)),
        (
            Section(text, (Code(text, "json"), Items((text, "two")))),
            Section("Plots", (Plot("one", svg(text), text, text), Plot("two", svg(), text))),
            Section(
                "Cards",
                (Cards((Section(text, (Picture("p", b"png", text), Paragraph(text))),)),),
                folded=True,
            ),
        ),
    )


def test_the_page_stands_alone():
    text = html(everything())
    parsed = Parsed(text)
    assert text.startswith("<!doctype html>")
    assert not {e["tag"] for e in parsed.elements} & {"script", "link", "iframe", "object", "base"}
    for element in parsed.elements:
        for name in ("src", "href", "srcset", "data", "poster"):
            assert element.get(name, "data:").startswith(("data:", "#"))
    assert "@import" not in text
    assert not re.findall(r"url\((?!['\"]?(data:|#))", text)
    (policy,) = [e for e in parsed.all("meta") if "content-security-policy" in str(e).lower()]
    assert policy["content"].startswith("default-src 'none'")
    assert parsed.all("html", lang="en")


def test_text_is_never_markup():
    parsed = Parsed(html(everything(EVIL)))
    assert not parsed.all("script")
    assert len(parsed.all("img")) == 1
    assert not any(name.startswith("on") for e in parsed.elements for name in e)
    assert parsed.words("h1") == [EVIL]
    assert parsed.words("title") == [EVIL]
    assert EVIL in parsed.words("li")


def test_every_picture_is_told_in_words_too():
    parsed = Parsed(html(everything("what is seen")))
    drawn = [*parsed.all("svg"), *parsed.all("img")]
    assert [e.get("aria-label") or e.get("alt") for e in drawn] == ["what is seen"] * 3
    assert all(e["role"] == "img" for e in parsed.all("svg"))


def test_marks_are_elements_and_numbers_keep_their_per_cent_sign():
    text = html(everything())
    assert "<code>code</code> and <strong>strong</strong>" in text
    assert "20\u00a0%" in text


def test_tables_say_what_rows_and_columns_are_about_and_can_be_scrolled_by_keyboard():
    parsed = Parsed(html(everything("told")))
    assert parsed.words("th", scope="col") == CELLS[0]
    assert parsed.words("th", scope="row") == ["a | b", "c"]
    assert parsed.words("caption") == ["told"]
    regions = parsed.all("div", role="region")
    assert len(regions) == 3  # a table and two plots
    assert all(e["tabindex"] == "0" and e["aria-label"] for e in regions)


def test_columns_of_numbers_are_aligned_and_those_of_words_are_not():
    parsed = Parsed(html(everything()))
    assert parsed.words("td", **{"class": "num"}) == ["20\u00a0%".replace("\u00a0", " "), "-"]


def test_no_two_elements_have_one_name_and_each_that_is_referred_to_is_there():
    text = html(everything())
    names = re.findall(r' id="([^"]+)"', text)
    assert len(set(names)) == len(names)
    used = set(re.findall(r'(?:url\(|xlink:href=")#([^)"]+)', text))
    assert used
    assert used <= set(names)


def test_plots_have_the_colours_of_the_page():
    text = html(everything())
    drawn = text[text.index("<svg") :]
    for colour in (plots.PAPER, plots.INK, plots.QUIET, plots.GRID, plots.ACCENT):
        assert colour not in drawn
    style = (assets() / "report" / "report.css").read_text(encoding="utf-8")
    light, dark = re.findall(r":root \{(.*?)\}", style, re.DOTALL)
    for name in set(re.findall(r"var\((--\w+)\)", drawn)):
        assert f"{name}:" in light
        assert f"{name}:" in dark


def luminance(colour):
    parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
    linear = [p / 12.92 if p <= 0.04045 else ((p + 0.055) / 1.055) ** 2.4 for p in parts]
    return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]


@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
def test_text_can_be_read_on_the_page(theme):
    style = (assets() / "report" / "report.css").read_text(encoding="utf-8")
    colours = dict(
        re.findall(r"(--\w+): (#\w+);", re.findall(r":root \{(.*?)\}", style, re.DOTALL)[theme])
    )
    for front in ("--ink", "--quiet"):
        for back in ("--paper", "--wash"):
            pair = sorted((luminance(colours[front]), luminance(colours[back])))
            assert (pair[1] + 0.05) / (pair[0] + 0.05) >= 4.5


def test_the_same_document_gives_the_same_bytes():
    assert html(everything()) == html(everything())


def test_the_style_and_the_template_are_in_the_package():
    assert sorted(p.name for p in Path(assets() / "report").iterdir()) == [
        "plots.mplstyle",
        "report.css",
        "report.html.jinja",
    ]


def test_films_are_files_beside_the_page_with_controls_and_words():
    film = Film("success-episode7", b"film", (480, 360), EVIL, "what it shows")
    document = Document("a", "b", (), (Section("Films", (Cards((Section("c", (film,)),)),)),))
    assert document.films == [film]
    parsed = Parsed(html(document))
    (video,) = parsed.all("video")
    assert video["src"] == "success-episode7.mp4"
    assert video["aria-label"] == EVIL
    assert "controls" in video
    assert "what it shows" in parsed.words("figcaption")
    assert not parsed.all("script")
    (policy,) = [e for e in parsed.all("meta") if "content-security-policy" in str(e).lower()]
    assert "media-src 'self' file:;" in policy["content"]


def test_a_page_without_films_says_nothing_of_them():
    assert not re.search("video|media-src", html(everything()))
