"""``dressing-sim practise``: what demonstrations leave open, tried out on simulated arms."""

from __future__ import annotations

from pathlib import Path

import tyro

from dressing_sim.commands.options import check_positive, check_seed


def practise(
    policy: tyro.conf.Positional[str] = "transport",
    demonstrations: str = "case_a",
    postures: int = 12,
    generations: int = 10,
    population: int = 8,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/practice"),
    resume: bool = False,
    force: bool = False,
    json: bool = False,
) -> None:
    """Let a policy practise: choose a few of its parameters by dressing simulated arms.

    The arms are drawn for practice alone, half of them with strongly bent elbows. CMA-ES keeps the
    dressings as far from their limits as it can. What comes out is a policy's name with
    hyper-parameters, for `evaluate --policies`: a new arm needs no simulation. About a thousand
    episodes. Needs the extra `practice`.

    Writes summary.json, report.md and report.html, and a run's folder for each generation.

    For example: dressing-sim practise transport --demonstrations case_a --out results/practice-a

    Args:
        policy: transport, perhaps with ?name=value&... for other hyper-parameters.
        demonstrations: suite that it learns from: case_a, case_b, baseline7, or another one.
        postures: how many arms each try dresses.
        generations: of CMA-ES.
        population: tries in a generation.
        seed: of the arms, of CMA-ES, and of the operator's variability.
        workers: processes, as many as processors unless given; the results do not depend on it.
        out: folder for the results.
        resume: continue what is in the folder, if there is something, with the same config.
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
    from dressing_sim.benchmark.studies.practice import Practice
    from dressing_sim.benchmark.studies.practice import practise as carry_out
    from dressing_sim.benchmark.studies.practice_document import practice_document
    from dressing_sim.commands.options import MOST_WORKERS
    from dressing_sim.extras import needed
    from dressing_sim.files import check_output
    from dressing_sim.interrupts import EXIT_CODE
    from dressing_sim.policies.registry import make_policy
    from dressing_sim.suites.suites import demonstration_postures
    from dressing_sim.system import processors

    count = processors() if workers is None else workers
    check_positive("workers", count, MOST_WORKERS)
    check_seed(seed)
    what = Practice(policy, demonstrations, postures, generations, population, seed)
    make_policy(policy)
    what.check()
    demonstration_postures(demonstrations)
    needed("cmaes", "practice")
    for name in ("summary.json", "report.md", "report.html"):
        check_output(out / name, resume or force, [])
    command = f"dressing-sim {shlex.join(sys.argv[1:])}".strip()
    try:
        with Processes(count) as crew, show_progress(Console(stderr=True)) as progress:
            found = carry_out(what, crew, out, resume, force, progress)
    except KeyboardInterrupt:
        again = command if "--resume" in sys.argv else f"{command} --resume"
        print(f"dressing-sim: interrupted; to continue: {again}", file=sys.stderr)
        raise SystemExit(EXIT_CODE) from None
    document = practice_document(found, command)
    write_report(out, document, found)
    if json:
        print(json_format.dumps(found, indent=2))
    else:
        print_document(document)
        print(f"written to {out}/: report.md, report.html, summary.json")
