"""The pages are read by people who are busy: sentences are short, links lead somewhere."""

import re
import unicodedata
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md"))]

#: Words of a sentence, in the mean of a page.
MOST_WORDS = 25.0


def prose(text: str) -> list[str]:
    """Paragraphs and items without code, tables, headings, pictures and the addresses of links."""
    text = re.sub(r"^```.*?^```|<!--.*?-->|^ {4}.*?$", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"^(\||#|!\[|<).*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    return [part for part in re.split(r"\n\s*\n|^\s*[*\d]\.? ", text, flags=re.MULTILINE) if part]


def sentences(text: str) -> list[str]:
    found = (re.split(r"(?<=[a-z0-9`)\]*\"][.:?!;])\s", part.strip()) for part in prose(text))
    return [one for part in found for one in part if len(one.split()) > 1]


def anchors(text: str) -> set[str]:
    """What GitHub calls the headings of a page in links."""
    text = re.sub(r"^```.*?^```", "", text, flags=re.DOTALL | re.MULTILINE)
    found = set()
    for heading in re.findall(r"^#+ (.+)$", text, re.MULTILINE):
        plain = re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading)
        letters = (c for c in plain.lower() if c in " -_" or unicodedata.category(c)[0] in "LN")
        found.add("".join(letters).replace(" ", "-"))
    return found


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_sentences_are_short(page):
    lengths = [len(one.split()) for one in sentences(page.read_text(encoding="utf-8"))]
    assert not lengths or sum(lengths) / len(lengths) <= MOST_WORDS


@pytest.mark.parametrize("page", PAGES, ids=lambda path: str(path.relative_to(ROOT)))
def test_links_lead_to_headings_that_are_there(page):
    text = page.read_text(encoding="utf-8")
    for file, heading in re.findall(r"\]\(([^)#:]*)#([^)]+)\)", text):
        target = page.parent / file if file else page
        assert heading in anchors(target.read_text(encoding="utf-8")), f"{file}#{heading}"


def test_what_is_counted():
    text = "# A b\n\nOne two. Three [four](five.md)?\n\n    code\n\n| a | b |\n\n* six seven\n"
    assert sentences(text) == ["One two.", "Three [four]?", "six seven"]
    assert anchors("## When `x`: 2 [a](b) c") == {"when-x-2-a-c"}
