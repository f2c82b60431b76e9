"""Writes the files of a report."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.report.html import html
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.files import write_files

#: Tells that a run is finished.
SUMMARY = "summary.json"


def write_report(folder: Path, document: Document, summary: Mapping[str, Any]) -> None:
    """Write plots, films, ``report.md``, ``report.html``, ``summary.json``: whole or not at all.

    Raises:
        InvalidInputError: A file cannot be written.
    """
    files: dict[Path, str | bytes] = {
        folder / f"{plot.name}.svg": plot.svg for plot in document.plots
    }
    files |= {folder / f"{film.name}.mp4": film.mp4 for film in document.films}
    files[folder / "report.md"] = markdown(document)
    files[folder / "report.html"] = html(document)
    # Last, as it tells that the run is finished.
    files[folder / SUMMARY] = json.dumps(summary, indent=2) + "\n"
    write_files(files)
