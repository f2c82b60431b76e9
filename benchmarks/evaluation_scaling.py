"""How evaluation scales: one worker against two, and the memory of a worker.

    python benchmarks/evaluation_scaling.py [--suite test200] [--rounds 3]

Runs the expert on a suite with one worker and with two, in turn, and prints the ratio of the two
medians of wall time, starting the workers included, and the largest resident memory of any worker.
Drawing a ``random:N`` suite, which one process does, is included too. Use an idle machine.
"""

from __future__ import annotations

import argparse
import tempfile
import threading
import time
from pathlib import Path
from statistics import median

import psutil

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.study import run_jobs


def watch(stop: threading.Event, largest: list[int]) -> None:
    """Keep the largest resident memory of any child of this process [bytes]."""
    me = psutil.Process()
    while not stop.wait(0.5):
        for child in me.children(recursive=True):
            try:
                largest[0] = max(largest[0], child.memory_info().rss)
            except psutil.NoSuchProcess:
                continue


def measure(workers: int, suite: str) -> float:
    """Wall time of one evaluation [s]."""
    protocol = Protocol("scaling", suite, (Entry("expert"),))
    with tempfile.TemporaryDirectory() as folder:
        begun = time.perf_counter()
        plan = make_plan(protocol, 0)
        with Processes(workers) as crew, open_run(Path(folder) / "run", plan, False) as run:
            run_jobs(find_study(protocol.study), run, crew)
        return time.perf_counter() - begun


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--suite", default="test200")
    parser.add_argument("--rounds", type=int, default=3)
    chosen = parser.parse_args()
    stop, largest = threading.Event(), [0]
    watcher = threading.Thread(target=watch, args=(stop, largest), daemon=True)
    watcher.start()
    times: dict[int, list[float]] = {1: [], 2: []}
    for _ in range(chosen.rounds):
        for workers, seconds in times.items():
            seconds.append(measure(workers, chosen.suite))
            print(f"{workers} worker(s): {seconds[-1]:.1f} s", flush=True)
    stop.set()
    watcher.join()
    ratio = median(times[1]) / median(times[2])
    print(f"two workers are {ratio:.2f} times one; a worker needs {largest[0] / 2**20:.0f} MiB")


if __name__ == "__main__":
    main()
