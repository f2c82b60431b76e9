"""``dressing-sim tune``: hyper-parameters of a policy, chosen on the validation suite."""

from __future__ import annotations

from pathlib import Path

import tyro

from dressing_sim.commands.options import check_seed
from dressing_sim.errors import InvalidInputError


def tune(
    policy: tyro.conf.Positional[str],
    trials: int = 60,
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

    Writes episodes.jsonl, summary.json, report.md and report.html.

    For example: dressing-sim tune tp-gmm --out results/tune-tp-gmm

    Args:
        policy: tp-gmm, tp-gmm-noise, tp-gmm-rf, tp-gmm-rf-noise or transport.
        trials: how many sets of hyper-parameters are tried.
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
    from dressing_sim.commands.studies import carry_out

    if workers is not None and scheduler is not None:
        raise InvalidInputError("--workers and --scheduler exclude each other")
    check_seed(seed)
    carry_out(
        Search(policy, trials, seed).plan(),
        out,
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        force=force,
        accept_numerics=accept_numerics,
        accept_changes=accept_changes,
        json=json,
        files="report.md, report.html, summary.json, episodes.jsonl",
    )
