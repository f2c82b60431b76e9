"""Puts the tables of measured runs, docs/results/*.json, between the markers in the pages.

A marker is a comment such as ``<!-- full: table -->``; ``<!-- end -->`` closes it. The files are
the ``summary.json`` of runs whose commands stand beside the tables.

    python scripts/fill_tables.py [--check]
"""

from __future__ import annotations

import argparse
import json
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.report.document import tabulate
from dressing_sim.benchmark.report.markdown import markdown_table
from dressing_sim.benchmark.studies.agreement_document import (
    agreement_differing,
    agreement_table,
    headline,
)
from dressing_sim.benchmark.studies.convergence_document import differing_table, validation_table
from dressing_sim.benchmark.studies.convergence_ladders import refinement_table
from dressing_sim.benchmark.studies.cost_document import cost_table
from dressing_sim.benchmark.studies.search_document import trials_table
from dressing_sim.benchmark.studies.success_changes import (
    HYPERPARAMETERS,
    STYLE,
    VARIATION,
    side_by_side,
)
from dressing_sim.benchmark.studies.success_tables import (
    CLAIMS,
    next_to_paper,
    sets_table,
    table,
)
from dressing_sim.benchmark.studies.thresholds_document import sensitivity_table, turned_table
from dressing_sim.files import write_file

ROOT = Path(__file__).resolve().parent.parent
PAGES = (
    "README.md",
    "docs/results.md",
    "docs/convergence.md",
    "docs/thresholds.md",
    "docs/moving.md",
)
MARKER = re.compile(r"(<!-- ([\w-]+): (\w+) -->\n).*?(<!-- end -->)", re.DOTALL)

Summary = Mapping[str, Any]


def ends(summary: Summary) -> str:
    """Algorithm 1's first and last step, of each row, next to the paper's."""
    cost, discarded = summary["paper"]["cost"], summary["paper"]["discarded"]
    cells = [["policy", "shown", "cost, 2 + 0", "cost, 2 + 5", "discarded", "runs that got there"]]
    for row in summary["rows"]:
        first, last = row["steps"][0], row["steps"][-1]
        cells.append(
            [
                row["policy"],
                row["demonstrations"],
                f"{first['cost']:.4f}",
                f"{last['cost']:.4f} ({last['cost_ci95'][0]:.4f} - {last['cost_ci95'][1]:.4f})",
                f"{last['discarded']:.1f}",
                f"{last['n_reached']} / {row['n_runs']}",
            ]
        )
    paper = ["the paper's", "-", f"{cost[0]:g}", f"{cost[-1]:g}", f"{discarded[-1]:g}", "-"]
    return markdown_table([*cells, paper])


def differing(summary: Summary) -> str:
    """Episodes whose verdict differs from the finest's, of settings that agree well enough."""
    agreeing = {
        row["setting"] for row in summary["rows"] if row["agreement"] >= summary["required"]
    }
    chosen = [one for one in summary["differing"] if one["setting"] in agreeing]
    return markdown_table(differing_table(chosen))


BLOCKS: Mapping[str, Callable[[Summary], str]] = {
    "table": lambda summary: markdown_table(table(summary)),
    "paper": lambda summary: markdown_table(next_to_paper(summary["rows"])),
    "settings": lambda summary: markdown_table(side_by_side(summary, HYPERPARAMETERS)),
    "style": lambda summary: markdown_table(side_by_side(summary, STYLE)),
    "variation": lambda summary: markdown_table(side_by_side(summary, VARIATION)),
    "claims": lambda summary: markdown_table(tabulate(summary["claims"], CLAIMS)),
    "sets": lambda summary: markdown_table(sets_table(summary)),
    "ends": ends,
    "cost": lambda summary: markdown_table(cost_table(summary)),
    "convergence": lambda summary: markdown_table(validation_table(summary)),
    "differing": differing,
    "refinement": lambda summary: markdown_table(refinement_table(summary)),
    "sentence": headline,
    "agreement": lambda summary: markdown_table(agreement_table(summary)),
    "disagreement": lambda summary: markdown_table(agreement_differing(summary)),
    "thresholds": lambda summary: markdown_table(sensitivity_table(summary, sources=True)),
    "chosen": lambda summary: markdown_table(trials_table(summary, most=1)),
    "turned": lambda summary: markdown_table(turned_table(summary)),
}


def fill(text: str) -> str:
    """A page with its tables."""

    def block(match: re.Match[str]) -> str:
        start, run, kind, end = match.groups()
        content = (ROOT / "docs" / "results" / f"{run}.json").read_text(encoding="utf-8")
        return f"{start}{BLOCKS[kind](json.loads(content))}\n{end}"

    return MARKER.sub(block, text)


def main() -> None:
    """Fill all pages, or with --check say which are not as they should be."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="change nothing")
    check = parser.parse_args().check
    stale = []
    for page in PAGES:
        path = ROOT / page
        text = path.read_text(encoding="utf-8")
        filled = fill(text)
        if filled != text:
            stale.append(page)
            if not check:
                write_file(path, filled)
    if stale and check:
        sys.exit(f"the tables differ from docs/results in: {', '.join(stale)}")


if __name__ == "__main__":
    main()
