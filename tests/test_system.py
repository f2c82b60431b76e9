import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from types import SimpleNamespace

import pytest

import dressing_sim
from dressing_sim import system

#: Imports every module of the package where nothing of POSIX is there.
ELSEWHERE = """
import importlib.util, os, pkgutil, signal, sys

for name in ("fcntl", "resource", "termios", "pwd", "grp"):
    sys.modules[name] = None
import numpy, scipy, h5py, matplotlib, mujoco, pinocchio, daqp  # theirs is their own affair
for name in ("sched_getaffinity", "fork", "getuid"):
    if hasattr(os, name):
        delattr(os, name)
for name in ("pthread_sigmask", "SIGKILL", "SIGHUP"):
    if hasattr(signal, name):
        delattr(signal, name)
import dressing_sim
# Optional extras, which not every Python can install; gymnasium's wheels are everywhere.
extras = ("dm_control", "lerobot")
absent = {name for name in extras if importlib.util.find_spec(name) is None}
found = 0
for module in pkgutil.walk_packages(dressing_sim.__path__, "dressing_sim."):
    if not module.name.endswith("__main__"):
        try:
            importlib.import_module(module.name)
        except ModuleNotFoundError as error:
            if error.name not in absent:
                raise
        found += 1
from dressing_sim.system import starting_process, processors
with starting_process():
    pass
assert processors() >= 1
print(found)
"""


def test_every_module_can_be_imported_without_posix():
    told = subprocess.run([sys.executable, "-c", ELSEWHERE], capture_output=True, text=True)
    assert told.returncode == 0, told.stderr
    files = Path(dressing_sim.__file__).parent.rglob("*.py")
    assert int(told.stdout) >= 0.8 * len(list(files))


def test_a_locked_file_is_locked_for_others(tmp_path):
    path = tmp_path / "lock"
    with path.open("ab") as mine, path.open("ab") as other:
        system.lock_file(mine)
        with pytest.raises(BlockingIOError):
            system.lock_file(other)
    with path.open("ab") as again:
        system.lock_file(again)


class Msvcrt(SimpleNamespace):
    """Windows' module with one lock for all files: what `system` uses of it."""

    LK_NBLCK = 2

    def locking(self, descriptor, mode, n_bytes):
        assert (mode, n_bytes) == (self.LK_NBLCK, 1)
        if self.held:
            raise PermissionError(13, "Permission denied")
        self.held = True


def test_without_fcntl_a_byte_is_locked(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "fcntl", None)
    monkeypatch.setitem(sys.modules, "msvcrt", Msvcrt(held=False))
    with (tmp_path / "lock").open("ab") as file:
        system.lock_file(file)
        with pytest.raises(BlockingIOError):
            system.lock_file(file)


@pytest.mark.skipif(not hasattr(signal, "pthread_sigmask"), reason="signals cannot be blocked here")
def test_an_interrupt_waits_until_processes_are_started():
    reached = []
    # Whoever was begun in the background ignores Ctrl-C, and would so here.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def interrupted():
        with system.starting_process():
            # To this thread: another one, of a library, may not block it.
            signal.pthread_kill(threading.get_ident(), signal.SIGINT)
            reached.append("the end of the block")

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    signal.signal(signal.SIGINT, before)
    assert reached


def test_an_interrupt_that_another_thread_receives_waits_too():
    reached = []
    before = signal.signal(signal.SIGINT, signal.default_int_handler)

    def interrupted():
        over = threading.Event()
        other = threading.Thread(target=over.wait)  # it blocks nothing
        other.start()
        try:
            with system.starting_process():
                os.kill(os.getpid(), signal.SIGINT)
                reached.append("the end of the block")
        finally:
            over.set()
            other.join()

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    signal.signal(signal.SIGINT, before)
    assert reached


LEAVES = """
import threading, time
from dressing_sim import system
with system.starting_process():
    threading.Thread(target=system.leave, args=(3,)).start()
    time.sleep(0.5)
    print("started", flush=True)
time.sleep(60)
"""


def test_who_leaves_starts_first_what_it_is_starting():
    told = subprocess.run([sys.executable, "-c", LEAVES], capture_output=True, text=True)
    assert (told.returncode, told.stdout, told.stderr) == (3, "started\n", "")


def test_processors_are_those_that_this_process_may_use(monkeypatch):
    monkeypatch.setattr(os, "sched_getaffinity", lambda pid: {0, 3, 5}, raising=False)
    assert system.processors() == 3
    monkeypatch.delattr(os, "sched_getaffinity")
    monkeypatch.setattr(os, "cpu_count", lambda: None)
    assert system.processors() == 1
