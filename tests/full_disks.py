"""Disks that are full and folders that take no files, for real, for whoever runs the tests."""

import os
import resource
import subprocess
from contextlib import contextmanager
from functools import partial

from fake_benchmark import fake_work
from fake_trials import fake_simulate

from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.convergence import Convergence
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.benchmark.studies.thresholds import ThresholdStudy


@contextmanager
def small_files(most):
    """No file of this process, and of those that it starts, gets larger than so many bytes."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@contextmanager
def mounted(folder, options):
    """A small disk of its own in a folder; False where this user cannot mount one."""
    command = ["mount", "-t", "tmpfs", "-o", options, "none", str(folder)]
    try:
        done = subprocess.run(command, capture_output=True, check=False).returncode == 0
    except OSError:
        done = False
    try:
        yield done
    finally:
        if done:
            subprocess.run(["umount", "-l", str(folder)], check=True)


@contextmanager
def closed(folder):
    """A folder that takes no new files: closed by its mode, or for root by how it is mounted."""
    folder.mkdir()
    if os.geteuid() != 0:
        folder.chmod(0o500)
        try:
            yield folder
        finally:
            folder.chmod(0o700)
        return
    with mounted(folder, "ro,size=64k") as done:
        yield folder if done else type(folder)("/proc")


def without_physics(monkeypatch, folder):
    """The studies with made-up results."""
    work = fake_work(folder)
    monkeypatch.setitem(STUDIES, "success", partial(Success, work))
    monkeypatch.setitem(STUDIES, "thresholds", partial(ThresholdStudy, work))
    monkeypatch.setitem(STUDIES, "convergence", partial(Convergence, fake_simulate))


def contents(folder):
    return {path: path.is_dir() or path.read_bytes() for path in folder.rglob("*")}
