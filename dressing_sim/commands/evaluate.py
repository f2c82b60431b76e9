"""``dressing-sim evaluate``: the table of a protocol."""

from __future__ import annotations

import json as json_format
from dataclasses import replace
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from rich.console import Console

from dressing_sim.commands.options import (
    check_positive,
    check_seed,
    command_line,
    names,
    resumable,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_writable
from dressing_sim.system import processors

if TYPE_CHECKING:
    from dressing_sim.benchmark.report.document import Document
    from dressing_sim.benchmark.run.executors import Workers
    from dressing_sim.benchmark.run.runner import Progress
    from dressing_sim.benchmark.run.store import OpenRun


def evaluate(
    protocol: str = "paper",
    suite: str | None = None,
    policies: str | None = None,
    variation: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    out: Path = Path("results/evaluate"),
    resume: bool = False,
    accept_numerics: bool = False,
    pictures: bool = True,
    json: bool = False,
) -> None:
    """Measure how often policies dress an arm in a posture that they were not shown.

    Demonstrations are recorded in the simulator, the policies learn from them, and each dresses
    every test posture once. Each finished episode is on disk at once: a run that ended early, for
    whatever reason, goes on with --resume. Writes episodes.jsonl, summary.json, report.md and
    report.html.

    For example: dressing-sim evaluate

    Or: dressing-sim evaluate --suite random:20 --policies expert,tp-gmm --workers 4

    Or: dressing-sim evaluate --policies mypackage.policies:MyPolicy --out results/mine

    Or: dressing-sim evaluate --scheduler tcp://10.0.0.1:8786 --out results/cluster --resume

    Args:
        protocol: which policies learn from which demonstrations: paper, full, budget, robust,
            settings; or paper-cost, what the learning costs without dressing anybody.
        suite: test postures instead of the protocol's: a name, a JSON file, or random:N.
        policies: other policies than the protocol's, separated by commas: expert, default,
            tp-gmm, the name of an installed one, or module:Class, each with ?name=value&...
            for its hyper-parameters.
        variation: factors drawn anew for each episode, separated by commas: friction, fabric,
            garment, arm, grasp.
        seed: of the operator's variability, of the policies' own randomness, and of variation.
        workers: processes, as many as processors unless given; the results do not depend on it.
        scheduler: address of a Dask scheduler whose workers are used instead of processes here.
        out: folder for the results; a finished run in it is replaced.
        resume: continue the run in the folder, if there is one, with the same settings.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        pictures: draw the hardest postures in report.html, which runs their episodes again.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.report.terminal import print_document
    from dressing_sim.benchmark.report.write import write_report
    from dressing_sim.benchmark.run.plan import make_plan
    from dressing_sim.benchmark.run.progress import show_progress
    from dressing_sim.benchmark.run.store import open_run
    from dressing_sim.benchmark.studies.success import find_protocol
    from dressing_sim.policies.paper import any_of_the_paper, left_open

    chosen = find_protocol(protocol)
    if chosen.kind == "cost" and (suite, policies, variation) != (None, None, None):
        raise InvalidInputError(
            f"protocol {protocol!r} dresses nobody: --suite, --policies, --variation do not apply"
        )
    if policies is not None:
        chosen = chosen.with_policies(names(policies))
    if variation is not None:
        chosen = chosen.with_variation(names(variation))
    if suite is not None:
        chosen = replace(chosen, suite=suite)
    if workers is not None and scheduler is not None:
        raise InvalidInputError("--workers and --scheduler exclude each other")
    check_positive("workers", processors() if workers is None else workers)
    check_seed(seed)
    check_writable(out / "report.md")
    plan = make_plan(chosen, seed)
    command = command_line()
    with (
        resumable(),
        _workers(workers, scheduler) as crew,
        open_run(out, plan, resume, crew.numerics, accept_numerics) as folder,
        show_progress(Console(stderr=True)) as progress,
    ):
        if chosen.kind == "cost":
            summary, document = _cost(folder, crew, progress, command)
        else:
            summary, document = _success(folder, crew, progress, command, pictures)
        write_report(folder.path, document, summary)
    if json:
        print(json_format.dumps(summary, indent=2))
    else:
        print_document(document)
        if any_of_the_paper(row["policy"] for row in summary["rows"]):
            told = f"policies: {left_open()}"
            print(fill(told, 100, subsequent_indent="  ", break_on_hyphens=False))
        print(f"written to {out}/: report.md, report.html, summary.json")


def _workers(count: int | None, scheduler: str | None) -> Workers:
    from dressing_sim.benchmark.run.dask_workers import DaskWorkers
    from dressing_sim.benchmark.run.executors import Processes

    if scheduler is not None:
        return DaskWorkers(scheduler)
    return Processes(processors() if count is None else count)


def _success(
    folder: OpenRun, crew: Workers, progress: Progress, command: str, pictures: bool
) -> tuple[dict[str, Any], Document]:
    """Summary and report of a protocol that is made of episodes."""
    from dressing_sim.benchmark.run.runner import repeated_demonstrations, run_plan
    from dressing_sim.benchmark.studies.pictures import failure_pictures
    from dressing_sim.benchmark.studies.success_document import success_document
    from dressing_sim.benchmark.studies.success_summary import summarise
    from dressing_sim.config import to_plain
    from dressing_sim.policies.paper import plain_config

    plan = folder.plan
    results = run_plan(folder, crew, progress)
    settings = {
        "seed": plan.seed,
        "repeated_demonstrations": repeated_demonstrations(folder),
        "policies": plain_config(),
        "episode": to_plain(plan.config),
    }
    summary = summarise(plan.protocol, results, settings)
    summary["provenance"] = dict(folder.origin.provenance)
    drawn = failure_pictures(folder, results) if pictures else None
    document = success_document(folder.path, plan.protocol, results, summary, command, drawn)
    return summary, document


def _cost(
    folder: OpenRun, crew: Workers, progress: Progress, command: str
) -> tuple[dict[str, Any], Document]:
    """Summary and report of what Algorithm 1 costs."""
    from dressing_sim.benchmark.run.runner import record_demonstrations
    from dressing_sim.benchmark.studies.cost import run_paper_cost
    from dressing_sim.benchmark.studies.cost_document import cost_document

    shown = record_demonstrations(folder, crew, progress)
    recorded = {name: demonstrations for (name, _), demonstrations in shown.items()}
    summary = run_paper_cost(crew, recorded, folder.plan.seed, progress)
    summary["provenance"] = dict(folder.origin.provenance)
    return summary, cost_document(summary, command)
