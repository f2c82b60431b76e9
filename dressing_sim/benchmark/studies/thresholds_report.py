"""What the study of thresholds leaves behind: summary.json, report.md, thresholds.svg."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.report import markdown_table
from dressing_sim.benchmark.report.text import pair_label, percent
from dressing_sim.benchmark.run.store import SUMMARY
from dressing_sim.benchmark.studies.thresholds import TOLERATED
from dressing_sim.benchmark.studies.thresholds_plot import sensitivity_figure
from dressing_sim.files import write_text

FIGURE = "thresholds.svg"

#: Factors of which tables show success rates.
SHOWN = (TOLERATED[0], 1.0, TOLERATED[1])

NOTES = (
    "In the figure bands are 95 % Wilson intervals; grey is where a threshold is changed by at "
    "most 20 %.",
    "Success rates stand for the threshold times 0.8, times 1 and times 1.2. Of armscye_s what is "
    "multiplied is the distance to the shoulder at s = 2, of strain_percentile the part of the "
    "cloth's area that is not judged. A greater factor is stricter for hold_time, else looser.",
    "Each episode was simulated once, on after limits were exceeded, and judged anew under every "
    "threshold. The demonstrations are the same throughout: those that the thresholds in use let "
    "pass. Void episodes count neither way.",
    "The ranking of two rows turns if the one that is above with the threshold in use is below "
    "with another; beyond their intervals, if the 95 % bootstrap intervals of both differences, "
    "taken posture by posture, exclude zero.",
)


def sensitivity_table(summary: Mapping[str, Any], sources: bool = False) -> list[list[str]]:
    """The summary as cells of text, the first row the heading.

    Args:
        summary: As from `dressing_sim.benchmark.studies.thresholds_summary.summarise`.
        sources: Whether to say what each threshold means and where it comes from.
    """
    thresholds = summary["thresholds"]
    names = [pair_label(row) for row in thresholds[0]["rows"]]
    told = ["meaning and source"] if sources else []
    heading = ["threshold", "value", "unit", *told, *names, "ranking turned by 20 %"]
    return [
        heading,
        *(
            [
                threshold["name"],
                f"{threshold['value']:g}",
                threshold["unit"],
                *([threshold["source"]] if sources else []),
                *(_rates(row, summary["factors"]) for row in threshold["rows"]),
                _ranking(threshold),
            ]
            for threshold in thresholds
        ),
    ]


def _rates(row: Mapping[str, Any], factors: Sequence[float]) -> str:
    rates = [row["pc_success"][factors.index(factor)] for factor in SHOWN]
    return " / ".join(percent(rate).removesuffix(" %") for rate in rates) + " %"


def _ranking(threshold: Mapping[str, Any]) -> str:
    low, high = TOLERATED
    inside = [turn for turn in threshold["turned"] if low <= turn["factor"] <= high]
    if not threshold["acceptable"]:
        return "yes"
    return "within intervals" if inside else "no"


def headline(summary: Mapping[str, Any]) -> str:
    """The result in a sentence."""
    bad = [t["name"] for t in summary["thresholds"] if not t["acceptable"]]
    if bad:
        return (
            f"Changed by at most 20 %, {' and '.join(bad)} turn the ranking of rows round, beyond "
            "their intervals: not acceptable."
        )
    return (
        "No threshold turns the ranking of two rows round, beyond their intervals, when it is "
        "changed by at most 20 %."
    )


def turned_table(summary: Mapping[str, Any]) -> list[list[str]]:
    """Every turn of a ranking as cells of text, the first row the heading."""
    return [
        ["threshold", "factor", "above", "below", "before", "after", "beyond intervals"],
        *(
            [
                threshold["name"],
                f"{turn['factor']:g}",
                pair_label(turn["above"]),
                pair_label(turn["below"]),
                _difference(turn["before"]),
                _difference(turn["after"]),
                "yes" if turn["beyond_intervals"] else "no",
            ]
            for threshold in summary["thresholds"]
            for turn in threshold["turned"]
        ),
    ]


def _difference(pair: Mapping[str, Any]) -> str:
    low, high = pair["pc_difference_ci95"]
    return f"{pair['pc_difference']:+.3g} ({low:+.0f} to {high:+.0f}), p = {pair['p_mcnemar']:.3f}"


def sensitivity_markdown(summary: Mapping[str, Any], command: str) -> str:
    """The report that people read."""
    void = summary["n_void"]
    turned = turned_table(summary)
    blocks = [
        "# Success rates against the thresholds of success",
        f"    {command}",
        headline(summary) + (f" {void} episodes are void." if void else ""),
        f"![success rate against each threshold]({FIGURE})",
        markdown_table(sensitivity_table(summary, sources=True)),
        *NOTES,
    ]
    if len(turned) > 1:
        blocks += [
            "## Rankings that turn",
            markdown_table(turned),
            "Differences in percentage points, first less second, with their bootstrap interval "
            "and p of McNemar's exact test, with the threshold in use and multiplied.",
        ]
    blocks += [
        "## Settings",
        "```json\n" + json.dumps(summary["config"], indent=2) + "\n```",
        ", ".join(f"{name} {number}" for name, number in summary["versions"].items()),
    ]
    return "\n\n".join(blocks) + "\n"


def write_sensitivity_report(folder: Path, summary: Mapping[str, Any], command: str) -> None:
    """Write the three files of a study; each is whole or not there.

    Raises:
        InvalidInputError: A file cannot be written.
    """
    write_text(folder / FIGURE, sensitivity_figure(summary))
    write_text(folder / "report.md", sensitivity_markdown(summary, command))
    # Last, as it tells that the run is finished.
    write_text(folder / SUMMARY, json.dumps(summary, indent=2) + "\n")
