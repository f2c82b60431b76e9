"""``report.html``: a report as one page that needs no script, no network and no other file."""

from __future__ import annotations

import base64
import re
from functools import cache

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup, escape

from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import Cells, Document, Picture, Plot
from dressing_sim.files import assets

#: What a column of numbers holds: signs, digits, and dashes where there is no number.
_NUMBER = re.compile(r"[-+·<]?\s?[\d.]*(\s|\d|$)|[-·]")

#: The page's colours, dark or light, for those of a plot that are not data.
_THEME = {
    plots.PAPER: "none",
    plots.SURFACE: "var(--paper)",
    plots.BLACK: "var(--black)",
    plots.INK: "var(--ink)",
    plots.QUIET: "var(--quiet)",
    plots.GRID: "var(--grid)",
    plots.ACCENT: "var(--accent)",
    plots.CONTRAST: "var(--print)",
}


def html(document: Document) -> str:
    """The whole page; the same document gives the same text."""
    return _template().render(document=document)


@cache
def _template() -> Template:
    environment = Environment(
        loader=FileSystemLoader(assets() / "report", encoding="utf-8"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(
        inline=_inline, slug=_slug, svg=_svg, png=_png, numeric=_numeric, kind=_kind
    )
    return environment.get_template("report.html.jinja")


def _kind(block: object) -> str:
    return type(block).__name__.lower()


def _inline(text: str) -> Markup:
    """Text with its marks as elements, in which no number is parted from its per cent sign."""
    found = re.sub(r"(?<=\d) %", "\u00a0%", str(escape(text)))
    found = re.sub(r"`([^`]+)`", r"<code>\1</code>", found)
    return Markup(re.sub(r"\*\*(.+?)\*\*", r"<strong>\1</strong>", found))


def _slug(title: str) -> str:
    return re.sub(r"\W+", "-", title.lower()).strip("-")


def _numeric(cells: Cells) -> list[bool]:
    """Which columns hold numbers alone."""
    body = cells[1:]
    return [
        column > 0 and bool(body) and all(_NUMBER.match(row[column]) for row in body)
        for column in range(len(cells[0]))
    ]


def _svg(plot: Plot) -> Markup:
    """A plot as an element of the page: told in words, in the page's colours, its names its own."""
    size = re.search(r'viewBox="0 0 ([\d.]+) [\d.]+"', plot.svg)
    if size is None:
        raise ValueError(f"plot {plot.name!r}: not an SVG file of a plot")
    inside = plot.svg[plot.svg.index(">", size.end()) + 1 :]
    inside = re.sub(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", "", inside, flags=re.DOTALL)
    used = set(re.findall(r'[("]#([\w.-]+)', inside))
    inside = re.sub(
        r' id="([^"]+)"', lambda m: f' id="{plot.name}-{m[1]}"' if m[1] in used else "", inside
    )
    inside = re.sub(r'(?<=[("])#(?=[\w.-]+[)"])', f"#{plot.name}-", inside)
    for colour, name in _THEME.items():
        inside = inside.replace(colour, name)
    width = float(size[1])
    return Markup(
        f'<svg {size[0]} role="img" aria-label="{escape(plot.alt)}" '
        f'style="min-width: {width / 16:.0f}rem; max-width: {width / 9.8:.0f}rem">{inside}'
    )


def _png(picture: Picture) -> str:
    return f"data:image/png;base64,{base64.b64encode(picture.png).decode()}"
