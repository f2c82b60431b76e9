"""What the commands that carry out a study share: workers, progress, interruptions, the end."""

from __future__ import annotations

import json as json_format
import shlex
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console

from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.report.terminal import print_document
from dressing_sim.benchmark.run.dask_workers import DaskWorkers
from dressing_sim.benchmark.run.executors import Processes, Workers
from dressing_sim.benchmark.run.folder import RUN_FILES
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.benchmark.run.progress import Progress, show_progress
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import Study, run_study
from dressing_sim.commands.options import MOST_WORKERS, check_positive
from dressing_sim.files import check_output
from dressing_sim.interrupts import EXIT_CODE
from dressing_sim.system import processors


def carry_out(
    plan: Plan,
    out: Path,
    *,
    workers: int | None,
    scheduler: str | None = None,
    json: bool,
    study: Study[Any, Any] | None = None,
    inputs: Sequence[str] = (),
    remarks: str = "",
    files: str = "report.md, report.html, summary.json",
    **options: bool,
) -> dict[str, Any]:
    """Carry out a study, the plan's if None; print its report, `remarks` and `files`, or JSON.

    `inputs` are files, or names of something else, that the plan was made from. `options` are those
    of `run_study`, such as ``resume``. Ctrl-C is answered by saying how the run goes on, with exit
    code 130.

    Returns:
        The summary.
    """
    check_workers(workers)
    check_folder(out, inputs)
    study = study or find_study(plan.protocol.study)
    with at_work(workers, scheduler) as (crew, progress):
        done = run_study(study, plan, crew, out, progress=progress, command=typed(), **options)
    tell(done.summary, done.document, json, f"{remarks}written to {out}/: {files}")
    return done.summary


def check_folder(out: Path, inputs: Sequence[str] = ()) -> None:
    """Refuse a folder that a run cannot write its files to, or that holds what it is made from."""
    for name in RUN_FILES:
        check_output(out / name, True, inputs)


def typed() -> str:
    """The command line."""
    return f"dressing-sim {shlex.join(sys.argv[1:])}".strip()


def check_workers(workers: int | None) -> int:
    """The number of processes, as many as processors unless given; refused if it makes no sense."""
    count = processors() if workers is None else workers
    check_positive("workers", count, MOST_WORKERS)
    return count


@contextmanager
def at_work(
    workers: int | None, scheduler: str | None = None
) -> Iterator[tuple[Workers, Progress]]:
    """Workers, and who tells how far they are; on Ctrl-C says how what they did goes on."""
    count = check_workers(workers)
    try:
        with (
            Processes(count) if scheduler is None else DaskWorkers(scheduler) as crew,
            show_progress(Console(stderr=True)) as progress,
        ):
            yield crew, progress
    except KeyboardInterrupt:
        again = typed() if "--resume" in sys.argv else f"{typed()} --resume"
        print(f"dressing-sim: interrupted; to continue: {again}", file=sys.stderr)
        raise SystemExit(EXIT_CODE) from None


def tell(summary: Mapping[str, Any], document: Document, json: bool, written: str) -> None:
    """Print the summary as JSON, or the report and what was written."""
    if json:
        print(json_format.dumps(summary, indent=2))
    else:
        print_document(document)
        print(written)
