"""``dressing-sim thresholds``: how success rates hang on the thresholds of success."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from dressing_sim.commands.options import check_seed, names


def thresholds(
    suite: str = "val50",
    policies: str | None = None,
    garment: str | None = None,
    person: str | None = None,
    seed: int = 0,
    workers: int | None = None,
    out: Path = Path("results/thresholds"),
    resume: bool = False,
    force: bool = False,
    accept_numerics: bool = False,
    accept_changes: bool = False,
    json: bool = False,
) -> None:
    """Measure how success rates, and the ranking of policies, hang on each threshold of success.

    Every episode is simulated once, on after limits were exceeded, and judged with each threshold
    multiplied by 0.5 to 2. Writes episodes.jsonl, summary.json, report.md, report.html and
    thresholds.svg.

    For example: dressing-sim thresholds

    Or: dressing-sim thresholds --suite random:20 --policies expert,tp-gmm --workers 4

    Or: dressing-sim thresholds --garment gown.toml --person ada.toml --out results/ada

    Args:
        suite: test postures: a name, a JSON file, or random:N.
        policies: other policies than the study's, separated by commas, each learning from all of
            its demonstrations: expert, tp-gmm, tp-gmm-rf, the name of an installed one, or
            module:Class.
        garment: what is put on, in demonstrations too: tshirt-m, tshirt-l, tshirt-xl, long-sleeve,
            tshirt-m-body, hospital-gown, or a TOML file with a tape measure's sizes.
        person: whose arm is under test: male, female_small, child-ten, tall-man, or a TOML file
            with a height or a tape measure's sizes.
        seed: of the operator's variability, and of the policies' own randomness.
        workers: processes, as many as processors unless given; the results do not depend on it.
        out: folder for the results; a finished run of the same study in it is replaced.
        resume: continue the run in the folder, if there is one, with the same config.
        force: begin anew in any folder; only files of a run's names are replaced in it.
        accept_numerics: continue it on another kind of processor too, where the last bits differ.
        accept_changes: continue it with other versions of packages and of your policies too; rows
            that have episodes of both say so.
        json: print the summary as JSON, and nothing else, to standard output.
    """
    from dressing_sim.benchmark.studies.thresholds import PROTOCOL, thresholds_plan
    from dressing_sim.commands.studies import carry_out

    protocol = replace(PROTOCOL, suite=suite)
    if policies is not None:
        protocol = protocol.with_policies(names(policies))
    check_seed(seed)
    carry_out(
        thresholds_plan(protocol, seed, garment, person),
        out,
        workers=workers,
        resume=resume,
        force=force,
        inputs=[name for name in (suite, garment, person) if name is not None],
        accept_numerics=accept_numerics,
        accept_changes=accept_changes,
        json=json,
        files="report.md, report.html, thresholds.svg, summary.json",
    )
