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
        resume: continue the run in the folder, if there is one, with the same settings.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.report.terminal import print_document
    from dressing_sim.benchmark.report.write import write_report
    from dressing_sim.benchmark.run.executors import Processes
    from dressing_sim.benchmark.run.plan import make_plan
    from dressing_sim.benchmark.run.progress import show_progress
    from dressing_sim.benchmark.run.runner import Work, run_plan
    from dressing_sim.benchmark.run.store import open_run
    from dressing_sim.benchmark.studies.thresholds import PROTOCOL, dress_job
    from dressing_sim.benchmark.studies.thresholds_document import thresholds_document
    from dressing_sim.benchmark.studies.thresholds_summary import summarise
    from dressing_sim.config import to_plain
    from dressing_sim.episode.config import EpisodeConfig

    protocol = replace(PROTOCOL, suite=suite)
    if policies is not None:
        protocol = protocol.with_policies(names(policies))
    count = processors() if workers is None else workers
    check_positive("workers", count)
    check_seed(seed)
    check_writable(out / "report.md")
    config = EpisodeConfig(protective_stop=False)
    plan = make_plan(protocol, seed, config)
    with (
        resumable(),
        Processes(count) as crew,
        open_run(out, plan, resume, crew.numerics, accept_numerics) as folder,
        show_progress(Console(stderr=True)) as progress,
    ):
        results = run_plan(folder, crew, progress, Work(dress=dress_job))
        summary = summarise(
            protocol, results, config.thresholds, {"seed": seed, "episode": to_plain(config)}
        )
        summary["provenance"] = dict(folder.origin.provenance)
        document = thresholds_document(summary, command_line())
        write_report(out, document, summary)
    if json:
        print(json_format.dumps(summary, indent=2))
    else:
        print_document(document)
        print(f"written to {out}/: report.md, report.html, thresholds.svg, summary.json")
