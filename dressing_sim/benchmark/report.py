"""What a protocol's run leaves behind: ``episodes.jsonl``, ``summary.json``, ``report.md``."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.protocol import Entry, Protocol
from dressing_sim.benchmark.runner import EpisodeResult
from dressing_sim.benchmark.statistics import wilson_interval
from dressing_sim.demonstration import versions
from dressing_sim.files import write_text
from dressing_sim.judge import count_reasons


def summarise(
    protocol: Protocol, results: Sequence[EpisodeResult], settings: Mapping[str, Any]
) -> dict[str, Any]:
    """Success rates by row, with Wilson intervals; void episodes count neither way.

    Returns:
        ``{"rows": [...], "versions": {...}, "config": {...}}``, percentages from 0 to 100.
    """
    return {
        "rows": [
            _row(entry, [r for r in results if r.entry == entry]) for entry in protocol.entries
        ],
        "versions": versions(),
        "config": {"protocol": protocol.name, "suite": protocol.suite, **settings},
    }


def _row(entry: Entry, results: Sequence[EpisodeResult]) -> dict[str, Any]:
    valid = [result.outcome for result in results if result.outcome.void is None]
    successes = sum(outcome.success for outcome in valid)
    low, high = wilson_interval(successes, len(valid))
    return {
        "policy": entry.policy,
        "demonstrations": entry.demonstrations,
        "n_episodes": len(valid),
        "n_success": successes,
        "pc_success": 100.0 * successes / len(valid) if valid else None,
        "pc_success_ci95": [100.0 * low, 100.0 * high],
        "failures": count_reasons(valid),
        "n_void": len(results) - len(valid),
    }


def episode_line(protocol: Protocol, result: EpisodeResult) -> str:
    """One line of ``episodes.jsonl``."""
    return json.dumps(
        {
            "protocol": protocol.name,
            "policy": result.entry.policy,
            "demonstrations": result.entry.demonstrations,
            "posture": result.posture.to_dict(),
            "seed": result.seed,
            **result.outcome.to_dict(),
            "versions": versions(),
        }
    )


def table(summary: Mapping[str, Any]) -> list[list[str]]:
    """The summary as cells of text, the first row the heading."""
    rows = [["policy", "shown", "success", "rate", "95 % interval", "what went wrong"]]
    for row in summary["rows"]:
        low, high = row["pc_success_ci95"]
        rate = "-" if row["pc_success"] is None else f"{row['pc_success']:.0f} %"
        reasons = ", ".join(f"{reason} {n}" for reason, n in row["failures"].items())
        void = f"{row['n_void']} void" if row["n_void"] else ""
        rows.append(
            [
                row["policy"],
                row["demonstrations"] or "-",
                f"{row['n_success']} / {row['n_episodes']}",
                rate,
                f"{low:.0f} - {high:.0f} %",
                ", ".join(filter(None, [reasons, void])) or "-",
            ]
        )
    return rows


def markdown_table(cells: Sequence[Sequence[str]]) -> str:
    """Cells of text, heading first, as a Markdown table."""
    heading, *body = cells
    lines = [heading, ["---"] * len(heading), *body]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def markdown(
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    summary: Mapping[str, Any],
    command: str,
) -> str:
    """The report that people read."""
    episodes = [["policy", "shown", "posture", "elbow", "outcome", "armscye s", "strain", "pull"]]
    for result in results:
        figures = result.outcome.figures
        verdict = "success" if result.outcome.success else ", ".join(result.outcome.reasons)
        episodes.append(
            [
                result.entry.policy,
                result.entry.demonstrations or "-",
                result.posture.name,
                f"{result.posture.elbow_deg:.0f} deg",
                f"void: {result.outcome.void}" if result.outcome.void else verdict,
                *(
                    _figure(figures, name, unit)
                    for name, unit in (("armscye_s", ""), ("strain", ""), ("grip_force", " N"))
                ),
            ]
        )
    packages = ", ".join(f"{name} {number}" for name, number in summary["versions"].items())
    return "\n".join(
        [
            f"# Protocol {protocol.name} on suite {protocol.suite}",
            "",
            f"    {command}",
            "",
            markdown_table(table(summary)),
            "",
            "Success: the sleeve is on, up to the shoulder; the robot touched nobody; the cloth "
            "was neither stretched nor pulled too far. One episode can fail for several reasons. "
            "Intervals are Wilson's.",
            "",
            "## Episodes",
            "",
            markdown_table(episodes),
            "",
            "## Settings",
            "",
            "```json",
            json.dumps(summary["config"], indent=2),
            "```",
            "",
            packages,
            "",
        ]
    )


def _figure(figures: Mapping[str, float], name: str, unit: str) -> str:
    return f"{figures[name]:.2f}{unit}" if name in figures else "-"


def write_report(
    folder: Path,
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    summary: Mapping[str, Any],
    command: str,
) -> None:
    """Write the three files of a run; each is whole or not there."""
    write_text(
        folder / "episodes.jsonl", "".join(episode_line(protocol, r) + "\n" for r in results)
    )
    write_text(folder / "summary.json", json.dumps(summary, indent=2) + "\n")
    write_text(folder / "report.md", markdown(protocol, results, summary, command))
