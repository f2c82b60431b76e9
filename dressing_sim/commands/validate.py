"""``dressing-sim validate``: do verdicts depend on the solver?"""

from __future__ import annotations

import json as json_format
from pathlib import Path

from rich.console import Console

from dressing_sim.commands.options import (
    check_positive,
    check_seed,
    command_line,
    names,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_writable
from dressing_sim.system import processors


def validate(
    suite: str = "val50",
    postures: int = 15,
    only: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/validate"),
    json: bool = False,
) -> None:
    """Compare verdicts over mesh, time step, iterations, tolerance and solver.

    Four paths (the operator's, a straight one, one too low, one too high) on each posture, with
    seventeen settings, against the finest of them. About a quarter of an hour on two cores. Exit
    code 1 if the default settings agree with the finest on less than 95 % of verdicts, if the
    median episode's strain or pull is off by more than 5 % of its limit, or if the solver is more
    than 5 % off a converged one in strain or pull, or no dressing succeeds to tell.
    Writes summary.json, episodes.jsonl, report.md, report.html and convergence.svg.

    For example: dressing-sim validate --json

    Or: dressing-sim validate --postures 5 --only "coarse mesh,double step"

    Args:
        suite: postures: a name, a JSON file, or random:N.
        postures: how many of them, from the first.
        only: settings to try, separated by commas, besides default, finest and tolerance 1e-12
            (a converged solver), which are always included.
        seed: of the operator's variability.
        workers: processes, as many as processors unless given; verdicts do not depend on it.
        out: folder for the results.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.report.terminal import print_document
    from dressing_sim.benchmark.report.write import write_report
    from dressing_sim.benchmark.run.executors import Processes
    from dressing_sim.benchmark.run.progress import show_progress
    from dressing_sim.benchmark.run.store import SETTINGS
    from dressing_sim.benchmark.studies.convergence import (
        CONVERGED,
        DEFAULT,
        FINEST,
        settings,
        write_trials,
    )
    from dressing_sim.benchmark.studies.convergence import validate as study
    from dressing_sim.benchmark.studies.convergence_document import convergence_document
    from dressing_sim.benchmark.studies.convergence_summary import compare
    from dressing_sim.provenance import provenance
    from dressing_sim.suites.suites import load_suite

    workers = processors() if workers is None else workers
    check_positive("workers", workers)
    check_positive("postures", postures)
    check_seed(seed)
    chosen = settings()
    if only is not None:
        wanted = {name for name in names(only) if name}
        unknown = sorted(wanted - {setting.name for setting in chosen})
        if unknown:
            valid = ", ".join(setting.name for setting in chosen)
            raise InvalidInputError(f"unknown setting {unknown[0]!r}; valid is one of {valid}")
        chosen = tuple(s for s in chosen if s.name in {DEFAULT, FINEST, CONVERGED, *wanted})
    arms = load_suite(suite)[:postures]
    check_writable(out / "report.md")
    if (out / SETTINGS).exists():
        raise InvalidInputError(f"{out} holds a run of another command; choose another --out")
    with Processes(workers) as crew, show_progress(Console(stderr=True)) as progress:
        trials = study(arms, chosen, crew, seed, progress)
    summary = {**compare(trials, chosen), "provenance": provenance()}
    document = convergence_document(trials, summary, command_line())
    write_trials(out, trials)
    write_report(out, document, summary)
    if json:
        print(json_format.dumps(summary, indent=2))
    else:
        print_document(document)
        files = "report.md, report.html, convergence.svg, summary.json, episodes.jsonl"
        print(f"written to {out}/: {files}")
    if not summary["passed"]:
        raise SystemExit(1)
