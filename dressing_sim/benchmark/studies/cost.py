"""Protocol ``paper-cost``: what Algorithm 1 does to the reproduction cost, over many runs.

The paper runs it 20 times and gives, for 2 + n demonstrations, the average cost and the average
number of candidates discarded until then (Zhu, Gienger and Kober 2022, the table "Average cost
reduction and number of trajectories generated", and the figure of the cost reduction).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.records import Entry, Json
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.benchmark.run.progress import Progress
from dressing_sim.benchmark.run.runner import Work, record_demonstrations
from dressing_sim.benchmark.run.store import OpenRun, RunFolder
from dressing_sim.benchmark.studies.cost_document import cost_document
from dressing_sim.benchmark.studies.study import Calls, Study, Summary
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import DemonstrationLike, SyntheticDemonstration
from dressing_sim.policies.paper import AUGMENTED, AugmentedTPGMMConfig, plain_config
from dressing_sim.provenance import versions

RUNS = 20

#: The paper's table, for 2 + n demonstrations. It does not say of which case, nor which method.
PAPER_COST = (0.082, 0.068, 0.060, 0.051, 0.048, 0.046)
PAPER_DISCARDED = (0.0, 2.5, 21.2, 38.9, 47.0, 77.0)

_RESAMPLES = 10_000


@dataclass(frozen=True, slots=True)
class CostRun:
    """One run of Algorithm 1, to be made or made.

    Attributes:
        index: Its place: all runs of the first row, then of the next.
        entry: Row of the protocol.
        run: Which of the row's runs, from 0.
        costs: Cost with 0, 1, 2, ... synthetic demonstrations accepted [m].
        tried: Candidates tried until each was accepted, 0 for the first.
        seconds: How long it took.
    """

    index: int
    entry: Entry
    run: int
    costs: tuple[float, ...] = ()
    tried: tuple[int, ...] = ()
    seconds: float = 0.0


@dataclass(frozen=True)
class Cost(Study[CostRun, CostRun]):
    """Algorithm 1, many times on each set of demonstrations, by each of its methods.

    Attributes:
        work: What workers are asked to do.
        config: Of the policies.
    """

    work: Work = field(default_factory=Work)
    config: AugmentedTPGMMConfig = field(default_factory=AugmentedTPGMMConfig)

    stage = "runs"
    result = CostRun

    def jobs(self, plan: Plan) -> Sequence[CostRun]:
        """As many runs of each row as the plan's option ``runs`` says, or `RUNS`."""
        runs = _runs(plan)
        places = [(entry, run) for entry in plan.protocol.entries for run in range(runs)]
        return [CostRun(index, *place) for index, place in enumerate(places)]

    def calls(
        self, folder: OpenRun, jobs: Sequence[CostRun], workers: Workers, progress: Progress
    ) -> Calls[CostRun, CostRun]:
        """Demonstrate; then each job improves a policy.

        Run i has the same seed, which depends on the plan's and on i, in every row.
        """
        recorded = record_demonstrations(folder, workers, progress, self.work)
        # A worker needs the path and the frames, not the joint commands.
        paths = {
            name: [SyntheticDemonstration(d.positions, d.dt, d.frames) for d in demonstrations]
            for (name, _), demonstrations in recorded.items()
        }
        seed = folder.plan.seed
        return improve, (
            (job, (job, paths[_suite(job.entry)], run_seed(seed, job.run), self.config))
            for job in jobs
        )

    def values(self, plan: Plan, result: CostRun) -> dict[str, Json]:
        """What the line of a run holds."""
        line = super().values(plan, result)
        return {"index": line["index"], "protocol": plan.protocol.name, **line}

    def summarise(self, folder: RunFolder, results: Sequence[CostRun]) -> dict[str, Any]:
        """Cost and discarded candidates of each row.

        Returns:
            ``{"rows": [...], "paper": {...}, "versions": {...}, "config": {...}}``. A row has
            ``policy``, ``demonstrations``, ``n_demonstrations``, ``n_runs``, ``seconds_median``
            and ``steps``, one for each number n of accepted demonstrations, see `summarise_runs`.
        """
        plan = folder.plan
        rows = []
        for entry in plan.protocol.entries:
            runs = [run for run in results if run.entry == entry]
            given = len(plan.demonstrated[_suite(entry)])
            most = max(0, self.config.options.max_demonstrations - given)
            rows.append(
                {
                    "policy": entry.policy,
                    "demonstrations": entry.demonstrations,
                    "n_demonstrations": given,
                    "n_runs": len(runs),
                    "seconds_median": float(np.median([run.seconds for run in runs])),
                    "steps": summarise_runs(runs, most, np.random.default_rng(plan.seed)),
                }
            )
        return {
            "rows": rows,
            "paper": {"cost": list(PAPER_COST), "discarded": list(PAPER_DISCARDED), "n_runs": 20},
            "versions": versions(),
            "config": {
                "protocol": plan.protocol.name,
                "seed": plan.seed,
                "runs": _runs(plan),
                "policy": plain_config(self.config),
            },
        }

    def document(
        self, folder: RunFolder, results: Sequence[CostRun], summary: Summary, command: str
    ) -> Document:
        """Tables and the plot of the cost."""
        return cost_document(summary, command)


def _runs(plan: Plan) -> int:
    runs = plan.options.get("runs", RUNS)
    if not isinstance(runs, int) or runs < 1:
        raise InvalidInputError(f"runs is {runs!r}, valid is a whole number from 1")
    return runs


def _suite(entry: Entry) -> str:
    """The demonstrations of a row, all of which learn."""
    if entry.demonstrations is None:
        raise InvalidInputError(f"row {entry.label}: learns nothing, so there is no cost")
    return entry.demonstrations


def run_seed(seed: int, run: int) -> int:
    """Seed of a run of Algorithm 1, which depends on both arguments and on nothing else."""
    return int(np.random.SeedSequence([seed, run]).generate_state(1)[0])


def improve(
    job: CostRun,
    demonstrations: Sequence[DemonstrationLike],
    seed: int,
    config: AugmentedTPGMMConfig,
) -> CostRun:
    """Run Algorithm 1 once."""
    started = perf_counter()
    policy = config.with_method(AUGMENTED[job.entry.policy]).augmented(seed)
    fitted = policy.fit(config.seen(demonstrations))
    seconds = perf_counter() - started
    return replace(job, costs=fitted.costs, tried=fitted.tried, seconds=seconds)


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
