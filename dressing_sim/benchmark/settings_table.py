"""What other settings do to each policy: rows that differ in settings alone, side by side."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dressing_sim.benchmark.paper_settings import split_settings

#: The line of policies without settings after their names.
AS_CHOSEN = "as chosen"


def settings_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """The summary's rows by their settings, as cells of text, the first row the heading.

    Args:
        summary: As ``summary.json`` holds it, with its comparisons of kind ``settings``.

    Returns:
        The heading, then the line "as chosen", then one for each text of settings after a ``?``;
        a column for each policy without them and what it was shown (and what varied), all in the
        order in which they first appear. A cell is a success rate in per cent with, where the row
        is compared with the one as chosen, the paired difference to it and its 95 % interval in
        percentage points; "-" where nothing was run, or all of it is void. Nothing at all if no
        row has settings.
    """
    compared = {
        _place(pair["a"]): pair for pair in summary["comparisons"] if pair["kind"] == "settings"
    }
    filled = {_place(row): _cell(row, compared.get(_place(row))) for row in summary["rows"]}
    lines = dict.fromkeys([AS_CHOSEN, *(line for line, _ in filled)])
    columns = dict.fromkeys(column for _, column in filled)
    if len(lines) == 1:
        return []
    return [
        ["settings", *columns],
        *([line, *(filled.get((line, column), "-") for column in columns)] for line in lines),
    ]


def _place(row: Mapping[str, Any]) -> tuple[str, str]:
    """Line and column of a row."""
    stem, settings = split_settings(row["policy"])
    varied = f"{' and '.join(row['variation'])} varied" if row["variation"] else None
    return settings or AS_CHOSEN, ", ".join(filter(None, [stem, row["demonstrations"], varied]))


def _cell(row: Mapping[str, Any], pair: Mapping[str, Any] | None) -> str:
    if row["pc_success"] is None:
        return "-"
    rate = f"{row['pc_success']:.0f} %"
    if pair is None or pair["pc_difference"] is None:
        return rate
    low, high = pair["pc_difference_ci95"]
    return f"{rate} ({pair['pc_difference']:+.0f}, {low:+.0f} to {high:+.0f})"
