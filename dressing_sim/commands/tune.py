"""``dressing-sim tune``: hyper-parameters of a policy, chosen on the validation suite."""

from __future__ import annotations

from pathlib import Path

import tyro

from dressing_sim.commands.options import MOST_WORKERS, check_positive, check_seed


def tune(
    policy: tyro.conf.Positional[str],
    trials: int = 60,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/tune"),
    resume: bool = False,
    force: bool = False,
    json: bool = False,
) -> None:
    """Search a policy's hyper-parameters on val50, never on a test suite.

    The same budget for every policy: a Sobol design of trials, the policy as it is among them,
    learns from case A and from case B; all dress five postures, the best quarter sixteen, and the
    best of those fifty. About half an hour on two cores.

    Writes summary.json, report.md and report.html, and a run's folder for each rung.

    For example: dressing-sim tune tp-gmm --out results/tune-tp-gmm

    Args:
        policy: tp-gmm, tp-gmm-noise, tp-gmm-rf, tp-gmm-rf-noise or transport.
        trials: how many sets of hyper-parameters are tried.
        seed: of the design, of the operator's variability, and of the policies' own randomness.
        workers: processes, as many as processors unless given; the results do not depend on it.
        out: folder for the results.
        resume: continue the search in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        json: print what was found as JSON, and nothing else, to standard output.
    """
    import json as json_format
    import shlex
    import sys

    from rich.console import Console

    from dressing_sim.benchmark.report.terminal import print_document
    from dressing_sim.benchmark.report.write import write_report
    from dressing_sim.benchmark.run.executors import Processes
    from dressing_sim.benchmark.run.progress import show_progress
    from dressing_sim.benchmark.studies.search import Search, search
    from dressing_sim.benchmark.studies.search_document import search_document
    from dressing_sim.files import check_output
    from dressing_sim.system import processors

    count = processors() if workers is None else workers
    check_positive("workers", count, MOST_WORKERS)
    check_seed(seed)
    what = Search(policy, trials, seed)
    what.names()  # an unknown policy shows before anything runs
    for name in ("summary.json", "report.md", "report.html"):
        check_output(out / name, resume or force, [policy])
    with Processes(count) as crew, show_progress(Console(stderr=True)) as progress:
        found = search(what, crew, out, resume, force, progress)
    document = search_document(found, f"dressing-sim {shlex.join(sys.argv[1:])}".strip())
    write_report(out, document, found)
    if json:
        print(json_format.dumps(found, indent=2))
    else:
        print_document(document)
        print(f"written to {out}/: report.md, report.html, summary.json")
