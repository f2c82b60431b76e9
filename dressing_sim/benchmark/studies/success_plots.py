"""Plots of a run of episodes, each with its numbers in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.curves import Point, budget_curves, elbow_bins, elbow_points
from dressing_sim.benchmark.analysis.failures import first_reasons, valid
from dressing_sim.benchmark.analysis.hypotheses import PAPER_TABLE
from dressing_sim.benchmark.records import EpisodeResult, Protocol
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import Plot, percent
from dressing_sim.benchmark.studies.success_tables import counted
from dressing_sim.episode.rules import in_order, rule_colour

_LEARNED = plots.Style(plots.ACCENT, "o")


def interval(row: Mapping[str, Any]) -> Sequence[float]:
    """The 95 % interval of a row's rate [%], for other demonstrations too where that is known."""
    bounds: Sequence[float] = row.get("pc_success_ci95_sets", row["pc_success_ci95"])
    return bounds


def rates_plot(summary: Mapping[str, Any]) -> Plot:
    """Success rates with their intervals, the rates of single sets, and the paper's."""
    rows, words = [], []
    for row in summary["rows"]:
        name, (low, high) = label_of(row), interval(row)
        printed = PAPER_TABLE.get((row["policy"], row["demonstrations"] or ""))
        printed = None if row["variation"] else printed
        sets = [one["pc_success"] for one in row.get("sets", ())]
        rows.append(
            plots.Interval(
                name,
                low,
                row["pc_success"],
                high,
                muted=row["demonstrations"] is None,
                dots=[rate for rate in sets if rate is not None],
                ring=100.0 * printed[0] / printed[1] if printed else None,
            )
        )
        paper = f"; the paper's {printed[0]} of {printed[1]}" if printed else ""
        words.append(
            f"{name}: {row['n_success']} of {row['n_episodes']} dressed, "
            f"{percent(row['pc_success'])}, interval {low:.0f} to {high:.0f} %{paper}"
        )
    over_sets = any("pc_success_ci95_sets" in row for row in summary["rows"])
    legend = (
        "success rate, 95 % interval",
        "rate on each demonstration set alone" if any(row.dots for row in rows) else "",
        "the paper's rate" if any(row.ring is not None for row in rows) else "",
    )
    return Plot(
        "rates",
        plots.intervals(rows, "arms dressed [%]", (0.0, 100.0), legend),
        _sentences(words),
        "Success rates with their 95 % intervals"
        + (", over sets where policies learned." if over_sets else ".")
        + (" The paper's rates are of five trials on a real robot." if legend[2] else ""),
    )


def differences_plot(pairs: Sequence[Mapping[str, Any]], name: str, caption: str) -> Plot:
    """Differences of success rates of pairs of rows."""
    rows, words = [], []
    for pair in pairs:
        (low, high), a, b = pair["pc_difference_ci95"], label_of(pair["a"]), label_of(pair["b"])
        rows.append(plots.Interval(f"{a}\nless {b}", low, pair["pc_difference"], high))
        middle = "-" if pair["pc_difference"] is None else f"{pair['pc_difference']:+.3g}"
        words.append(f"{a} less {b}: {middle} points, interval {low:+.0f} to {high:+.0f}")
    farthest = max(max(-row.low, row.high) for row in rows)
    reach = next(step for step in (10.0, 20.0, 40.0, 60.0, 80.0, 100.0) if farthest <= step)
    scale = "difference of success rates [percentage points]"
    return Plot(name, plots.intervals(rows, scale, (-reach, reach)), _sentences(words), caption)


def failures_plot(protocol: Protocol, results: Sequence[EpisodeResult]) -> Plot:
    """What went wrong first in the failed episodes of each row."""
    shares, words = {}, []
    for entry in protocol.entries:
        inside = valid(r for r in results if r.entry == entry)
        counts = first_reasons(inside)
        name = entry.label
        shares[name] = {reason: 100.0 * n / len(inside) for reason, n in counts.items()}
        words.append(f"{name}: first {counted(counts) or 'no failure'}")
    reasons = in_order({reason for one in shares.values() for reason in one})
    colours = {reason: rule_colour(reason) for reason in reasons}
    svg = plots.stacked(shares, colours, "failed episodes, by what went wrong first [%]")
    return Plot("failures", svg, _sentences(words))


def elbow_plot(protocol: Protocol, results: Sequence[EpisodeResult]) -> Plot:
    """Success against the bend of the elbow, a panel a row."""
    bins = elbow_bins(results)
    lines, titles = [], []
    for entry in protocol.entries:
        inside = [r for r in results if r.entry == entry]
        style = _LEARNED if entry.demonstrations is not None else plots.MUTED
        lines.append((elbow_points(inside, bins), style, inside))
        titles.append(entry.label)
    n_lines = -(-len(lines) // 3)
    with plots.figure(0.45 + 1.45 * n_lines) as drawn:
        shared = {"sharex": True, "sharey": True}
        grid = plots.panels(drawn, len(lines), 3, **shared)
        for axes, title, (points, style, inside) in zip(grid, titles, lines, strict=True):
            _draw_points(axes, title, points, style)
            for success, (low, high), colour in (
                (True, (106.0, 114.0), style.colour),
                (False, (-14.0, -6.0), plots.CONTRAST),
            ):
                bends = [r.posture.elbow_deg for r in valid(inside) if r.outcome.success == success]
                axes.vlines(bends, low, high, color=colour, lw=0.8)
            margin = 0.03 * (bins[-1] - bins[0])
            axes.set(xlim=(bins[0] - margin, bins[-1] + margin), xticks=bins[:: 1 + len(bins) // 5])
            axes.set_ylim(-14.0, 114.0)
        drawn.supxlabel("elbow flexion [deg]", fontsize=7.5, color=plots.QUIET)
        drawn.supylabel("dressed [%]", fontsize=7.5, color=plots.QUIET)
        svg = plots.svg_of(drawn)
    told = [_told(title, line[0], "degrees") for title, line in zip(titles, lines, strict=True)]
    caption = (
        f"Rates with 95 % Wilson intervals of episodes in bins of {bins[1] - bins[0]} deg; a point "
        "stands at the mean flexion of its bin. The strokes above are single episodes in which the "
        "arm was dressed, those below single episodes that failed."
    )
    return Plot("elbow", svg, _sentences(told), caption)


def budget_plot(protocol: Protocol, results: Sequence[EpisodeResult]) -> Plot | None:
    """Success against the number of demonstrations, a panel a policy; None without such rows."""
    curves = budget_curves(protocol, results)
    if not curves:
        return None
    titles = []
    for entry, _ in curves:
        suite = (entry.demonstrations or "").rpartition(":")[0]
        varied = f", {' and '.join(entry.variation)} varied" if entry.variation else ""
        titles.append(f"{entry.policy} on the first of {suite}{varied}")
    with plots.figure(0.45 + 1.7 * -(-len(curves) // 2)) as drawn:
        grid = plots.panels(drawn, len(curves), 2, sharex=True, sharey=True)
        for axes, title, (_, points) in zip(grid, titles, curves, strict=True):
            _draw_points(axes, title, points, _LEARNED)
            axes.set(ylim=(0.0, 100.0))
            axes.set_xticks(sorted({int(p.x) for _, line in curves for p in line}))
        drawn.supxlabel("demonstrations", fontsize=7.5, color=plots.QUIET)
        drawn.supylabel("dressed [%]", fontsize=7.5, color=plots.QUIET)
        svg = plots.svg_of(drawn)
    told = [_told(title, c[1], "demonstrations") for title, c in zip(titles, curves, strict=True)]
    return Plot("budget", svg, _sentences(told), "Rates with 95 % Wilson intervals.")


def _draw_points(axes: Any, title: str, points: Sequence[Point], style: plots.Style) -> None:
    low, high = zip(*(p.interval for p in points), strict=True) if points else ((), ())
    curve = plots.Curve(title, [p.x for p in points], [p.rate for p in points], low, high)
    plots.draw_curve(axes, curve, style, bars=True)
    axes.set_title(plots.wrapped(title, 34), pad=9.0)
    axes.set_yticks((0, 50, 100))
    axes.grid(axis="y")


def _told(name: str, points: Sequence[Point], unit: str) -> str:
    rates = [f"{p.successes} of {p.trials} at {p.x:.3g} {unit}" for p in points]
    return f"{name}: dressed {', '.join(rates) or 'none, as there are no episodes'}"


def _sentences(words: Sequence[str]) -> str:
    return ". ".join(words)
