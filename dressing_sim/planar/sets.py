"""The study over several training sets, each against its own initial model.

A ratio of a set is a mean cost over its runs divided by another cost of the same set; over sets it
is averaged in logarithms, with Student's interval of the mean. Sets that were drawn independently
make that interval what it says. Those of ``leave_one_out`` share demonstrations, and theirs is a
guide to how much sets differ, no more.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from dressing_sim.checks import whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.augment import Method
from dressing_sim.learning.demonstrations import check_demonstrations
from dressing_sim.planar.generator import PlanarData, generate
from dressing_sim.planar.study import Run, Selection, Study, StudyConfig, check_study, run_study

#: Demonstrations of each generated set: to train, to validate and to test with.
SIZES = (3, 3, 3)

MOST_SETS = 10_000


@dataclass(frozen=True, slots=True)
class Ratio:
    """A geometric mean over sets with its 95 % interval, from nothing to infinity for one set."""

    estimate: float
    low: float
    high: float
    n: int

    @classmethod
    def of(cls, logs: Sequence[float]) -> "Ratio":
        """From the logarithm of each set's ratio, one at least."""
        from scipy.stats import t

        values = np.asarray(logs, dtype=np.float64)
        n, mean = len(values), float(values.mean())
        if n == 1:
            return cls(float(np.exp(mean)), 0.0, np.inf, 1)
        half = float(t.ppf(0.975, n - 1) * values.std(ddof=1) / np.sqrt(n))
        low, high = np.exp(mean - half), np.exp(mean + half)
        return cls(float(np.exp(mean)), float(low), float(high), n)


def leave_one_out(data: PlanarData) -> tuple[PlanarData, ...]:
    """Every demonstration of a file, and of its validation set, once the one to validate with.

    Raises:
        InvalidInputError: fewer than three demonstrations, or such that do not go together.
    """
    everything = (*data.training, *data.validation)
    if len(everything) < 3:
        raise InvalidInputError(
            f"leaving one out needs 3 demonstrations or more, there are {len(everything)}"
        )
    check_demonstrations(everything)
    return tuple(
        PlanarData((*everything[:i], *everything[i + 1 :]), (everything[i],))
        for i in range(len(everything))
    )


def generated(seed: int, count: int) -> tuple[PlanarData, ...]:
    """Sets of demonstrations of the seeds ``seed``, ``seed + 1``, ..., to train, validate, test."""
    whole_number(count, "sets", 1, MOST_SETS)
    return tuple(generate(seed + index, *SIZES) for index in range(count))


def run_sets(
    sets: Sequence[PlanarData],
    config: StudyConfig,
    workers: int = 1,
    on_run: Callable[[Run], None] | None = None,
) -> tuple[Study, ...]:
    """A study of each set; that of set i has the seed ``config.seed + i``.

    Args:
        sets: to learn from.
        config: of all studies.
        workers: processes; the results do not depend on it.
        on_run: called with each run as it is done, in order, for progress.

    Raises:
        InvalidInputError: a configuration or demonstrations that cannot be used.
    """
    for data in sets:
        check_study(data, config, workers)
    return tuple(
        run_study(data, replace(config, seed=config.seed + index), workers, on_run)
        for index, data in enumerate(sets)
    )


#: Of a study: by which demonstrations a cost is.
KINDS = ("training", "validation", "test")


def initial_cost(study: Study, kind: str) -> float | None:
    """Cost of the initial model; None where there are no such demonstrations."""
    value: float | None = getattr(study, f"initial_{kind}_cost")
    return value


def mean_cost(study: Study, method: Method, selection: Selection, kind: str) -> float:
    """Mean cost over the runs of a cell of the table."""
    return float(np.mean([getattr(run, f"{kind}_cost") for run in study.of(method, selection)]))


def gain(study: Study, method: Method, selection: Selection, kind: str) -> float:
    """Logarithm of the mean cost of a cell over that of the initial model."""
    return _log_ratio(mean_cost(study, method, selection, kind), initial_cost(study, kind))


def best_gain(study: Study, method: Method, selection: Selection, kind: str) -> float:
    """The same of the one run that has the lowest cost by its criterion, as the paper prints."""
    best = getattr(study.best(method, selection), f"{kind}_cost")
    return _log_ratio(best, initial_cost(study, kind))


def _log_ratio(cost: float, reference: float | None) -> float:
    assert reference is not None
    return float(np.log(cost) - np.log(reference))
