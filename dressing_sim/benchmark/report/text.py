"""Tables and sentences that the terminal, ``report.md`` and ``report.html`` share."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.analysis.comparisons import label
from dressing_sim.benchmark.analysis.paper_table import next_to_paper
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.episode.rules import Outcome, count_reasons
from dressing_sim.policies.registry import EXPERT

#: With more episodes than this a report lists postures instead.
MOST_EPISODES_LISTED = 60

SUCCESS_RULE = (
    "Success: the sleeve is on, up to the shoulder; the robot touched nobody; the cloth was "
    "neither stretched nor pulled too far. One episode can fail for several reasons. Intervals of "
    "rates are Wilson's, for the demonstrations that were given; over sets they are bootstrap "
    "intervals for other demonstrations too. Void episodes count neither way."
)

#: What the kinds of comparison are called, see `dressing_sim.benchmark.analysis.comparisons`.
COMPARISONS = {
    "augmentation": "with synthetic demonstrations, less without",
    "policy": "less the paper's initial policy, shown the same demonstrations",
    "baseline": "less the policy that was shown seven demonstrations",
    "case": "shown distinct postures, less shown similar ones",
    "variation": "under variation, less without",
    "settings": "with other settings, less as chosen",
}

Cells = list[list[str]]


def table(summary: Mapping[str, Any]) -> Cells:
    """The summary's rows as cells of text, the first row the heading."""
    varied = any(row["variation"] for row in summary["rows"])
    over_sets = any("pc_success_ci95_sets" in row for row in summary["rows"])
    # Of who learns nothing it is known that he sees the whole arm.
    learned = [row for row in summary["rows"] if row["demonstrations"] is not None]
    classes = any(row.get("inputs", "frames") != "frames" for row in learned)
    cells = [
        [
            "policy",
            "shown",
            *(["inputs"] if classes else []),
            *(["varied"] if varied else []),
            "success",
            "rate",
            "95 % interval",
            *(["over sets"] if over_sets else []),
            "what went wrong",
        ]
    ]
    for row in summary["rows"]:
        void = f"{row['n_void']} void" if row["n_void"] else ""
        cells.append(
            [
                row["policy"],
                row["demonstrations"] or "-",
                *([row["inputs"]] if classes else []),
                *([", ".join(row["variation"]) or "-"] if varied else []),
                f"{row['n_success']} / {row['n_episodes']}",
                percent(row["pc_success"]),
                _between(row["pc_success_ci95"]),
                *([_between(row.get("pc_success_ci95_sets"))] if over_sets else []),
                ", ".join(filter(None, [counted(row["failures"]), void])) or "-",
            ]
        )
    return cells


def _between(interval: Sequence[float] | None) -> str:
    return "-" if interval is None else f"{interval[0]:.0f} - {interval[1]:.0f} %"


def interval(row: Mapping[str, Any]) -> Sequence[float]:
    """The 95 % interval of a row's rate [%], for other demonstrations too where that is known."""
    bounds: Sequence[float] = row.get("pc_success_ci95_sets", row["pc_success_ci95"])
    return bounds


def paper_cells(protocol: Protocol, summary: Mapping[str, Any]) -> Cells:
    """The summary's rows next to the paper's; none unless the protocol, and some row, is its."""
    cells = next_to_paper(summary["rows"])
    return cells if protocol.name == "paper" and len(cells) > 1 else []


def markdown_table(cells: Sequence[Sequence[str]]) -> str:
    """Cells of text, heading first, as a Markdown table."""
    heading, *body = cells
    lines = [heading, ["---"] * len(heading), *body]
    return "\n".join("| " + " | ".join(map(_in_cell, line)) + " |" for line in lines)


def _in_cell(text: str) -> str:
    """A cell's text, in which a bar or a line's end would begin another cell or line."""
    return " ".join(text.replace("|", "\\|").splitlines())


def percent(value: float | None) -> str:
    """A percentage for people; a rate of no trials is a dash.

    Of three digits, so that of two hundred episodes rates and their differences are exact.
    """
    return "-" if value is None else f"{value:.3g} %"


def headline(protocol: Protocol, summary: Mapping[str, Any]) -> str:
    """The result in two sentences: the best rows that learned, and the expert's.

    Of the rows in the nominal world, if there are any.
    """
    every = [
        (entry, row)
        for entry, row in zip(protocol.entries, summary["rows"], strict=True)
        if row["pc_success"] is not None
    ]
    nominal = [(entry, row) for entry, row in every if not entry.variation]
    rows = [(label(entry), row) for entry, row in nominal or every]
    learned = [(name, row) for name, row in rows if row["demonstrations"] is not None]
    most = max((row["pc_success"] for _, row in learned), default=None)
    best = [(name, row) for name, row in learned if row["pc_success"] == most]
    sentences = []
    if len(best) == 1:
        name, row = best[0]
        sentences.append(f"Of the policies that learned, {name} did best: {_dressed(row)}.")
    elif best:
        *others, last = (name for name, _ in best)
        names = "all" if len(best) == len(learned) else f"{', '.join(others)} and {last}"
        sentences.append(
            f"Of the policies that learned, {names} did equally well: {percent(most)} dressed."
        )
    sentences += [
        f"The {name}, who sees the whole arm, dressed {_dressed(row)}."
        for name, row in rows
        if row["policy"] == EXPERT
    ]
    return " ".join(sentences) or "No episode could be judged."


def _dressed(row: Mapping[str, Any]) -> str:
    low, high = interval(row)
    return (
        f"{row['n_success']} of {row['n_episodes']} arms ({percent(row['pc_success'])}, "
        f"95 % interval {low:.0f} to {high:.0f} %)"
    )


def listing(results: Sequence[EpisodeResult]) -> tuple[str, Cells]:
    """What a report lists: every episode or, where there are many, every posture.

    Args:
        results: Episodes in the order of the protocol.

    Returns:
        What it is a list of, and its cells of text, the first row the heading.
    """
    if len(results) <= MOST_EPISODES_LISTED:
        return "Episodes", _episodes(results)
    return "Postures", _postures(results)


def _episodes(results: Sequence[EpisodeResult]) -> Cells:
    varied = any(result.entry.variation for result in results)
    cells = [["episode", "policy", "shown", *(["varied"] if varied else []), "posture", "elbow"]]
    cells[0] += ["outcome", "armscye s", "strain", "pull"]
    for result in results:
        outcome = result.outcome
        cells.append(
            [
                str(result.index),
                result.entry.policy,
                result.entry.demonstrations or "-",
                *([", ".join(result.entry.variation) or "-"] if varied else []),
                result.posture.name,
                f"{result.posture.elbow_deg:.0f} deg",
                verdict(outcome),
                *(
                    f"{outcome.metrics[name]:.2f}{unit}" if name in outcome.metrics else "-"
                    for name, unit in (("armscye_s", ""), ("strain", ""), ("grip_force", " N"))
                ),
            ]
        )
    return cells


def verdict(outcome: Outcome) -> str:
    """A verdict in words: success, all that went wrong, or why it is void."""
    if outcome.invalid is not None:
        return f"void: {outcome.invalid}"
    return "success" if outcome.success else ", ".join(outcome.reasons)


def _postures(results: Sequence[EpisodeResult]) -> Cells:
    groups: dict[str, list[EpisodeResult]] = {}
    for result in results:
        groups.setdefault(result.posture.name, []).append(result)
    cells = [["posture", "elbow", "dressed", "what went wrong"]]
    for name, group in groups.items():
        outcomes = [result.outcome for result in group if result.outcome.invalid is None]
        void = f"{len(group) - len(outcomes)} void" if len(outcomes) < len(group) else ""
        cells.append(
            [
                name,
                f"{group[0].posture.elbow_deg:.0f} deg",
                f"{sum(outcome.success for outcome in outcomes)} / {len(outcomes)}",
                ", ".join(filter(None, [counted(count_reasons(outcomes)), void])) or "-",
            ]
        )
    return cells


def counted(reasons: Mapping[str, int]) -> str:
    """How often each reason occurred, in a line."""
    return ", ".join(f"{reason} {n}" for reason, n in reasons.items())


def pair_label(row: Mapping[str, Any]) -> str:
    """What a side of a comparison is called."""
    return label(Entry(row["policy"], row["demonstrations"], tuple(row["variation"])))


def replay_command(folder: Path, result: EpisodeResult) -> str:
    """What to type to see an episode of a run again."""
    return f"dressing-sim replay {shlex.quote(str(folder))} {result.index} --video film.mp4"
