"""What a terminal prints of a report: its lead."""

from __future__ import annotations

import re
import sys

from rich.console import Console
from rich.table import Table as Grid
from rich.text import Text

from dressing_sim.benchmark.report.document import Cells, Code, Document, Items, Paragraph, Table

#: Columns of a table that is not printed to a terminal.
_WIDTH = 120


def print_document(document: Document, console: Console | None = None) -> None:
    """Print the lead of a report: its sentences and its main tables."""
    console = console or _console()
    for block in document.lead:
        match block:
            case Paragraph(text) | Code(text):
                console.print(_plain(text))
            case Items(items):
                for item in items:
                    console.print(_plain(f"* {item}"))
            case Table(cells, caption):
                print_table(cells, console, caption)


def print_table(cells: Cells, console: Console | None = None, caption: str = "") -> None:
    """Print cells of text, the first row the heading."""
    heading, *body = cells
    grid = Grid(caption=_plain(caption) if caption else None)
    for name in heading:
        grid.add_column(_plain(name))
    for row in body:
        grid.add_row(*map(_plain, row))
    (console or _console()).print(grid)


def _console() -> Console:
    return Console(width=None if sys.stdout.isatty() else _WIDTH)


def _plain(text: str) -> Text:
    """Without marks, and with square brackets that rich does not take as its own."""
    return Text(re.sub(r"`([^`]+)`|\*\*(.+?)\*\*", r"\1\2", text))
