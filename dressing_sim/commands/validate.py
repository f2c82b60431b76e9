"""``dressing-sim validate``: do verdicts depend on the mesh, the step or the solver?"""

from __future__ import annotations

from pathlib import Path

from dressing_sim.commands.options import check_positive, check_seed, names


def validate(
    suite: str = "val50",
    postures: int | None = None,
    settings: str | None = None,
    change: str | None = None,
    garment: str | None = None,
    person: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/validate"),
    resume: bool = False,
    force: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
    json: bool = False,
) -> None:
    """Compare policies' verdicts with those of a finer simulation, or sweep its settings.

    Five rows of the paper's policies dress each posture; the same joint commands are then played
    in the reference, a world with a finer mesh, half the step and a converged solver. Some
    25 minutes on two cores for a hundred episodes. Exit code 1 if fewer than 95 % of the verdicts
    are the same.

    With --settings, four paths of the operator's on each posture under other meshes, steps and
    solvers, against the finest of them. Exit code 1 if the default agrees with it on less than
    95 % of verdicts, if the median episode's strain or pull is off by more than 5 % of its limit,
    or if the solver is more than 5 % off a converged one in strain or pull, or no dressing
    succeeds to tell.

    With --change, the same joint commands are played again in a world with that change. Exit code
    1 if fewer than 95 % of the verdicts are the same.

    Writes summary.json, episodes.jsonl, report.md, report.html and a plot.

    For example: dressing-sim validate --suite random:20:7 --json

    Or: dressing-sim validate --settings all

    Or: dressing-sim validate --change self_contact=true --out results/self-contact

    Or: dressing-sim validate --garment gown.toml --person ada.toml --out results/ada

    Args:
        suite: postures: a name, a JSON file, or random:N.
        postures: how many of them, from the first; by default all, and of val50 15.
        settings: all, or some of the settings to sweep, separated by commas; default, finest and
            tolerance 1e-12 (a converged solver) are always among them.
        change: name=value&... of the cloth or the solver, such as self_contact=true, air_drag=true,
            edge=0.04, timestep=0.005 or tolerance=1e-7.
        garment: what is put on, in demonstrations too: tshirt-m, tshirt-l, tshirt-xl, long-sleeve,
            tshirt-m-body, hospital-gown, or a TOML file with a tape measure's sizes.
        person: whose arm is dressed: male, female_small, child-ten, tall-man, or a TOML file
            with a height or a tape measure's sizes.
        seed: of the operator's variability and of the policies' own randomness.
        workers: processes, as many as processors unless given; verdicts do not depend on it.
        out: folder for the results; a finished run of the same study in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        accept_changes: continue it with other versions of packages and of your policies too; rows
            that have episodes of both say so.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.studies.agreement import REQUIRED_AGREEMENT, agreement_plan
    from dressing_sim.benchmark.studies.change import change_plan
    from dressing_sim.benchmark.studies.convergence import convergence_plan
    from dressing_sim.commands.studies import carry_out
    from dressing_sim.errors import InvalidInputError

    if postures is not None:
        check_positive("postures", postures)
    check_seed(seed)
    if change is not None:
        if settings is not None:
            raise InvalidInputError("--settings and --change: valid is one of them")
        plan = change_plan(change, suite, postures, seed, garment, person)
        plot = "agreement.svg"
    elif settings is None:
        plan, plot = agreement_plan(suite, postures, seed, garment, person), "agreement.svg"
    else:
        wanted = [name for name in names(settings) if name]
        chosen = None if wanted == ["all"] else wanted
        plan = convergence_plan(suite, postures, chosen, seed, garment, person)
        plot = "convergence.svg"
    summary = carry_out(
        plan,
        out,
        workers=workers,
        resume=resume,
        force=force,
        inputs=[name for name in (suite, garment, person) if name is not None],
        accept_numerics=accept_numerics,
        accept_changes=accept_changes,
        json=json,
        files=f"report.md, report.html, {plot}, summary.json, episodes.jsonl",
    )
    if settings is None:
        agreement = summary["policies"]["agreement"]
        passed = agreement is not None and agreement >= REQUIRED_AGREEMENT
    else:
        passed = summary["passed"]
    if not passed:
        raise SystemExit(1)
