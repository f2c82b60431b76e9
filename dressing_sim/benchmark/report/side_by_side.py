"""What a change does to each policy: rows that differ in settings or in the world, side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from dressing_sim.policies.hyperparameters import split_name

#: Line and column of a row.
Place = tuple[str, str]


@dataclass(frozen=True, slots=True)
class SideBySide:
    """One table of a report.

    Attributes:
        kind: Of the comparisons that it shows, see `dressing_sim.benchmark.analysis.comparisons`.
        title: Of its section.
        rule: What a cell says.
        cells: Texts, the first row the heading. Below it the line of rows without a change, if
            there are any, then one for each change; a column for each policy and what it was shown,
            all in the order in which they first appear. A cell is a success rate in per cent with,
            where the row is compared with the one without a change, the paired difference to it and
            its 95 % interval in percentage points; "-" where nothing was run, or all of it is void.
    """

    kind: str
    title: str
    rule: str
    cells: list[list[str]]


def side_by_side(summary: Mapping[str, Any]) -> list[SideBySide]:
    """The tables of a summary, without those of changes that none of its rows has.

    Args:
        summary: As ``summary.json`` holds it, with its comparisons.
    """
    tables = [
        SideBySide("settings", "Settings of policies", _SETTINGS_RULE, settings_table(summary)),
        SideBySide("variation", "Robustness", _VARIATION_RULE, variation_table(summary)),
    ]
    return [one for one in tables if one.cells]


def settings_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """Cells by the settings after a policy's ``?``, or none; see `SideBySide`."""

    def place(row: Mapping[str, Any]) -> Place:
        stem, settings = split_name(row["policy"])
        varied = f"{_varied(row)} varied" if row["variation"] else None
        return settings or "as chosen", _column(stem, row["demonstrations"], varied)

    return _cells(summary, "settings", ("settings", "as chosen"), place)


def variation_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """Cells by what is drawn anew for each episode, or none; see `SideBySide`."""

    def place(row: Mapping[str, Any]) -> Place:
        return _varied(row) or "nothing", _column(row["policy"], row["demonstrations"])

    return _cells(summary, "variation", ("varied", "nothing"), place)


_COMPARED = (
    "in brackets the difference to the same policy {}, over the same postures and demonstration "
    "sets, in percentage points, with its 95 % bootstrap interval."
)

_SETTINGS_RULE = (
    "Success rates of policies with settings changed as each line says; "
    + _COMPARED.format("as chosen")
)

_VARIATION_RULE = (
    "Success rates where what each line says is drawn anew for each episode; "
    + _COMPARED.format("in the nominal world")
)


def _cells(
    summary: Mapping[str, Any],
    kind: str,
    corner: tuple[str, str],
    place: Callable[[Mapping[str, Any]], Place],
) -> list[list[str]]:
    """Cells of the table whose heading and first line begin with the two words of its corner."""
    heading, unchanged = corner
    compared = {place(pair["a"]): pair for pair in summary["comparisons"] if pair["kind"] == kind}
    filled = {place(row): _cell(row, compared.get(place(row))) for row in summary["rows"]}
    lines = dict.fromkeys([unchanged, *(line for line, _ in filled)])
    columns = dict.fromkeys(column for _, column in filled)
    if len(lines) == 1:
        return []
    return [
        [heading, *columns],
        *(
            [line, *(filled.get((line, column), "-") for column in columns)]
            for line in lines
            if any((line, column) in filled for column in columns)
        ),
    ]


def _varied(row: Mapping[str, Any]) -> str:
    return " and ".join(row["variation"])


def _column(*parts: str | None) -> str:
    return ", ".join(filter(None, parts))


def _cell(row: Mapping[str, Any], pair: Mapping[str, Any] | None) -> str:
    if row["pc_success"] is None:
        return "-"
    rate = f"{row['pc_success']:.3g} %"
    if pair is None or pair["pc_difference"] is None:
        return rate
    low, high = pair["pc_difference_ci95"]
    return f"{rate} ({pair['pc_difference']:+.3g}, {low:+.0f} to {high:+.0f})"
