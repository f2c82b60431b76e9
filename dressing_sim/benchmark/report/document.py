"""A report as data: sections of paragraphs, tables, plots, films; writers make it readable.

Texts, in tables too, may hold `code` between backticks and **strong** words; all else is taken as
it is, never as markup.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias, TypeVar

#: Texts of a table, the first row the heading.
Cells: TypeAlias = list[list[str]]

T = TypeVar("T")

#: A column of a table: its heading, and how a cell is made of what the row is about.
Column: TypeAlias = tuple[str, Callable[[T], str]]


@dataclass(frozen=True, slots=True)
class Paragraph:
    """Running text."""

    text: str


@dataclass(frozen=True, slots=True)
class Code:
    """Text that keeps its lines and spaces; `language` is what a writer may highlight it as."""

    text: str
    language: str = ""


@dataclass(frozen=True, slots=True)
class Items:
    """A list."""

    items: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Table:
    """Cells of text, the first row the heading, the first column what a row is about.

    Attributes:
        cells: The texts.
        caption: What they are about.
        links: Where a cell leads: an address by its row, the heading's is 0, and its column.
    """

    cells: Cells
    caption: str = ""
    links: Mapping[tuple[int, int], str] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Plot:
    """A vector plot of numbers.

    Attributes:
        name: Of its file, without the ending.
        svg: As from `dressing_sim.benchmark.report.plots.svg_of`.
        alt: The same numbers in words.
        caption: What it shows.
        file: Whether it is a file of its own, ``{name}.svg``, which Markdown shows; else it is in
            the page alone.
    """

    name: str
    svg: str
    alt: str
    caption: str = ""
    file: bool = False


@dataclass(frozen=True, slots=True)
class Picture:
    """A PNG file, for the page alone."""

    name: str
    png: bytes
    alt: str
    caption: str = ""


@dataclass(frozen=True, slots=True)
class Film:
    """An MP4 file next to the report, ``{name}.mp4``, that browsers play.

    Attributes:
        name: Of its file, without the ending.
        mp4: The file.
        size: Width and height [pixels].
        alt: What happens in it, in words.
        caption: What it shows.
    """

    name: str
    mp4: bytes
    size: tuple[int, int]
    alt: str
    caption: str = ""


@dataclass(frozen=True, slots=True)
class Cards:
    """Small sections of equal rank, side by side where there is room."""

    cards: tuple[Section, ...]


Block: TypeAlias = Paragraph | Code | Items | Table | Plot | Picture | Film | Cards


@dataclass(frozen=True, slots=True)
class Section:
    """A part of a report; a folded one is opened by the reader, where that can be."""

    title: str
    blocks: tuple[Block, ...]
    folded: bool = False


@dataclass(frozen=True, slots=True)
class Document:
    """A report.

    Attributes:
        title: What was done.
        command: What was typed to get it.
        lead: The result in a few words and numbers; a terminal prints no more.
        sections: The rest.
    """

    title: str
    command: str
    lead: tuple[Block, ...]
    sections: tuple[Section, ...] = ()

    @property
    def plots(self) -> list[Plot]:
        """The plots that are files of their own."""
        return [block for block in self._blocks if isinstance(block, Plot) and block.file]

    @property
    def films(self) -> list[Film]:
        """The films, in cards too."""
        cards = [block for block in self._blocks if isinstance(block, Cards)]
        inside = [block for found in cards for card in found.cards for block in card.blocks]
        return [block for block in (*self._blocks, *inside) if isinstance(block, Film)]

    @property
    def _blocks(self) -> list[Block]:
        return [*self.lead, *(block for section in self.sections for block in section.blocks)]


def config_section(summary: Mapping[str, Any]) -> Section:
    """What a run was made with: the summary's ``config`` and ``versions``."""
    versions = ", ".join(f"{name} {number}" for name, number in summary["versions"].items())
    config = Code(json.dumps(summary["config"], indent=2), "json")
    return Section("Settings", (config, Paragraph(versions)), folded=True)


def tabulate(
    rows: Sequence[T], columns: Sequence[Column[T]], optional: Sequence[str] = ()
) -> Cells:
    """A table of columns; those that are optional only where a cell is more than a dash."""
    filled = [[heading, *map(cell, rows)] for heading, cell in columns]
    kept = [c for c in filled if c[0] not in optional or any(text != "-" for text in c[1:])]
    return list(map(list, zip(*kept, strict=True)))


def percent(value: float | None) -> str:
    """A percentage for people; a rate of no trials is a dash.

    Of three digits, so that of two hundred episodes rates and their differences are exact.
    """
    return "-" if value is None else f"{value:.3g} %"
