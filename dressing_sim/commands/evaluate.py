"""``dressing-sim evaluate``: the table of a protocol."""

from __future__ import annotations

from pathlib import Path
from textwrap import fill

from dressing_sim.commands.options import names
from dressing_sim.errors import InvalidInputError


def evaluate(
    protocol: str = "paper",
    suite: str | None = None,
    policies: str | None = None,
    variation: str | None = None,
    demonstrations: str | None = None,
    garment: str | None = None,
    person: str | None = None,
    robot: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    scheduler: str | None = None,
    out: Path = Path("results/evaluate"),
    resume: bool = False,
    force: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
    fit_time: float = 60.0,
    generate_time: float = 10.0,
    memory: float = 4.0,
    pictures: bool = True,
    films: int = 0,
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

    Or: dressing-sim evaluate --demonstrations mine.h5 --policies default --out results/own

    Or: dressing-sim evaluate --garment gown.toml --person ada.toml --out results/ada

    Or: dressing-sim evaluate --suite paper5 --policies expert --robot ur10 --out results/ur10

    Or: dressing-sim evaluate --out results/evaluate --resume --films 2

    Or: dressing-sim evaluate --scheduler tcp://10.0.0.1:8786 --out results/cluster --resume

    Args:
        protocol: which policies learn from which demonstrations: paper, full, budget, friction,
            noise, robust, styles, fair, settings, ablation, rivals, moving, compliant; or
            paper-cost, what the learning costs without dressing anybody.
        suite: test postures instead of the protocol's: a name, NAME:n for its first n, a JSON
            file, or random:N.
        policies: other policies than the protocol's, separated by commas: expert, default,
            tp-gmm, the name of an installed one, or module:Class, each with ?name=value&...
            for its hyper-parameters.
        variation: factors drawn anew for each episode, separated by commas: friction, fabric,
            garment, arm, grasp, frames; or fixed in all: friction=0.6, arm=female_small.
        demonstrations: what every policy learns from instead of the protocol's: suites, such as
            case_a or case_a,baseline7:3, perhaps with the operator's style (case_a?speed=0.16),
            or a file as dressing-sim demonstrate writes it.
        garment: what is put on, in demonstrations too: tshirt-m, tshirt-l, tshirt-xl, long-sleeve,
            tshirt-m-body, hospital-gown, or a TOML file with a tape measure's sizes.
        person: whose arm is under test: male, female_small, child-ten, tall-man, or a TOML file
            with a height or a tape measure's sizes.
        robot: which robot dresses, in demonstrations too: panda, ur10, or a TOML file with its
            URDF and servos.
        seed: of the operator's variability, of the policies' own randomness, and of variation.
        workers: processes, as many as processors unless given; the results do not depend on it.
        scheduler: address of a Dask scheduler whose workers are used instead of processes here.
        out: folder for the results; a finished run of the same study in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        accept_changes: continue it with other versions of packages and of your policies too; rows
            that have episodes of both say so.
        fit_time: longest time in which a policy that is not of this package learns, in seconds;
            one that takes longer, raises or exits fails with the reason policy_error.
        generate_time: longest time in which it makes a path, or a target, in seconds.
        memory: most memory that it may allocate, where the platform has such a limit, in GiB.
        pictures: draw the hardest postures in report.html, which runs their episodes again.
        films: film so many typical failures of each row, next to report.html, which runs their
            episodes again; of a finished run with --resume.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.studies.evaluate import evaluation_plan, evaluation_study
    from dressing_sim.commands.studies import carry_out
    from dressing_sim.policies.host import PolicyLimits
    from dressing_sim.policies.paper import any_of_the_paper, left_open

    if workers is not None and scheduler is not None:
        raise InvalidInputError("--workers and --scheduler exclude each other")
    varied = None if variation is None else names(variation)
    limits = PolicyLimits(fit_time, generate_time, memory)
    plan = evaluation_plan(
        protocol, suite, policies, varied, seed, demonstrations, limits, garment, person, robot
    )
    remarks = ""
    if any_of_the_paper(entry.policy for entry in plan.protocol.entries):
        told = f"policies: {left_open()}"
        remarks = fill(told, 100, subsequent_indent="  ", break_on_hyphens=False) + "\n"
    carry_out(
        plan,
        out,
        study=evaluation_study(plan, pictures, films),
        workers=workers,
        scheduler=scheduler,
        resume=resume,
        force=force,
        inputs=[name for name in (suite, garment, person, robot) if name is not None],
        accept_numerics=accept_numerics,
        accept_changes=accept_changes,
        json=json,
        remarks=remarks,
    )
