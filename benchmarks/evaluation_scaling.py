"""What a run costs beside its episodes: workers, a Dask cluster, and the memory of a worker.

    python benchmarks/evaluation_scaling.py [--suite val50] [--rounds 3] [--dask]

The expert dresses a suite with one worker, with two, and, if asked, with a Dask cluster of two on
this machine, in turn. Printed are medians: the wall time of each, starting the workers included;
episodes an hour of a core; what processor time is spent beside an episode, to hand it out and to
keep its result, and what it takes to wait, whatever the number of episodes; the largest resident
memory of any worker. Drawing a ``random:N`` suite, which one process does, is included in wall
times. Use an idle machine.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from statistics import mean, median
from typing import Any

import psutil

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.run.dask_workers import DaskWorkers
from dressing_sim.benchmark.run.executors import Processes, Workers
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.runner import Work, dress_job
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.benchmark.studies.study import run_jobs
from dressing_sim.benchmark.studies.success import Success

#: So many results have paid for the start of all workers, and what each loads with its first call.
_STARTED = 10

#: How long nothing is done, to see what that takes [s].
_WAITED = 10.0

#: Where workers leave how long each of their episodes took them.
_TIMES = "DRESSING_SIM_BENCHMARK_TIMES"


def timed(*args: Any, **kwargs: Any) -> EpisodeResult:
    """An episode, as `dress_job` has it; noted are its worker and when it began and ended there."""
    begun = time.process_time()
    result = dress_job(*args, **kwargs)
    with open(os.environ[_TIMES], "a", encoding="utf-8") as lines:
        lines.write(f"{os.getpid()} {begun} {time.process_time()}\n")
    return result


@contextlib.contextmanager
def cluster(count: int) -> Iterator[DaskWorkers]:
    """A Dask cluster on this machine, one thread a worker."""
    from distributed import LocalCluster

    with (
        LocalCluster(n_workers=count, threads_per_worker=1, dashboard_address=None) as local,
        DaskWorkers(local.scheduler_address) as workers,
    ):
        yield workers


@dataclass(frozen=True)
class Cost:
    """Of one run.

    Attributes:
        wall: From the plan to the last result [s].
        waiting: Processor time that this process, in which Dask's scheduler is too, takes a second
            while there is nothing to do.
        episode: Processor time of an episode itself [s].
        beside: Processor time an episode of everything else [s]: of a worker between two episodes,
            and of this process, from the tenth to the last result, beyond what waiting takes.
    """

    wall: float
    waiting: float
    episode: float
    beside: float


def measure(crew: Callable[[], contextlib.AbstractContextManager[Workers]], suite: str) -> Cost:
    """Run the expert on a suite."""
    protocol = Protocol("scaling", suite, (Entry("expert"),))
    marks: dict[int, tuple[float, float]] = {}

    def watch(stage: str, done: int, total: int, note: str) -> None:
        if stage == "episodes" and done in (_STARTED, total):
            marks[done] = time.process_time(), time.perf_counter()

    with tempfile.TemporaryDirectory() as folder:
        times = Path(folder) / "times"
        os.environ[_TIMES] = str(times)
        begun = time.perf_counter()
        plan = make_plan(protocol, 0)
        with crew() as workers, open_run(Path(folder) / "run", plan, False) as run:
            run_jobs(Success(Work(dress=timed)), run, workers, watch)
            wall = time.perf_counter() - begun
            idle = time.process_time()
            time.sleep(_WAITED)
            waiting = (time.process_time() - idle) / _WAITED
        ends: dict[str, list[tuple[float, float]]] = {}
        for line in times.read_text(encoding="utf-8").splitlines():
            worker, start, end = line.split()
            ends.setdefault(worker, []).append((float(start), float(end)))
    inside = [end - start for own in ends.values() for start, end in own]
    gaps = [start - end for own in ends.values() for (_, end), (start, _) in pairwise(own)]
    first, last = min(marks), max(marks)
    spent, passed = (
        after - before for before, after in zip(marks[first], marks[last], strict=True)
    )
    here = (spent - waiting * passed) / (last - first)
    return Cost(wall, waiting, mean(inside), here + mean(gaps))


def watch_memory(stop: threading.Event, largest: list[int]) -> None:
    """Keep the largest resident memory of any child of this process [bytes]."""
    me = psutil.Process()
    while not stop.wait(0.5):
        for child in me.children(recursive=True):
            with contextlib.suppress(psutil.NoSuchProcess):
                largest[0] = max(largest[0], child.memory_info().rss)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--suite", default="val50")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--dask", action="store_true", help="a Dask cluster here, too")
    chosen = parser.parse_args()
    crews: dict[str, Callable[[], Any]] = {
        "1 worker": lambda: Processes(1),
        "2 workers": lambda: Processes(2),
    }
    if chosen.dask:
        crews["Dask, 2 workers"] = lambda: cluster(2)
    stop, largest = threading.Event(), [0]
    watcher = threading.Thread(target=watch_memory, args=(stop, largest), daemon=True)
    watcher.start()
    costs: dict[str, list[Cost]] = {name: [] for name in crews}
    for _ in range(chosen.rounds):
        for name, crew in crews.items():
            cost = measure(crew, chosen.suite)
            costs[name].append(cost)
            print(
                f"{name}: {cost.wall:.1f} s, {cost.episode:.3f} s an episode and "
                f"{1000 * cost.beside:.1f} ms beside, {100 * cost.waiting:.1f} % of a core to wait",
                flush=True,
            )
    stop.set()
    watcher.join()
    print()
    for name, measured in costs.items():
        inside = median(cost.episode for cost in measured)
        beside = median(cost.beside for cost in measured)
        waiting = median(cost.waiting for cost in measured)
        print(
            f"{name}: {median(cost.wall for cost in measured):.0f} s, "
            f"{3600 / (inside + beside):.0f} episodes an hour of a core, "
            f"{100 * beside / inside:.1f} % of an episode beside it, "
            f"{100 * waiting:.1f} % of a core to wait"
        )
    one, two = (median(cost.wall for cost in costs[name]) for name in ("1 worker", "2 workers"))
    print(f"two workers are {one / two:.2f} times one; a worker needs {largest[0] / 2**20:.0f} MiB")


if __name__ == "__main__":
    main()
