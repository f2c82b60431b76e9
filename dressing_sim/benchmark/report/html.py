"""``report.html``: one file with tables and figures that needs no script and no network."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from dressing_sim.benchmark.analysis.comparisons import label
from dressing_sim.benchmark.analysis.paper_table import PAPER_TABLE
from dressing_sim.benchmark.records import EpisodeResult, Protocol
from dressing_sim.benchmark.report import figures, text
from dressing_sim.benchmark.report.cards import Picture, hard_postures
from dressing_sim.benchmark.report.figures import Axis, Curve
from dressing_sim.benchmark.report.side_by_side import side_by_side
from dressing_sim.episode.rules import REASONS
from dressing_sim.files import assets

#: How the template writes numbers.
_FILTERS: Mapping[str, Callable[[Any], str]] = {
    "percent": text.percent,
    "place": lambda value: f"{value:.2f}%",
    "plain": lambda value: f"{value:.4g}",
    "signed": lambda value: "-" if value is None else f"{value:+.3g}",
    "fraction": lambda value: "-" if value is None else f"{value:.2f}",
    "whole": lambda value: f"{value:.0f}",
    "unbroken": lambda value: value.replace(" %", "\u00a0%"),
    "p_value": lambda value: "< 0.001" if value < 0.001 else f"{value:.3f}",
}


def page(
    folder: Path,
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    summary: Mapping[str, Any],
    command: str,
    picture: Picture | None = None,
) -> str:
    """The whole page; the same arguments give the same text.

    Args:
        folder: Where the run is, for the commands that replay an episode.
        protocol: What was measured.
        results: Its episodes, in any order.
        summary: As from `summarise`.
        command: What was typed to get it.
        picture: Draws the failed episodes of the hardest postures.
    """
    ordered = sorted(results, key=lambda result: result.index)
    environment = Environment(
        loader=FileSystemLoader(assets() / "report", encoding="utf-8"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters.update(_FILTERS)
    cards, pictures_missing = hard_postures(folder, ordered, picture)
    listed, cells = text.listing(ordered)
    return environment.get_template("report.html.jinja").render(
        protocol=protocol,
        summary=summary,
        command=command,
        headline=text.headline(protocol, summary),
        success_rule=text.SUCCESS_RULE,
        **_rows(protocol, ordered, summary),
        side_by_side=side_by_side(summary),
        **_comparisons(summary),
        **_budget(protocol, ordered),
        cards=cards,
        pictures_missing=pictures_missing,
        void=[(r, label(r.entry)) for r in ordered if r.outcome.invalid is not None],
        listed=listed,
        cells=cells,
        settings=json.dumps(summary["config"], indent=2),
    )


def _rows(
    protocol: Protocol, results: Sequence[EpisodeResult], summary: Mapping[str, Any]
) -> dict[str, Any]:
    """A line for each row of the table with what its figures show, and their axes."""
    bends = figures.elbow_axis(results)
    failures = figures.first_failures(protocol, results)
    curves = figures.elbow_curves(protocol, results, bends)
    lines = []
    for entry, row, failed, curve in zip(
        protocol.entries, summary["rows"], failures, curves, strict=True
    ):
        name = label(entry)
        printed = PAPER_TABLE.get((entry.policy, entry.demonstrations or ""))
        printed = None if entry.variation else printed
        sets = [one["pc_success"] for one in row.get("sets", ())]
        lines.append(
            {
                "name": name,
                "row": row,
                "printed": printed,
                "sets": [rate for rate in sets if rate is not None],
                "interval": text.interval(row),
                "rate_alt": _rate_alt(name, row, printed),
                "segments": failed.segments,
                "failure_alt": f"{name}: first {text.counted(failed.counts) or 'no failure'}",
                "elbow": curve,
                "elbow_alt": _curve_alt(name, curve, "degrees"),
            }
        )
    return {
        "lines": lines,
        "rates": Axis(0.0, 100.0, (0.0, 25.0, 50.0, 75.0, 100.0)),
        "bends": bends,
        "shares": figures.share_axis(max((f.percentage for f in failures), default=0.0)),
        "reasons": [r for r in REASONS if any(r in row["failures"] for row in summary["rows"])],
        "first_reasons": {reason for f in failures for reason in f.counts},
        "colours": {reason: place for place, reason in enumerate(REASONS)},
    }


def _comparisons(summary: Mapping[str, Any]) -> dict[str, Any]:
    """Pairs of rows by the kind of their comparison, and the axis of their differences."""
    pairs = summary["comparisons"]
    bounds = [bound for pair in pairs for bound in pair["pc_difference_ci95"]]
    kinds = []
    for kind, group in groupby(pairs, key=lambda pair: pair["kind"]):
        lines = [
            {
                "first": text.pair_label(pair["a"]),
                "second": text.pair_label(pair["b"]),
                "numbers": pair,
                "alt": _pair_alt(pair),
            }
            for pair in group
        ]
        kinds.append((text.COMPARISONS.get(kind, kind), lines))
    return {"kinds": kinds, "differences": figures.symmetric_axis(bounds)}


def _budget(protocol: Protocol, results: Sequence[EpisodeResult]) -> dict[str, Any]:
    """Curves over the number of demonstrations with their names, and their common axis."""
    curves = figures.budget_curves(protocol, results)
    panels = []
    for curve in curves:
        suite = (curve.entry.demonstrations or "").rpartition(":")[0]
        name = f"{curve.entry.policy} on the first of {suite}"
        panels.append((name, curve, _curve_alt(name, curve, "demonstrations")))
    return {"budget": panels, "numbers": figures.number_axis(curves)}


def _rate_alt(name: str, row: Mapping[str, Any], printed: tuple[int, int] | None) -> str:
    low, high = text.interval(row)
    paper = f"; the paper's {printed[0]} of {printed[1]}" if printed else ""
    return (
        f"{name}: {row['n_success']} of {row['n_episodes']} dressed, "
        f"{text.percent(row['pc_success'])}, interval {low:.0f} to {high:.0f} %{paper}"
    )


def _pair_alt(pair: Mapping[str, Any]) -> str:
    low, high = pair["pc_difference_ci95"]
    difference = _FILTERS["signed"](pair["pc_difference"])
    names = f"{text.pair_label(pair['a'])} less {text.pair_label(pair['b'])}"
    return f"{names}: {difference} percentage points, interval {low:+.0f} to {high:+.0f}"


def _curve_alt(name: str, curve: Curve, unit: str) -> str:
    rates = [f"{p.successes} of {p.trials} at {p.x:.3g} {unit}" for p in curve.points]
    return f"{name}: dressed {', '.join(rates) or 'none, as there are no episodes'}"
