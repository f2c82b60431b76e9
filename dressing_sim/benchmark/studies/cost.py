"""Protocol ``paper-cost``: what Algorithm 1 does to the reproduction cost, over many runs.

The paper runs it 20 times and gives, for 2 + n demonstrations, the average cost and the average
number of candidates discarded until then (Zhu, Gienger and Kober 2022, the table "Average cost
reduction and number of trajectories generated", and the figure of the cost reduction).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.run.executors import Workers, completed
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.learning import DemonstrationLike, Method, SyntheticDemonstration
from dressing_sim.policies.paper import AUGMENTED, AugmentedTPGMMConfig, plain_config
from dressing_sim.provenance import versions

#: Told about progress: the stage, how much of it is done, of how much, and no episodes.
Progress = Callable[[str, int, int, Sequence[Any]], None]

RUNS = 20

#: The paper's table, for 2 + n demonstrations. It does not say of which case, nor which method.
PAPER_COST = (0.082, 0.068, 0.060, 0.051, 0.048, 0.046)
PAPER_DISCARDED = (0.0, 2.5, 21.2, 38.9, 47.0, 77.0)

_RESAMPLES = 10_000


@dataclass(frozen=True, slots=True)
class CostRun:
    """One run of Algorithm 1.

    Attributes:
        costs: Cost with 0, 1, 2, ... synthetic demonstrations accepted [m].
        tried: Candidates tried until each was accepted, 0 for the first.
        seconds: How long it took.
    """

    costs: tuple[float, ...]
    tried: tuple[int, ...]
    seconds: float


def run_paper_cost(
    workers: Workers,
    demonstrations: Mapping[str, Sequence[Demonstration]],
    seed: int = 0,
    progress: Progress | None = None,
    config: AugmentedTPGMMConfig | None = None,
    runs: int = RUNS,
) -> dict[str, Any]:
    """Run Algorithm 1 many times on each set of demonstrations, by each of its methods.

    Args:
        workers: Where runs happen; all but the seconds is the same for any number of workers.
        demonstrations: Expert demonstrations by the name of their suite.
        seed: Run i has the same seed, which depends on this and on i, in every row.
        progress: Told after each run.
        config: Hyper-parameters of the policies.
        runs: How many, a row.

    Returns:
        ``{"rows": [...], "paper": {...}, "versions": {...}, "config": {...}}``. A row has
        ``policy``, ``demonstrations``, ``n_runs``, ``seconds_median`` and ``steps``, one for each
        number n of accepted demonstrations, see `summarise_runs`.

    Raises:
        DressingSimError: A worker died twice under a run.
    """
    config = config or AugmentedTPGMMConfig()
    report = progress or (lambda stage, done, total, results: None)
    # A worker needs the path and the frames, not the joint commands.
    shown = {
        name: [SyntheticDemonstration(d.positions, d.dt, d.frames) for d in recorded]
        for name, recorded in demonstrations.items()
    }
    places = [(name, policy) for name in shown for policy in AUGMENTED]
    calls = [
        ((*place, run), (shown[place[0]], AUGMENTED[place[1]], run_seed(seed, run), config))
        for place in places
        for run in range(runs)
    ]
    found: dict[tuple[str, str, int], CostRun] = {}
    report("runs", 0, len(calls), ())
    for key, future in completed(workers, _run, calls):
        found[key] = future.result()
        report("runs", len(found), len(calls), ())
    rows = []
    for name, policy in places:
        results = [found[name, policy, run] for run in range(runs)]
        most = config.options.max_demonstrations - len(demonstrations[name])
        rows.append(
            {
                "policy": policy,
                "demonstrations": name,
                "n_demonstrations": len(demonstrations[name]),
                "n_runs": len(results),
                "seconds_median": float(np.median([result.seconds for result in results])),
                "steps": summarise_runs(results, most, np.random.default_rng(seed)),
            }
        )
    return {
        "rows": rows,
        "paper": {"cost": list(PAPER_COST), "discarded": list(PAPER_DISCARDED), "n_runs": 20},
        "versions": versions(),
        "config": {
            "protocol": "paper-cost",
            "seed": seed,
            "runs": runs,
            "policy": plain_config(config),
        },
    }


def run_seed(seed: int, run: int) -> int:
    """Seed of a run of Algorithm 1, which depends on both arguments and on nothing else."""
    return int(np.random.SeedSequence([seed, run]).generate_state(1)[0])


def _run(
    demonstrations: Sequence[DemonstrationLike],
    method: Method,
    seed: int,
    config: AugmentedTPGMMConfig,
) -> CostRun:
    started = perf_counter()
    improved = config.with_method(method).augmented(seed).fit(config.seen(demonstrations))
    return CostRun(improved.costs, improved.tried, perf_counter() - started)


def summarise_runs(
    runs: Sequence[CostRun], most: int, rng: np.random.Generator
) -> list[dict[str, Any]]:
    """What the runs came to with n = 0, ..., most synthetic demonstrations.

    Returns:
        One dictionary for each n:

        * ``n_reached``: runs that accepted an n-th demonstration within the allowed candidates;
        * ``cost``, ``cost_ci95``, ``discarded``, ``discarded_ci95``: mean over these runs of the
          cost then and of the candidates discarded until then, None where there were none. Runs
          that accept easily are over-represented in later n;
        * ``cost_of_all``, ``cost_of_all_ci95``: mean over all runs, each with the best cost that
          it had with at most n synthetic demonstrations.

        Intervals are percentile bootstraps of the mean over runs.
    """
    steps = []
    for n in range(most + 1):
        reached = [run for run in runs if len(run.costs) > n]
        step: dict[str, Any] = {"n": n, "n_reached": len(reached)}
        for name, values in (
            ("cost", [run.costs[n] for run in reached]),
            ("discarded", [float(run.tried[n] - n) for run in reached]),
            ("cost_of_all", [run.costs[min(n, len(run.costs) - 1)] for run in runs]),
        ):
            step[name] = float(np.mean(values)) if values else None
            step[f"{name}_ci95"] = _interval(np.array(values), rng) if values else None
        steps.append(step)
    return steps


def _interval(values: NDArray[np.float64], rng: np.random.Generator) -> list[float]:
    """95 % percentile bootstrap interval of the mean (Efron 1979)."""
    drawn = values[rng.integers(len(values), size=(_RESAMPLES, len(values)))]
    return [float(bound) for bound in np.percentile(drawn.mean(axis=1), [2.5, 97.5])]
