"""``dressing-sim thresholds``: how success rates hang on the thresholds of success."""

from __future__ import annotations

import json as json_format
from dataclasses import replace
from pathlib import Path

from rich.console import Console

from dressing_sim.commands.options import (
    check_positive,
    check_seed,
    command_line,
    names,
    resumable,
)
from dressing_sim.files import check_writable
from dressing_sim.system import processors


def thresholds(
    suite: str = "val50",
    policies: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/thresholds"),
    resume: bool = False,
    accept_numerics: bool = False,
    json: bool = False,
) -> None:
    """Measure how success rates, and the ranking of policies, hang on each threshold of success.

    Every episode is simulated once, on after limits were exceeded, and judged with each threshold
    multiplied by 0.5 to 1.5. Writes episodes.jsonl, summary.json, report.md, report.html and
    thresholds.svg.

    For example: dressing-sim thresholds

    Or: dressing-sim thresholds --suite random:20 --policies expert,tp-gmm --workers 4

    Args:
        suite: test postures: a name, a JSON file, or random:N.
        policies: other policies than the study's, separated by commas, each learning from all of
            its demonstrations: expert, tp-gmm, tp-gmm-rf, the name of an installed one, or
            module:Class.
        seed: of the operator's variability, and of the policies' own randomness.
        workers: processes, as many as processors unless given; the results do not depend on it.
        out: folder for the results; a finished run in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.report.terminal import print_document
    from dressing_sim.benchmark.run.executors import Processes
    from dressing_sim.benchmark.run.progress import show_progress
    from dressing_sim.benchmark.studies import find_study
    from dressing_sim.benchmark.studies.study import run_study
    from dressing_sim.benchmark.studies.thresholds import PROTOCOL, thresholds_plan

    protocol = replace(PROTOCOL, suite=suite)
    if policies is not None:
        protocol = protocol.with_policies(names(policies))
    count = processors() if workers is None else workers
    check_positive("workers", count)
    check_seed(seed)
    plan = thresholds_plan(protocol, seed)
    check_writable(out / "report.md")
    study = find_study(protocol.study)
    with (
        resumable(),
        Processes(count) as crew,
        show_progress(Console(stderr=True)) as progress,
    ):
        finished = run_study(
            study,
            plan,
            crew,
            out,
            resume=resume,
            accept_numerics=accept_numerics,
            progress=progress,
            command=command_line(),
        )
    if json:
        print(json_format.dumps(finished.summary, indent=2))
    else:
        print_document(finished.document)
        print(f"written to {out}/: report.md, report.html, thresholds.svg, summary.json")
