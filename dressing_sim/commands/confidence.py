"""``dressing-sim confidence``: whether policies know when they will fail."""

from __future__ import annotations

import re
from pathlib import Path

import tyro


def confidence(
    training: tyro.conf.Positional[Path],
    tested: tyro.conf.Positional[Path],
    workers: int | None = None,
    out: Path = Path("results/confidence"),
    resume: bool = False,
    force: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
    json: bool = False,
) -> None:
    """Calibrate probabilities of success on one finished run, and try them on another.

    Both runs are of evaluate. Their policies learn and make their paths again, but nothing is
    simulated again. Writes summary.json, report.md and report.html, two plots, and a judge for each
    row: a policy with ?judge=FILE tells its probability of success with each path, and with
    &abstain=P it does not try below that.

    For example: dressing-sim confidence results/training results/evaluate

    Args:
        training: folder of a finished run on postures for training, such as train200.
        tested: folder of a finished run of the same policies on other postures.
        workers: processes, as many as processors unless given; the results do not depend on it.
        out: folder for the results; a finished run of the same study in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        accept_changes: continue it with other versions of packages and of your policies too; rows
            that have episodes of both say so.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.studies.confidence import confidence_plan
    from dressing_sim.commands.studies import carry_out
    from dressing_sim.errors import InvalidInputError
    from dressing_sim.policies.confidence import Judge

    for read in (training, tested):
        if out.resolve() == read.resolve():
            raise InvalidInputError(f"{out}: is read; choose another --out")
    summary = carry_out(
        confidence_plan(training, tested),
        out,
        workers=workers,
        resume=resume,
        force=force,
        inputs=[str(training), str(tested)],
        accept_numerics=accept_numerics,
        accept_changes=accept_changes,
        json=json,
        files="report.md, report.html, summary.json, confidence-*.svg, judge-*.json",
    )
    for row in summary["rows"]:
        named = "-".join([row["policy"], row["demonstrations"], *row["variation"]])
        file = out / f"judge-{re.sub(r'[^A-Za-z0-9_.-]', '_', named)}.json"
        Judge.from_dict(row["judge"]).save(file)
