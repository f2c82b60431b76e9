"""Algorithm 1 on the planar task: methods x selections x runs, whatever the number of workers."""

from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from itertools import product
from multiprocessing import get_context
from typing import Literal, get_args

import numpy as np

from dressing_sim.checks import listed, of_kind, one_of, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.augment import METHODS, Augmentation, AugmentOptions, Method, augment
from dressing_sim.learning.gmr import FusionOrder
from dressing_sim.learning.sampling import BoundsSampler, FrameBounds, SituationSampler
from dressing_sim.learning.timed import TimeTPGMM
from dressing_sim.planar.generator import PlanarData

Selection = Literal["original", "generalisation"]
SELECTIONS: tuple[Selection, ...] = ("original", "generalisation")
Situations = Literal["paper", "demonstrations"]

# The random frames of the paper's study (from the authors' code): the start stays where it is.
GOAL_ANGLES = (np.deg2rad([60.0]), np.deg2rad([180.0]))
GOAL_POSITIONS = (np.zeros(2), np.full(2, 0.75))


#: Of the paper's study, the same for all methods; the authors' code fills the gaps.
OPTIONS = AugmentOptions(max_demonstrations=8, max_iterations=50, noise_reference="world")


@dataclass(frozen=True)
class StudyConfig:
    """The choices of a study; the defaults are the paper's, with the authors' code filling gaps."""

    components: int = 8
    fusion: FusionOrder = "regression-then-product"
    methods: tuple[Method, ...] = METHODS
    runs: int = 20
    seed: int = 1
    options: AugmentOptions = OPTIONS
    situations: Situations = "paper"

    def __post_init__(self) -> None:
        whole_number(self.runs, "runs", 1, 100_000)
        whole_number(self.seed, "the seed", 0, 2**63 - 1)
        one_of(self.situations, "situations", get_args(Situations))
        for method in listed(self.methods, "methods", "a sequence of methods"):
            one_of(method, "a method", METHODS)
        of_kind(self.options, AugmentOptions, "options", "AugmentOptions")
        initial_policy(self)  # which checks its settings


@dataclass(frozen=True, eq=False)
class Run:
    """One run of Algorithm 1 with the costs of its final policy.

    There is no cost, None, where there are no demonstrations to validate with, or to test with.
    """

    method: Method
    selection: Selection
    index: int
    augmentation: Augmentation
    training_cost: float
    validation_cost: float | None
    test_cost: float | None


@dataclass(frozen=True, eq=False)
class Study:
    """The initial policy and all runs, ordered by selection, method and index."""

    config: StudyConfig
    data: PlanarData
    initial: TimeTPGMM
    initial_training_cost: float
    initial_validation_cost: float | None
    initial_test_cost: float | None
    runs: tuple[Run, ...]

    def of(self, method: Method, selection: Selection) -> tuple[Run, ...]:
        """The runs of one cell of the table."""
        return tuple(r for r in self.runs if (r.method, r.selection) == (method, selection))

    def best(self, method: Method, selection: Selection) -> Run:
        """The run with the lowest cost by its own criterion of selection."""
        return min(self.of(method, selection), key=lambda run: run.augmentation.cost)

    @property
    def selections(self) -> tuple[Selection, ...]:
        """Generalisation selection needs a validation set."""
        return SELECTIONS if self.data.validation else SELECTIONS[:1]


def situation_sampler(data: PlanarData, situations: Situations) -> SituationSampler:
    """The random frames of the study.

    Args:
        data: the demonstrations; frame 0 is the start, frame 1 the goal.
        situations: ``"paper"`` for the bounds of the paper's study, with the scale and the
            handedness of the demonstrated goal frame; ``"demonstrations"`` for bounds around the
            demonstrated frames.

    Raises:
        InvalidInputError: the paper's bounds for demonstrations that are not of its task.
    """
    if situations == "demonstrations":
        return BoundsSampler.around(data.training)
    first = data.training[0].frames
    if len(first) != 2 or any(d.frames[0] != first[0] for d in data.training):
        raise InvalidInputError(
            "the paper's random situations need two frames, the first of them the same in all "
            "demonstrations; choose --situations demonstrations"
        )
    determinant = np.linalg.det(first[1].A)
    base = np.sqrt(abs(determinant)) * np.diag([np.sign(determinant), 1.0])
    goal = FrameBounds(base, GOAL_ANGLES, GOAL_POSITIONS)
    return BoundsSampler((FrameBounds.fixed(first[0]), goal))


@dataclass(frozen=True, eq=False)
class _Job:
    """Everything a worker needs for one run."""

    config: StudyConfig
    data: PlanarData
    method: Method
    selection: Selection
    index: int

    def __call__(self) -> Run:
        validation, test = self.data.validation, self.data.test
        result = augmented(self.config, self.data, self.method, self.selection, self.index)
        return Run(
            self.method,
            self.selection,
            self.index,
            result,
            result.policy.cost(self.data.training),
            result.policy.cost(validation) if validation else None,
            result.policy.cost(test) if test else None,
        )


def augmented(
    config: StudyConfig, data: PlanarData, method: Method, selection: Selection, index: int
) -> Augmentation:
    """One run of Algorithm 1, the one of this index in its cell of the table."""
    # The seed depends on the run alone, not on which others there are or where it runs.
    key = (SELECTIONS.index(selection), METHODS.index(method), index)
    sequence = np.random.SeedSequence(config.seed, spawn_key=key)
    return augment(
        data.training,
        rng=np.random.default_rng(sequence),
        options=replace(config.options, method=method),
        policy=initial_policy(config),
        sampler=situation_sampler(data, config.situations),
        validation=data.validation if selection == "generalisation" else None,
    )


def initial_policy(config: StudyConfig) -> TimeTPGMM:
    """What a study starts from, before it is fitted."""
    return TimeTPGMM(config.components, fusion=config.fusion)


def _call(job: _Job) -> Run:
    return job()


def _runs(jobs: list[_Job], workers: int) -> Iterator[Run]:
    if workers == 1:
        yield from map(_call, jobs)
        return
    # Spawned, not forked: a progress bar's thread and compiled code do not survive a fork well.
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        yield from pool.map(_call, jobs)


def check_study(data: PlanarData, config: StudyConfig, workers: int) -> None:
    """Raise InvalidInputError unless a study can begin: here rather than in a worker."""
    whole_number(workers, "workers", 1, 1024)
    if config.options.max_demonstrations <= len(data.training):
        raise InvalidInputError(
            f"max_demonstrations is {config.options.max_demonstrations}, valid is more than the "
            f"{len(data.training)} to learn from"
        )
    situation_sampler(data, config.situations)


def run_study(
    data: PlanarData,
    config: StudyConfig,
    workers: int = 1,
    on_run: Callable[[Run], None] | None = None,
) -> Study:
    """All runs of the study.

    Args:
        data: demonstrations; without a validation set there is no generalisation selection.
        config: see ``StudyConfig``.
        workers: processes; the results do not depend on it.
        on_run: called with each run as it is done, in order, for progress.

    Raises:
        InvalidInputError: a configuration or demonstrations that cannot be used.
    """
    check_study(data, config, workers)
    initial = initial_policy(config).fit(data.training)
    selections = SELECTIONS if data.validation else SELECTIONS[:1]
    jobs = [
        _Job(config, data, method, selection, index)
        for selection, method, index in product(selections, config.methods, range(config.runs))
    ]
    runs = []
    for run in _runs(jobs, workers):
        runs.append(run)
        if on_run is not None:
            on_run(run)
    return Study(
        config,
        data,
        initial,
        initial.cost(data.training),
        initial.cost(data.validation) if data.validation else None,
        initial.cost(data.test) if data.test else None,
        tuple(runs),
    )
