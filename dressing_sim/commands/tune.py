"""``dressing-sim tune``: hyper-parameters of a policy, chosen on the validation suite."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import tyro

from dressing_sim.commands.options import check_seed
from dressing_sim.errors import InvalidInputError


def tune(
    policy: tyro.conf.Positional[str],
    trials: int = 60,
    screened: bool = False,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    out: Path = Path("results/tune"),
    resume: bool = False,
    force: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
    json: bool = False,
) -> None:
    """Search a policy's hyper-parameters on val50, never on a test suite.

    The same budget for every policy: a Sobol design of trials, the policy as it is among them,
    learns from case A and from case B; all dress five postures, the best quarter sixteen, and the
    best of those fifty. About half an hour on two cores.

    With --screened a quarter of that: trials are compared by the paths they draw on all fifty,
    without physics, and the best eight dress eight postures, the best two of those all.

    Writes episodes.jsonl, summary.json, report.md and report.html; with --screened also a folder
    OUT-screening with the same of the paths.

    For example: dressing-sim tune tp-gmm --out results/tune-tp-gmm

    Args:
        policy: one of the paper's, transport, or a rival; an unknown name tells which.
        trials: how many sets of hyper-parameters are tried.
        screened: only those that draw the best paths dress.
        seed: of the design, of the operator's variability, and of the policies' own randomness.
        workers: processes, as many as processors unless given; the results do not depend on it.
        scheduler: address of a Dask scheduler whose workers are used instead of processes here.
        out: folder for the results; a finished run of the same study in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        accept_changes: continue it with other versions of packages and of your policies too.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.studies.search import Search
    from dressing_sim.benchmark.studies.study import run_study
    from dressing_sim.benchmark.studies.tuning import Tuning
    from dressing_sim.commands.studies import at_work, carry_out, check_folder, typed
    from dressing_sim.policies.registry import known_name

    if workers is not None and scheduler is not None:
        raise InvalidInputError("--workers and --scheduler exclude each other")
    check_seed(seed)
    search = Search(known_name(policy), trials, seed)
    plan = search.plan()
    again: dict[str, Any] = {
        "resume": resume,
        "force": force,
        "accept_numerics": accept_numerics,
        "accept_changes": accept_changes,
    }
    if screened:
        paths = out.with_name(f"{out.name}-screening")
        check_folder(out)
        check_folder(paths)
        with at_work(workers, scheduler) as (crew, progress):
            first = run_study(
                Tuning(),
                search.screening(),
                crew,
                paths,
                progress=progress,
                command=typed(),
                **again,
            )
        plan = search.after(first.summary).plan()
    carry_out(
        plan,
        out,
        workers=workers,
        scheduler=scheduler,
        json=json,
        files="report.md, report.html, summary.json, episodes.jsonl",
        **again,
    )
