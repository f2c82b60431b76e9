"""What a change does to policies: rows with and without it, side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from dressing_sim.benchmark.report.document import Cells, percent
from dressing_sim.benchmark.studies.success_tables import Summary, signed_interval
from dressing_sim.episode.variation import in_words
from dressing_sim.policies.hyperparameters import split_name


@dataclass(frozen=True, slots=True)
class Change:
    """Something that is changed in some rows, to be compared with those in which it is not.

    Attributes:
        kind: Of the comparisons that show what it does.
        title: Of the section on it.
        rule: What the table shows.
        heading: Of its first column.
        unchanged: What the line without a change is called.
        place: Line and column of a row of the summary.
    """

    kind: str
    title: str
    rule: str
    heading: str
    unchanged: str
    place: Callable[[Summary], tuple[str, str]]


def _by_hyperparameters(row: Summary) -> tuple[str, str]:
    stem, chosen = split_name(row["policy"])
    return chosen or "as chosen", _joined(stem, row["demonstrations"], in_words(row["variation"]))


def _by_variation(row: Summary) -> tuple[str, str]:
    varied = " and ".join(row["variation"])
    return varied or "nothing", _joined(row["policy"], row["demonstrations"])


def _by_style(row: Summary) -> tuple[str, str]:
    suite, style = split_name(row["demonstrations"] or "")
    return style or "the usual", _joined(row["policy"], suite, in_words(row["variation"]))


def _joined(*parts: str | None) -> str:
    return ", ".join(filter(None, parts))


_RULE = (
    "{}; in brackets the difference to the same policy {}, over the same postures and "
    "demonstration sets, in percentage points, with its 95 % bootstrap interval."
)

HYPERPARAMETERS = Change(
    "settings",
    "Settings of policies",
    _RULE.format("Success rates of policies with settings changed as each line says", "as chosen"),
    *("settings", "as chosen", _by_hyperparameters),
)

VARIATION = Change(
    "variation",
    "Robustness",
    _RULE.format(
        "Success rates where what each line says is drawn anew for each episode, or fixed",
        "in the nominal world",
    ),
    *("varied", "nothing", _by_variation),
)

STYLE = Change(
    "style",
    "Operators of other styles",
    _RULE.format(
        "Success rates of policies that learned from an operator of the style that each line says",
        "that learned from the usual operator",
    ),
    *("operator", "the usual", _by_style),
)


def side_by_side(summary: Summary, change: Change) -> Cells:
    """What a change does to each policy: rows with and without it, side by side.

    Below the heading the line of rows without a change, if there are any, then one for each change;
    a column for each policy and its demonstrations, all in the order in which they first appear. A
    cell is a success rate in per cent with, where the row is compared with the one without a
    change, the paired difference to it and its 95 % interval in percentage points; "-" where
    nothing was run, or all of it is void. No cells at all where nothing is changed.
    """
    pairs = [pair for pair in summary["comparisons"] if pair["kind"] == change.kind]
    compared = {change.place(pair["a"]): pair for pair in pairs}
    placed = {change.place(row): row for row in summary["rows"]}
    filled = {place: _rate(row, compared.get(place)) for place, row in placed.items()}
    used = dict.fromkeys(line for line, _ in filled)
    columns = dict.fromkeys(column for _, column in filled)
    if set(used) <= {change.unchanged}:
        return []
    lines = sorted(used, key=lambda line: line != change.unchanged)
    return [
        [change.heading, *columns],
        *([line, *(filled.get((line, column), "-") for column in columns)] for line in lines),
    ]


def _rate(row: Summary, pair: Summary | None) -> str:
    rate = percent(row["pc_success"])
    if row["pc_success"] is None or pair is None or pair["pc_difference"] is None:
        return rate
    return f"{rate} ({pair['pc_difference']:+.3g}, {signed_interval(pair)})"
