"""Writes the files of a report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.records import EpisodeResult, Protocol
from dressing_sim.benchmark.report.cards import Picture
from dressing_sim.benchmark.report.html import page
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.run.store import SUMMARY
from dressing_sim.files import write_text


def write_report(
    folder: Path,
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    summary: Mapping[str, Any],
    command: str,
    picture: Picture | None = None,
) -> None:
    """Write ``report.md``, ``report.html`` and ``summary.json``; each is whole or not there.

    Args:
        folder: Of the run; reports name it as it is given, in commands that replay an episode.
        protocol: What was measured.
        results: Its episodes, in any order.
        summary: As from `summarise`.
        command: What was typed to get it.
        picture: Draws the failed episodes of the hardest postures, for the page.

    Raises:
        InvalidInputError: A file cannot be written.
    """
    html = page(folder, protocol, results, summary, command, picture)
    write_text(folder / "report.md", markdown(folder, protocol, results, summary, command))
    write_text(folder / "report.html", html)
    # Last, as it tells that the run is finished.
    write_text(folder / SUMMARY, json.dumps(summary, indent=2) + "\n")
