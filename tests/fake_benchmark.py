"""A benchmark without physics whose workers wait and die on command, and a cluster to run it on.

The commands are files in a folder: ``hold`` keeps all work from ending, ``hold-3`` episode 3,
``kill-3`` kills the next worker that tries it, ``deadly-3`` all that do. Every try leaves a file
behind. As a script, ``fake_benchmark.py FOLDER evaluate ...`` is the command line without physics.
"""

import json
import os
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import psutil

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.benchmark.run.plan import demonstration_seed, make_plan
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.study import run_jobs
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.cli import main
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.policies.expert import operator_of
from dressing_sim.world.scene import grip_start

#: A condition that does not come true in this time fails the test [s]; it is never slept through.
DEADLINE = 180.0


def by_process():
    """Numerics that are others in each process, as on processors of two kinds."""
    return {"fingerprint": str(os.getpid()), "blas": f"openblas {os.getpid()}"}


class Threads(Workers):
    """Workers that cannot die; counts what is in flight."""

    def __init__(self, count):
        self._executor, self._count = ThreadPoolExecutor(count), count
        self.most, self._flying, self._lock = 0, 0, threading.Lock()

    @property
    def count(self):
        return self._count

    def submit(self, fn, /, *args, **kwargs):
        with self._lock:
            self._flying += 1
            self.most = max(self.most, self._flying)
        future = self._executor.submit(fn, *args, **kwargs)
        future.add_done_callback(self._landed)
        return future

    def _landed(self, _):
        with self._lock:
            self._flying -= 1

    def shutdown(self, wait=True, *, cancel_futures=False):
        self._executor.shutdown(wait, cancel_futures=cancel_futures)


class FakePolicy:
    """Remembers what it learned from."""

    def __init__(self, name, seed, demonstrations):
        self.learned = name, seed, [(d.posture.name, d.seed) for d in demonstrations]


def fake_demonstrate(folder, plan_seed, posture, number, config, style=""):
    seed = demonstration_seed(plan_seed, posture, number, 0)
    obey(folder, f"demonstration-{posture.name}")
    line = np.linspace(posture.wrist, posture.shoulder, 30) + seed * 1e-12
    return Demonstration(line, 0.05, posture, seed, np.zeros((30, 7)))


def steady_demonstrate(plan_seed, posture, number, config, style=""):
    """What the operator would do, without a world."""
    seed = demonstration_seed(plan_seed, posture, number, 0)
    start = grip_start(posture, config.world.sleeve)
    path = operator_of(style).path(posture, start, np.random.default_rng(seed))
    return Demonstration(path, 0.02, posture, seed, np.zeros((len(path), 7)))


def fake_fit(folder, name, seed, demonstrations, limits, log):
    obey(folder, f"policy-{name}")
    return FakePolicy(name, seed, demonstrations)


def fake_dress(folder, source, job, config, observer=None):
    obey(folder, str(job.index))
    learned = getattr(source, "learned", "expert")
    rng = np.random.default_rng([job.index, job.seed, len(str(learned))])
    figures = {"armscye_s": rng.normal(), "strain": rng.uniform() / 3.0}
    failures = () if rng.uniform() < 0.5 else (Failure("stuck", f"after {learned}", 1 / 3, None),)
    outcome = Outcome(not failures, failures, figures)
    return EpisodeResult(
        job.index, job.entry, job.posture, job.demonstration_set, job.seed, {}, outcome
    )


def obey(folder, what):
    with (folder / f"tried-{what}").open("a") as file:
        file.write(f"{os.getpid()}\n")
    wait_until(lambda: not any((folder / name).exists() for name in ("hold", f"hold-{what}")))
    if (folder / f"kill-{what}").exists():
        (folder / f"kill-{what}").unlink()
        os.kill(os.getpid(), signal.SIGKILL)
    if (folder / f"deadly-{what}").exists():
        os.kill(os.getpid(), signal.SIGKILL)


def fake_work(folder):
    return Work(*(partial(fake, folder) for fake in (fake_demonstrate, fake_fit, fake_dress)))


def tries(folder, what):
    """Processes that tried an episode, in their order."""
    file = folder / f"tried-{what}"
    return [int(line) for line in file.read_text().split()] if file.exists() else []


def wait_until(condition):
    end = time.monotonic() + DEADLINE
    while not condition():
        if time.monotonic() > end:
            raise AssertionError("waited in vain")
        time.sleep(0.02)


def is_running(pid):
    """Whether a process runs; one that ended and that nobody asked about does not."""
    try:
        return psutil.Process(pid).status() != psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return False


def start(folder, arguments, **settings):
    """The command line without physics in a process of its own."""
    command = [sys.executable, __file__, str(folder), *arguments]
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **settings
    )


def write_suite(path, count):
    angles = {"flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}
    arms = [{"name": f"arm{i}", "elbow_deg": 5.0 + i, **angles} for i in range(count)]
    path.write_text(json.dumps({"postures": arms}))
    return str(path)


@dataclass
class Cluster:
    """A scheduler's address, its process, and its workers' processes."""

    address: str
    scheduler: subprocess.Popen
    workers: list[subprocess.Popen]


@contextmanager
def dask_cluster(folder, workers):
    """A Dask cluster on this machine."""
    file = folder / "scheduler.json"
    # A task whose worker dies is ours to try again, not the scheduler's.
    environment = os.environ | {
        "PYTHONPATH": str(Path(__file__).parent),
        "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",
    }

    def launch(kind, *arguments):
        command = [sys.executable, "-m", f"distributed.cli.dask_{kind}"]
        command += ["--scheduler-file", str(file), "--host", "127.0.0.1", *arguments]
        with (folder / f"{kind}.log").open("a") as log:
            return subprocess.Popen(command, env=environment, stdout=log, stderr=log)

    running = [launch("scheduler", "--port", "0", "--no-dashboard")]
    try:
        wait_until(lambda: file.exists() and file.read_text().endswith("}"))  # it is whole
        options = ("--nthreads", "1", "--no-nanny", "--no-dashboard", "--death-timeout", "60")
        running += [launch("worker", *options) for _ in range(workers)]
        yield Cluster(json.loads(file.read_text())["address"], running[0], running[1:])
    finally:
        for process in running:
            process.kill()
            process.wait()


def run_script():
    # Tests that were begun in the background of a script ignore Ctrl-C, and so would this process.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    folder = Path(sys.argv.pop(1))
    STUDIES["success"] = partial(Success, fake_work(folder))
    main(sys.argv[1:])


def small_plan(folder):
    """Sixteen episodes: the operator and one policy on eight postures."""
    suite = write_suite(folder / "suite.json", 8)
    return make_plan(Protocol("p", suite, (Entry("expert"), Entry("tp-gmm", "case_a"))))


def run(folder, plan, workers):
    """Run a plan; returns the bytes of its episodes."""
    with open_run(folder / "run", plan) as opened:
        run_jobs(Success(fake_work(folder)), opened, workers)
    return (folder / "run/episodes.jsonl").read_bytes()


if __name__ == "__main__":
    # Workers must find the fakes by the name of a module, which __main__ is not.
    from fake_benchmark import run_script as run_as_module

    run_as_module()
