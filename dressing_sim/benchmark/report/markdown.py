"""``report.md``: the report as plain text."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.analysis.comparisons import label
from dressing_sim.benchmark.records import EpisodeResult, Protocol
from dressing_sim.benchmark.report.figures import hardest
from dressing_sim.benchmark.report.side_by_side import side_by_side
from dressing_sim.benchmark.report.text import (
    COMPARISONS,
    SUCCESS_RULE,
    Cells,
    headline,
    listing,
    markdown_table,
    pair_label,
    paper_cells,
    replay_command,
    table,
)


def markdown(
    folder: Path,
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    summary: Mapping[str, Any],
    command: str,
) -> str:
    """The report that people read without a browser.

    Args:
        folder: Where the run is, for the commands that replay an episode.
        protocol: What was measured.
        results: Its episodes, in any order.
        summary: As from `summarise`.
        command: What was typed to get it.
    """
    ordered = sorted(results, key=lambda result: result.index)
    packages = ", ".join(f"{name} {number}" for name, number in summary["versions"].items())
    blocks = [
        f"# Protocol {protocol.name} on suite {protocol.suite}",
        f"    {command}",
        headline(protocol, summary),
        markdown_table(table(summary)),
        SUCCESS_RULE,
        *_paper(protocol, summary),
        *_side_by_side(summary),
        *_claims(summary),
        *_comparisons(summary),
        *_sets(protocol, summary),
        *_hardest(folder, ordered),
        *_listing(ordered),
        "## Settings",
        "```json\n" + json.dumps(summary["config"], indent=2) + "\n```",
        packages,
    ]
    return "\n\n".join(blocks) + "\n"


def _paper(protocol: Protocol, summary: Mapping[str, Any]) -> Iterator[str]:
    cells = paper_cells(protocol, summary)
    if cells:
        yield "## Next to the paper's table"
        yield markdown_table(cells)
        yield "The paper's trials were made with a real robot, on postures of its own."


def _side_by_side(summary: Mapping[str, Any]) -> Iterator[str]:
    for one in side_by_side(summary):
        yield f"## {one.title}"
        yield markdown_table(one.cells)
        yield one.rule


def _claims(summary: Mapping[str, Any]) -> Iterator[str]:
    if summary["claims"]:
        yield "## The paper's claims"
        yield "\n".join(
            f"* **{claim['verdict']}**: {claim['statement']}. {claim['detail']}"
            for claim in summary["claims"]
        )


def _comparisons(summary: Mapping[str, Any]) -> Iterator[str]:
    if summary["comparisons"]:
        yield "## Pairs of rows, posture by posture"
    for kind, pairs in groupby(summary["comparisons"], key=lambda pair: pair["kind"]):
        yield f"First {COMPARISONS.get(kind, 'less second')}:"
        yield markdown_table(_pair_cells(list(pairs)))
    if summary["comparisons"]:
        yield (
            "Difference of success rates over the same postures and demonstration sets, in "
            "percentage points, with its bootstrap interval; p of McNemar's exact test; P(better) "
            "is the probability of improvement, in which a tie counts half."
        )


def _pair_cells(pairs: Sequence[Mapping[str, Any]]) -> Cells:
    cells = [["first", "second", "pairs", "only first", "only second", "difference"]]
    cells[0] += ["95 % interval", "p", "P(better)"]
    for pair in pairs:
        low, high = pair["pc_difference_ci95"]
        judged = pair["n_pairs"] > 0
        cells.append(
            [
                pair_label(pair["a"]),
                pair_label(pair["b"]),
                str(pair["n_pairs"]),
                str(pair["n_only_a"]),
                str(pair["n_only_b"]),
                f"{pair['pc_difference']:+.3g}" if judged else "-",
                f"{low:+.0f} to {high:+.0f}",
                f"{pair['p_mcnemar']:.3f}",
                f"{pair['probability_of_improvement']:.2f}" if judged else "-",
            ]
        )
    return cells


def _sets(protocol: Protocol, summary: Mapping[str, Any]) -> Iterator[str]:
    cells = [["row", *(f"set {i}" for i in range(protocol.demonstration_sets))]]
    for entry, row in zip(protocol.entries, summary["rows"], strict=True):
        if "sets" in row:
            rates = [f"{one['n_success']} / {one['n_episodes']}" for one in row["sets"]]
            cells.append([label(entry), *rates])
    if len(cells) > 1:
        yield "## Success by demonstration set"
        yield markdown_table(cells)


def _hardest(folder: Path, results: Sequence[EpisodeResult]) -> Iterator[str]:
    found = hardest(results)
    if found:
        cells = [["posture", "elbow", "failed", "to see it"]]
        cells += [
            [
                hard.posture.name,
                f"{hard.posture.elbow_deg:.0f} deg",
                f"{len(hard.failed)} / {hard.n_episodes}",
                f"`{replay_command(folder, hard.pictured)}`",
            ]
            for hard in found
        ]
        yield "## The hardest postures"
        yield markdown_table(cells)


def _listing(results: Sequence[EpisodeResult]) -> Iterator[str]:
    heading, cells = listing(results)
    yield f"## {heading}"
    yield markdown_table(cells)
