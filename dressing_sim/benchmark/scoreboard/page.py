"""The scoreboard: a table for each test suite and class of inputs, made of submitted files."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any
from urllib.parse import quote

from dressing_sim.benchmark.report.document import (
    Column,
    Document,
    Paragraph,
    Section,
    Table,
    percent,
    tabulate,
)
from dressing_sim.benchmark.report.html import html
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.scoreboard.rules import PLAIN, TEST_SUITES, Statement
from dressing_sim.benchmark.scoreboard.submission import Submission, read_submission
from dressing_sim.benchmark.studies.success_tables import between
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.policy import INPUTS

#: What writes each kind of page.
WRITERS = {".md": markdown, ".html": html}

_RULES = (
    "Each row was counted from the episodes in its file. Intervals are Wilson's, for the "
    "demonstrations that were given; over sets they are bootstrap intervals for other "
    "demonstrations too. Rows are in the order of their rates: where intervals overlap, the order "
    "says little."
)


@dataclass(frozen=True, slots=True)
class _Row:
    """A row of the scoreboard: a row of a submitted file."""

    suite: str
    values: Mapping[str, Any]
    statement: Statement
    file: Path

    @property
    def section(self) -> tuple[int, int, bool]:
        """Where it is compared: suite, class of inputs, and whether it practised."""
        inputs = INPUTS.index(self.values["inputs"])
        return TEST_SUITES.index(self.suite), inputs, self.statement.practised

    @property
    def rank(self) -> tuple[float, float, str, str]:
        """Its place among others, the best first."""
        rate, low = self.values["pc_success"], self.values["pc_success_ci95"][0]
        return 1.0 if rate is None else -rate, -low, self.values["policy"], self.file.name


_COLUMNS: list[Column[_Row]] = [
    ("policy", lambda row: f"`{row.values['policy']}`"),
    ("shown", lambda row: row.values["demonstrations"] or "-"),
    ("success", lambda row: f"{row.values['n_success']} / {row.values['n_episodes']}"),
    ("rate", lambda row: percent(row.values["pc_success"])),
    ("95 % interval", lambda row: between(row.values["pc_success_ci95"])),
    ("over sets", lambda row: between(row.values.get("pc_success_ci95_sets"))),
    ("void", lambda row: str(row.values["n_void"] or "-")),
    ("abstained", lambda row: str(row.values.get("n_abstained", "-"))),
    ("code", lambda row: "mixed" if row.statement.mixed_code else "-"),
    ("package", lambda row: f"`{row.statement.package}`"),
    ("by", lambda row: row.statement.name),
    ("date", lambda row: row.statement.date),
    ("file", lambda row: row.file.name),
]

#: Columns that are there if a row has something to say in them.
_OPTIONAL = ("over sets", "void", "abstained", "code")


def scoreboard_page(files: Sequence[Path], page: Path, command: str) -> str:
    """The text of a page, Markdown or HTML by its ending, from submitted files.

    Args:
        files: Submitted results.
        page: Where the page will be; its links lead from there to the files.
        command: What was typed to get it.

    Raises:
        InvalidInputError: A file breaks a rule, two hold the same episodes, or the page has another
            ending.
    """
    if page.suffix not in WRITERS:
        raise InvalidInputError(f"{page}: valid is a name that ends {', '.join(WRITERS)}")
    found: dict[str, Path] = {}
    read: dict[Path, Submission] = {}
    for file in sorted(files):
        if not PLAIN.fullmatch(file.name):
            raise InvalidInputError(
                f"{str(file)!r}: valid is a name of letters, digits and . : ? = & + @ , -"
            )
        one = read_submission(file)
        if one.episodes_sha256 in found:
            raise InvalidInputError(f"{file}: holds the episodes of {found[one.episodes_sha256]}")
        found[one.episodes_sha256], read[file] = file, one
    return WRITERS[page.suffix](scoreboard(read, page, command))


def scoreboard(submissions: Mapping[Path, Submission], page: Path, command: str) -> Document:
    """The scoreboard as a document; see `scoreboard_page`."""
    rows = [
        _Row(one.run.plan.protocol.suite, values, one.statement, file)
        for file, one in submissions.items()
        for values in one.rows
    ]
    rows.sort(key=lambda row: (row.section, row.rank))
    sections = [_section(list(group), page) for _, group in groupby(rows, lambda r: r.section)]
    told = f"{len(rows)} rows of {len(submissions)} files." if rows else "No results yet."
    return Document("Scoreboard", command, (Paragraph(f"{told} {_RULES}"),), tuple(sections))


def _section(rows: Sequence[_Row], page: Path) -> Section:
    suite, inputs, practised = rows[0].suite, rows[0].values["inputs"], rows[0].statement.practised
    cells = tabulate(rows, _COLUMNS, optional=_OPTIONAL)
    by, file = cells[0].index("by"), cells[0].index("file")
    links = {}
    for place, row in enumerate(rows, start=1):
        links[place, file] = quote(Path(os.path.relpath(row.file, page.parent)).as_posix())
        if row.statement.link:
            links[place, by] = row.statement.link
    title = f"Suite {suite}, inputs {inputs}{', practised in the simulator' if practised else ''}"
    return Section(title, (Table(cells, links=links),))
