"""Tables whose columns are declared once: the heading, and what stands below it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import partial
from string import Formatter
from typing import Any, TypeAlias

from dressing_sim.benchmark.report.document import Cells, tabulate

#: What stands in a column: a format of a row's values, or a function of the row.
Column: TypeAlias = "str | Callable[[Mapping[str, Any]], str]"


def table_of(columns: Mapping[str, Column], rows: Iterable[Mapping[str, Any]]) -> Cells:
    """A table of columns by their headings, with a line for each row.

    A format such as ``{share:.1%}`` is a dash where one of its values is None.
    """
    return tabulate(list(rows), [(name, partial(_cell, one)) for name, one in columns.items()])


def _cell(column: Column, row: Mapping[str, Any]) -> str:
    if callable(column):
        return column(row)
    names = [name.partition("[")[0] for _, name, _, _ in Formatter().parse(column) if name]
    return "-" if any(row[name] is None for name in names) else spaced(column, row)


def spaced(text: str, values: Mapping[str, Any]) -> str:
    """A text with values in it, per cent after a space."""
    return _Spaced().vformat(text, (), values)


class _Spaced(Formatter):
    def format_field(self, value: Any, format_spec: str) -> str:
        text: str = super().format_field(value, format_spec)
        return text.replace("%", " %") if format_spec.endswith("%") else text
