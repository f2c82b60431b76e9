"""How well what is measured on a path, without physics, tells whether it dresses.

The policies of a run learn and make their paths again. Each path is compared with the operator's on
the same arm, and each measure gets the probability that it ranks a path that dressed above one that
did not: 0.5 says nothing, 1 everything (the area under the ROC curve; Hanley and McNeil 1982).
Rows without a success, or without a failure, are left out, and pairs are of one row, so that no
policy's average counts.

    python scripts/path_errors.py results/fair-hard
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from dressing_sim.benchmark.records import Entry
from dressing_sim.benchmark.report.markdown import markdown_table
from dressing_sim.benchmark.run.executors import Processes, completed
from dressing_sim.benchmark.run.lines import parse_episode
from dressing_sim.benchmark.run.progress import show_progress
from dressing_sim.benchmark.run.runner import learned_source
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies.tuning_paths import PathMetrics, path_metrics, steady_path
from dressing_sim.episode.record import DEFAULT_PATH_DT
from dressing_sim.errors import PolicyError
from dressing_sim.path import policy_path
from dressing_sim.system import processors
from dressing_sim.world.scene import grip_start

#: What is measured on a path, the larger the better.
MEASURES: Mapping[str, Callable[[PathMetrics], float]] = {
    "mean distance from the operator's path": lambda path: -path.mean_gap,
    "largest distance from it": lambda path: -path.largest_gap,
    "distance of the ends": lambda path: -path.end_gap,
    "least distance from the arm": lambda path: path.clearance,
    "how far outside the elbow, less the operator's": lambda path: (
        path.outside - path.outside_expert
    ),
}

#: A row, its demonstration set, and of each path its measures and whether it dressed.
Found = tuple[list[tuple[float, ...]], list[bool]]


def look(folder: Path, entry: Entry, demonstration_set: int) -> Found:
    """The measures (n, 5) of a policy's paths, and whether each dressed (n,)."""
    run = load_run(folder)
    jobs = [
        job
        for job in run.plan.jobs
        if job.entry == entry and job.demonstration_set == demonstration_set
    ]
    source = learned_source(run, jobs[0])
    measures, dressed = [], []
    for job in jobs:
        outcome = parse_episode(run.plan, run.line(job.index)).outcome
        posture, config, _ = job.situation(run.plan.config)
        start = grip_start(posture, config.world.sleeve)
        if outcome.invalid is not None:
            continue
        try:
            path = policy_path(source, posture, start, job.seed, DEFAULT_PATH_DT, config.time_limit)
        except PolicyError:
            continue
        metrics = path_metrics(path.positions, steady_path(posture), posture)
        measures.append(tuple(of(metrics) for of in MEASURES.values()))
        dressed.append(outcome.success)
    return measures, dressed


def pairs(measure: NDArray[np.float64], dressed: NDArray[np.bool_]) -> tuple[float, int]:
    """How many pairs of success and failure a measure (n,) ranks rightly, and of how many."""
    good, bad = measure[dressed], measure[~dressed]
    right = np.sign(good[:, None] - bad[None, :])
    return float(np.sum(0.5 * (1.0 + right))), right.size


def measured(folder: Path, console: Console) -> dict[Entry, list[Found]]:
    """What was found of each row that learned, by demonstration set."""
    protocol = load_run(folder).plan.protocol
    rows = [entry for entry in protocol.entries if entry.demonstrations is not None]
    calls = [(entry, number) for entry in rows for number in range(protocol.demonstration_sets)]
    found: dict[tuple[Entry, int], Found] = {}
    with Processes(processors()) as crew, show_progress(console) as progress:
        progress("policies", 0, len(calls), "")
        for key, future in completed(crew, look, ((call, (folder, *call)) for call in calls)):
            found[key] = future.result()
            progress("policies", len(found), len(calls), "")
    return {
        entry: [found[entry, number] for number in range(protocol.demonstration_sets)]
        for entry in rows
    }


def areas(rows: Sequence[list[Found]], place: int) -> Iterator[float]:
    """The probability of a measure, and of 2,000 samples with other demonstration sets."""
    rng = np.random.default_rng(0)
    for sample in range(2001):
        right = n = 0.0
        for sets in rows:
            chosen = rng.integers(len(sets), size=len(sets)) if sample else range(len(sets))
            values = np.array([m[place] for one in chosen for m in sets[one][0]])
            dressed = np.array([d for one in chosen for d in sets[one][1]], dtype=bool)
            counted, of = pairs(values, dressed)
            right, n = right + counted, n + of
        if n:
            yield right / n


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("folder", type=Path, help="of a finished run")
    rows = list(measured(parser.parse_args().folder, Console(stderr=True)).values())
    cells = [["measure", "ranks a success above a failure", "95 % interval, other sets"]]
    for place, name in enumerate(MEASURES):
        estimate, *samples = areas(rows, place)
        low, high = np.quantile(samples, [0.025, 0.975])
        cells.append([name, f"{estimate:.2f}", f"{low:.2f} - {high:.2f}"])
    sys.stdout.write(markdown_table(cells) + "\n")


if __name__ == "__main__":
    main()
