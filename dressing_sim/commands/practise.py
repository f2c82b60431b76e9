"""``dressing-sim practise``: what demonstrations leave open, tried out on simulated arms."""

from __future__ import annotations

from pathlib import Path

import tyro

from dressing_sim.commands.options import check_seed


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
    from dressing_sim.benchmark.report.write import write_report
    from dressing_sim.benchmark.studies.practice import Practice
    from dressing_sim.benchmark.studies.practice import practise as carry_out
    from dressing_sim.benchmark.studies.practice_document import practice_document
    from dressing_sim.commands.studies import at_work, check_workers, tell, typed
    from dressing_sim.extras import needed
    from dressing_sim.files import check_output
    from dressing_sim.policies.registry import known_name, make_policy
    from dressing_sim.suites.suites import load_suite

    check_workers(workers)
    check_seed(seed)
    what = Practice(known_name(policy), demonstrations, postures, generations, population, seed)
    make_policy(policy)
    what.check()
    load_suite(demonstrations)
    needed("cmaes", "practice")
    files = "report.md", "report.html", "summary.json"
    for name in files:
        check_output(out / name, resume or force, [])
    with at_work(workers) as (crew, progress):
        found = carry_out(what, crew, out, resume, force, progress)
    document = practice_document(found, typed())
    write_report(out, document, found)
    tell(found, document, json, f"written to {out}/: {', '.join(files)}")
