"""Plots of a run of episodes, each with its numbers in words."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.ticker import NullLocator

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.curves import (
    Curve,
    budget_curves,
    elbow_bins,
    elbow_curve,
    friction_bins,
    friction_curve,
)
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import Protocol, in_order
from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import Plot, percent
from dressing_sim.benchmark.report.panels import in_panels
from dressing_sim.benchmark.studies.success_tables import (
    counted,
    number,
    printed_rate,
    signed_interval,
)
from dressing_sim.episode.rules import rule_colour
from dressing_sim.episode.variation import in_words

_LEARNED = plots.Style(plots.ACCENT, "o")

FRICTION_TICKS = (0.2, 0.3, 0.5, 0.7, 1.0)


def interval(row: Mapping[str, Any]) -> Sequence[float]:
    """The 95 % interval of a row's rate [%], for other demonstrations too where that is known."""
    bounds: Sequence[float] = row.get("pc_success_ci95_sets", row["pc_success_ci95"])
    return bounds


def rates_plot(summary: Mapping[str, Any]) -> Plot:
    """Success rates with their intervals, the rates of single sets, and the paper's."""
    rows, words = [], []
    for row in summary["rows"]:
        name, (low, high), printed = label_of(row), interval(row), printed_rate(row)
        sets = [one["pc_success"] for one in row.get("sets", ())]
        rows.append(
            plots.Interval(
                name,
                low,
                row["pc_success"],
                high,
                muted=row["demonstrations"] is None,
                dots=[rate for rate in sets if rate is not None],
                ring=printed.percent if printed else None,
            )
        )
        paper = f"; the paper's {printed.n_success} of {printed.n}" if printed else ""
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
        ". ".join(words),
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
        middle = number(pair["pc_difference"], "+.3g")
        words.append(f"{a} less {b}: {middle} points, interval {signed_interval(pair)}")
    farthest = max(max(-row.low, row.high) for row in rows)
    reach = next(step for step in (10.0, 20.0, 40.0, 60.0, 80.0, 100.0) if farthest <= step)
    scale = "difference of success rates [percentage points]"
    return Plot(name, plots.intervals(rows, scale, (-reach, reach)), ". ".join(words), caption)


def ranks_plot(ranks: Sequence[Mapping[str, Any]]) -> Plot:
    """Places of methods with their intervals, the best on top."""
    rows = [
        plots.Interval(one["policy"], one["rank_ci95"][0], one["rank"], one["rank_ci95"][1])
        for one in ranks
    ]
    words = [
        f"{row.label}: place {row.value:g}, interval {row.low:g} to {row.high:g}" for row in rows
    ]
    svg = plots.intervals(rows, "place by success rate", (0.5, len(rows) + 0.5))
    return Plot("ranks", svg, ". ".join(words), "Places with 95 % bootstrap intervals.")


def failures_plot(protocol: Protocol, episodes: EpisodeTable) -> Plot:
    """What went wrong first in the failed episodes of each row."""
    shares, words = {}, []
    for entry in protocol.entries:
        inside = episodes.of_entry(entry)
        counts = inside.first_reasons
        shares[entry.label] = {reason: 100.0 * n / inside.rate.n for reason, n in counts.items()}
        words.append(f"{entry.label}: first {counted(counts) or 'no failure'}")
    reasons = in_order({reason for one in shares.values() for reason in one})
    colours = {reason: rule_colour(reason) for reason in reasons}
    svg = plots.stacked(shares, colours, "failed episodes, by what went wrong first [%]")
    return Plot("failures", svg, ". ".join(words))


def elbow_plot(protocol: Protocol, episodes: EpisodeTable) -> Plot:
    """Success against the bend of the elbow, a panel a row."""
    bins = elbow_bins(episodes)
    margin = 0.03 * (bins[-1] - bins[0])
    rows = [episodes.of_entry(entry) for entry in protocol.entries]
    styles = [_LEARNED if e.demonstrations is not None else plots.MUTED for e in protocol.entries]

    def finish(axes: Axes, place: int) -> None:
        row = rows[place]
        for chosen, (low, high), colour in (
            (row.valid & ~row.failed, (106.0, 114.0), styles[place].colour),
            (row.failed, (-14.0, -6.0), plots.CONTRAST),
        ):
            axes.vlines(row.elbow_deg[chosen], low, high, color=colour, lw=0.8)
        axes.set(xlim=(bins[0] - margin, bins[-1] + margin), xticks=bins[:: 1 + len(bins) // 5])
        axes.set_ylim(-14.0, 114.0)

    curves = [
        (entry.label, elbow_curve(row, bins), style)
        for entry, row, style in zip(protocol.entries, rows, styles, strict=True)
    ]
    svg = _panels(curves, 3, 1.45, "elbow flexion [deg]", finish)
    caption = (
        f"Rates with 95 % Wilson intervals of episodes in bins of {bins[1] - bins[0]} deg; a point "
        "stands at the mean flexion of its bin. The strokes above are single episodes in which the "
        "arm was dressed, those below single episodes that failed."
    )
    return Plot("elbow", svg, _told(curves, "degrees"), caption)


def friction_plot(protocol: Protocol, episodes: EpisodeTable) -> Plot | None:
    """Success against the friction drawn, a panel a row; None where none was drawn."""
    bins = friction_bins(episodes)
    entries = [entry for entry in protocol.entries if "friction" in entry.variation]
    if not len(bins) or not entries:
        return None
    curves = [
        (
            entry.label,
            friction_curve(episodes.of_entry(entry), bins),
            plots.MUTED if entry.demonstrations is None else _LEARNED,
        )
        for entry in entries
    ]

    def finish(axes: Axes, _: int) -> None:
        axes.set_xscale("log")
        axes.set(ylim=(0.0, 100.0), xlim=(0.95 * bins[0], 1.05 * bins[-1]))
        axes.set_xticks(FRICTION_TICKS, [f"{tick:g}" for tick in FRICTION_TICKS])
        axes.xaxis.set_minor_locator(NullLocator())

    svg = _panels(curves, 3, 1.45, "friction of cloth on skin", finish)
    caption = (
        "Rates with 95 % Wilson intervals of episodes in bins of the friction drawn for them, even "
        "in its logarithm; a point stands at the mean friction of its bin."
    )
    return Plot("friction", svg, _told(curves, "friction"), caption)


def budget_plot(protocol: Protocol, episodes: EpisodeTable) -> Plot | None:
    """Success against the number of demonstrations, a panel a policy; None without such rows."""
    found = budget_curves(protocol, episodes)
    if not found:
        return None
    curves = []
    for entry, curve in found:
        suite = (entry.demonstrations or "").rpartition(":")[0]
        varied = f", {in_words(entry.variation)}" if entry.variation else ""
        curves.append((f"{entry.policy} on the first of {suite}{varied}", curve, _LEARNED))

    def finish(axes: Axes, _: int) -> None:
        axes.set(ylim=(0.0, 100.0))
        axes.set_xticks(sorted({int(x) for _, curve in found for x, _ in curve}))

    svg = _panels(curves, 2, 1.7, "demonstrations", finish)
    caption = "Rates with 95 % Wilson intervals."
    return Plot("budget", svg, _told(curves, "demonstrations"), caption)


_Curves = Sequence[tuple[str, Curve, plots.Style]]


def _panels(
    curves: _Curves, columns: int, height: float, xlabel: str, finish: Callable[[Axes, int], None]
) -> str:
    """Success rates in small panels with titles, each finished with its place among the curves."""

    def draw(axes: Axes, place: int) -> None:
        title, curve, style = curves[place]
        x, rates = zip(*curve, strict=True) if curve else ((), ())
        low, high = zip(*(rate.interval for rate in rates), strict=True) if rates else ((), ())
        drawn_curve = plots.Curve(title, x, [rate.percent for rate in rates], low, high)
        plots.draw_curve(axes, drawn_curve, style, bars=True)
        axes.set_yticks((0, 50, 100))
        axes.grid(axis="y")
        finish(axes, place)

    titles = [title for title, _, _ in curves]
    return in_panels(titles, draw, columns, height, (xlabel, "dressed [%]"))


def _told(curves: _Curves, unit: str) -> str:
    def rates(curve: Curve) -> str:
        told = [f"{rate.n_success} of {rate.n} at {x:.3g} {unit}" for x, rate in curve]
        return ", ".join(told) or "none, as there are no episodes"

    return ". ".join(f"{title}: dressed {rates(curve)}" for title, curve, _ in curves)
