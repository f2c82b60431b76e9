"""``dressing-sim validate``: do verdicts depend on the solver?"""

from __future__ import annotations

from pathlib import Path

from dressing_sim.commands.options import check_positive, check_seed, names


def validate(
    suite: str = "val50",
    postures: int | None = None,
    only: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/validate"),
    resume: bool = False,
    force: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
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
        postures: how many of them, from the first; 15, or all if there are fewer, by default.
        only: settings to try, separated by commas, besides default, finest and tolerance 1e-12
            (a converged solver), which are always included.
        seed: of the operator's variability.
        workers: processes, as many as processors unless given; verdicts do not depend on it.
        out: folder for the results; a finished run of the same study in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        accept_changes: continue it with other versions of packages and of your policies too; rows
            that have episodes of both say so.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.studies.convergence import convergence_plan
    from dressing_sim.commands.studies import carry_out

    if postures is not None:
        check_positive("postures", postures)
    check_seed(seed)
    wanted = None if only is None else [name for name in names(only) if name]
    plan = convergence_plan(suite, postures, wanted, seed)
    summary = carry_out(
        plan,
        out,
        workers=workers,
        resume=resume,
        force=force,
        inputs=[suite],
        accept_numerics=accept_numerics,
        accept_changes=accept_changes,
        json=json,
        files="report.md, report.html, convergence.svg, summary.json, episodes.jsonl",
    )
    if not summary["passed"]:
        raise SystemExit(1)
