"""``report.md``: a report for readers without a browser."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence

from dressing_sim.benchmark.report.document import (
    Block,
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

#: What Markdown would take as HTML, and the spans of code in which it would not.
_TAG = re.compile(r"(`[^`]*`)|<(?=[A-Za-z/!?])")


def markdown(document: Document) -> str:
    """The whole report; pictures, and plots that are no files, are in the page alone."""
    blocks = [f"# {_line(document.title)}", _indented(document.command)]
    blocks += [text for block in document.lead for text in _block(block, 2)]
    blocks += [text for section in document.sections for text in _section(section, 2)]
    return "\n\n".join(blocks) + "\n"


def markdown_table(
    cells: Sequence[Sequence[str]], links: Mapping[tuple[int, int], str] | None = None
) -> str:
    """Cells of text, heading first, as a Markdown table; `links` as of `Table`."""
    found = links or {}

    def text(row: int, column: int, cell: str) -> str:
        address = found.get((row, column))
        return _cell(cell) if address is None else f"[{_cell(cell)}]({address})"

    rows = [
        "| " + " | ".join(text(row, column, cell) for column, cell in enumerate(line)) + " |"
        for row, line in enumerate(cells)
    ]
    return "\n".join([rows[0], "| " + " | ".join(["---"] * len(cells[0])) + " |", *rows[1:]])


def _section(section: Section, level: int) -> Iterator[str]:
    yield f"{'#' * level} {_line(section.title)}"
    for block in section.blocks:
        yield from _block(block, level + 1)


def _block(block: Block, level: int) -> Iterator[str]:
    match block:
        case Paragraph(text):
            yield _escaped(text)
        case Code(text, language):
            yield f"```{language}\n{text}\n```" if language else _indented(text)
        case Items(items):
            yield "\n".join(f"* {_line(item)}" for item in items)
        case Table(cells, caption, links):
            yield markdown_table(cells, links)
            if caption:
                yield _escaped(caption)
        case Plot(name, _, alt, caption, file):
            if file:
                yield f"![{_alt(alt)}]({name}.svg)"
            if caption:
                yield (
                    _escaped(caption) if file else f"[Plot in report.html](report.html): {caption}"
                )
        case Cards(cards):
            for card in cards:
                yield from _section(card, level)
        case Film(name, _, _, _, caption):
            yield f"[Film]({name}.mp4): {_line(caption)}"
        case Picture():
            pass


def _escaped(text: str) -> str:
    """Text in which no HTML begins."""
    return _TAG.sub(lambda found: found[1] or r"\<", text)


def _line(text: str) -> str:
    return _escaped(" ".join(text.splitlines()))


def _cell(text: str) -> str:
    """A cell's text, in which a bar or a line's end would begin another cell or line."""
    return _line(text).replace("|", "\\|")


def _alt(text: str) -> str:
    return re.sub(r"([\[\]])", r"\\\1", _line(text))


def _indented(text: str) -> str:
    return "\n".join(f"    {line}" for line in text.splitlines())
