"""``dressing-sim planar``: the paper's planar study in one command."""

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

from rich.console import Console

from dressing_sim.archives import to_json
from dressing_sim.benchmark.run.progress import show_progress
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output, is_leftover, unwritable, write_files
from dressing_sim.learning.augment import METHODS, AugmentOptions, Method, Retraining
from dressing_sim.learning.gmr import FusionOrder
from dressing_sim.learning.noise import NoiseReference
from dressing_sim.planar.files import load
from dressing_sim.planar.generator import PlanarData, generate
from dressing_sim.planar.report import markdown, summary
from dressing_sim.planar.sets import generated, run_sets
from dressing_sim.planar.sets import leave_one_out as leave_out_each
from dressing_sim.planar.sets_report import sets_markdown, sets_summary
from dressing_sim.planar.study import (
    OPTIONS,
    Run,
    Situations,
    Study,
    StudyConfig,
    check_study,
    run_study,
)
from dressing_sim.provenance import provenance


def planar(
    demos: Path | None = None,
    validation: Path | None = None,
    components: int = 8,
    fusion: FusionOrder = "regression-then-product",
    method: Literal["all"] | Method = "all",
    runs: int = 20,
    seed: int = 1,
    workers: int = 1,
    max_demonstrations: int = OPTIONS.max_demonstrations,
    max_iterations: int = OPTIONS.max_iterations,
    snr_db: float = OPTIONS.snr_db,
    noise_reference: NoiseReference = OPTIONS.noise_reference,
    retrain: Retraining = OPTIONS.retrain,
    situations: Situations = "paper",
    sets: int = 1,
    leave_one_out: bool = False,
    rivals: bool = False,
    out: Path | None = None,
    force: bool = False,
    json: bool = False,
) -> None:
    """Repeat the paper's planar study: learn to move from one U-shaped box into another.

    Prints the paper's Table I (training and validation cost, three methods, two selections), best
    and mean of all runs, next to the paper's figures.

    For example, on generated demonstrations, with figures, and on the authors' own:

    dressing-sim planar --out results/planar

    dressing-sim planar --demos Demos.mat --validation others.npz --json

    With several training sets it prints paired ratios with their intervals, and judges what the
    paper says of the study:

    dressing-sim planar --sets 20 --runs 3

    dressing-sim planar --demos Demos.mat --validation fourth.npz --leave-one-out

    Args:
        demos: demonstrations, .npz (t, xy, A, b) or the paper's authors' .mat; without it they are
            generated from the seed, three to train and three to validate.
        validation: demonstrations to validate on instead of the first file's, in the same formats.
        components: number of Gaussian components K.
        fusion: regress in every frame and multiply (the authors' code), or the other way round
            (the paper's text).
        method: how synthetic demonstrations are made.
        runs: repetitions of Algorithm 1 for each method and selection.
        seed: of everything random.
        workers: processes; the results do not depend on it.
        max_demonstrations: M, at which Algorithm 1 ends.
        max_iterations: L, at which Algorithm 1 ends.
        snr_db: signal-to-noise ratio of the noise, in decibels.
        noise_reference: whether the signal includes its offset from the world's origin (world, as
            in the authors' code) or not (centred).
        retrain: start from the current model (warm) or afresh (cold).
        situations: random frames as in the paper, or around the demonstrated ones.
        sets: how many sets of demonstrations are generated, of this seed and the following ones.
        leave_one_out: train on all demonstrations of the files but one, validate on that one, each
            in turn.
        rivals: compare other methods of learning instead, in situations that they have not seen.
        out: folder for summary.json, table.md and the figures (of one set).
        force: replace these files in a folder that is not empty.
        json: print the numbers as JSON, and nothing else, to standard output.
    """
    config = StudyConfig(
        components=components,
        fusion=fusion,
        methods=METHODS if method == "all" else (method,),
        runs=runs,
        seed=seed,
        options=AugmentOptions(
            max_demonstrations=max_demonstrations,
            max_iterations=max_iterations,
            snr_db=snr_db,
            noise_reference=noise_reference,
            retrain=retrain,
        ),
        situations=situations,
    )
    if validation is not None and demos is None:
        raise InvalidInputError("--validation needs --demos, the demonstrations to train on")
    inputs = [demos, validation]
    if out is not None:
        _check_out(out, force, inputs)
    data = _data(demos, validation, seed, sets, leave_one_out)
    source = "leave-one-out" if leave_one_out else "generated demonstrations"
    result, table, study = (
        _compared(data, config) if rivals else _studied(data, config, workers, source)
    )
    result["provenance"] = provenance()
    text = to_json(result, "the study's result", indent=2) + "\n"
    if out is not None:
        _write(out, {_SUMMARY: text, _TABLE: table}, study, force, inputs)
    sys.stdout.write(text if json else table)


def _data(
    demos: Path | None, validation: Path | None, seed: int, sets: int, leave_one_out: bool
) -> tuple[PlanarData, ...]:
    """The sets of demonstrations to learn from.

    Raises:
        InvalidInputError: a file that cannot be used, or options that do not go together.
    """
    if demos is None:
        if leave_one_out:
            raise InvalidInputError("--leave-one-out needs --demos, the demonstrations")
        return (generate(seed),) if sets == 1 else generated(seed, sets)
    if sets != 1:
        raise InvalidInputError("--sets counts generated sets, it does not go with --demos")
    data = load(demos, validation)
    return leave_out_each(data) if leave_one_out else (data,)


def _studied(
    data: tuple[PlanarData, ...], config: StudyConfig, workers: int, source: str
) -> tuple[dict[str, Any], str, Study | None]:
    """Numbers, their table, and of a single set its study."""
    total = sum(config.runs * len(config.methods) * (2 if one.validation else 1) for one in data)
    for one in data:
        check_study(one, config, workers)
    done = 0
    with show_progress(Console(stderr=True)) as tell:

        def advance(run: Run) -> None:
            nonlocal done
            done += 1
            tell("Algorithm 1", done, total, f"{run.selection}, {run.method}")

        if len(data) == 1:
            study = run_study(data[0], config, workers, advance)
        else:
            studies = run_sets(data, config, workers, advance)
    if len(data) == 1:
        result = summary(study)
        return result, markdown(result), study
    result = sets_summary(studies, source)
    return result, sets_markdown(result), None


def _compared(
    data: tuple[PlanarData, ...], config: StudyConfig
) -> tuple[dict[str, Any], str, Study | None]:
    """Other methods of learning: numbers and their table."""
    from dressing_sim.planar.rivals import compare, comparison, comparison_markdown, learners

    with show_progress(Console(stderr=True)) as tell:
        names, most = list[str](), len(learners(config))

        def advance(name: str) -> None:
            names.append(name)
            tell("methods", len(names), most, name)

        compared, refused = compare(data, config, advance)
    result = comparison(compared, refused, config, len(data))
    return result, comparison_markdown(result), None


#: The files of a study, besides its figures.
_SUMMARY, _TABLE = "summary.json", "table.md"


def _check_out(out: Path, force: bool, inputs: Sequence[Path | None]) -> None:
    """Find out before long work whether its results can be written, and replace nobody's files.

    Raises:
        InvalidInputError: They cannot, or the folder is not empty and `force` is not set, or one of
            them would replace an input.
    """
    from dressing_sim.planar.figures import NAMES

    own = (_SUMMARY, _TABLE, *NAMES)
    for name in own:
        check_output(out / name, True, inputs)
    try:
        there = sorted(file.name for file in out.iterdir()) if out.exists() else []
    except OSError as error:
        raise unwritable(out, error) from error
    foreign = [name for name in there if not is_leftover(name, own.__contains__)]
    if foreign and not force:
        raise InvalidInputError(
            f"{out} is not empty ({foreign[0]}); choose another --out, or use --force"
        )


def _write(
    out: Path,
    files: Mapping[str, str],
    study: Study | None,
    force: bool,
    inputs: Sequence[Path | None],
) -> None:
    """Write numbers, table and, of a single set, figures: all, or none."""
    from dressing_sim.planar.figures import drawn

    contents: dict[str, str | bytes] = {**files, **({} if study is None else drawn(study))}
    _check_out(out, force, inputs)  # it took long
    write_files({out / name: content for name, content in contents.items()})
