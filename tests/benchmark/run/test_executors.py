import os
import signal
import subprocess
import sys
from concurrent.futures import BrokenExecutor, Future

import numpy as np
import pytest
from fake_benchmark import (
    Threads,
    is_running,
    obey,
    tries,
    wait_until,
)
from threadpoolctl import threadpool_info

from dressing_sim.benchmark.run import executors
from dressing_sim.benchmark.run.executors import Processes, WorkerDied, completed
from dressing_sim.errors import DressingSimError, InvalidInputError


def square(number):
    return number**2


def fails(number):
    raise InvalidInputError(f"{number} is not valid")


def try_square(folder, number):
    obey(folder, str(number))
    return number**2


def blas_threads():
    assert np.ones((2, 2)) @ np.ones((2, 2)) is not None
    return [pool["num_threads"] for pool in threadpool_info()]


def test_every_call_is_told_of_once_with_its_key():
    with Threads(2) as workers:
        calls = ((n, (n,)) for n in range(40))
        found = {key: future.result() for key, future in completed(workers, square, calls)}
    assert found == {n: n**2 for n in range(40)}


def test_calls_are_drawn_as_the_workers_come_to_them():
    drawn = []

    def calls():
        for number in range(100):
            drawn.append(number)
            yield number, (number,)

    with Threads(2) as workers:
        told = completed(workers, square, calls())
        next(told)
        assert len(drawn) <= 8
        assert len(list(told)) == 99
        assert workers.most <= 8


def test_an_error_of_a_call_is_the_calls_own():
    with Threads(1) as workers:
        told = dict(completed(workers, fails, [("key", (3,))]))
        with pytest.raises(InvalidInputError, match="3 is not valid"):
            told["key"].result()


def test_no_calls_need_no_workers():
    with Processes(1) as workers:
        assert list(completed(workers, square, [])) == []


def test_a_dead_worker_is_replaced_and_all_calls_in_flight_are_tried_again(tmp_path):
    (tmp_path / "kill-3").touch()
    calls = [(n, (tmp_path, n)) for n in range(8)]
    with Processes(2) as workers:
        found = {key: future.result() for key, future in completed(workers, try_square, calls)}
    assert found == {n: n**2 for n in range(8)}
    assert len(tries(tmp_path, 3)) == 2


def test_only_the_call_that_kills_its_worker_twice_is_blamed(tmp_path):
    (tmp_path / "deadly-2").touch()
    calls = [(n, (tmp_path, n)) for n in range(8)]
    with Processes(2) as workers:
        found = {k: f.exception() or f.result() for k, f in completed(workers, try_square, calls)}
    assert isinstance(found.pop(2), WorkerDied)
    assert found == {n: n**2 for n in range(8) if n != 2}
    assert len(tries(tmp_path, 2)) == 3  # among others, and twice alone


class Mortal(Threads):
    """Workers that all die with the first call, and then under call 3 as often as told."""

    def __init__(self, deaths):
        super().__init__(2)
        self.left, self.renewed = deaths, False

    def submit(self, fn, /, *args, **kwargs):
        if not self.renewed or (args == (3,) and self.left > 0):
            self.left -= self.renewed
            future = Future()
            future.set_exception(BrokenExecutor())
            return future
        return super().submit(fn, *args, **kwargs)

    def renew(self):
        self.renewed = True


@pytest.mark.parametrize(("deaths", "blamed"), [(0, set()), (1, set()), (2, {3})])
def test_a_death_in_company_is_held_against_nobody(deaths, blamed):
    """Whether a call had begun when another killed its worker is a matter of timing."""
    told = completed(Mortal(deaths), square, [(n, (n,)) for n in range(8)])
    assert {key for key, future in told if future.exception()} == blamed


def test_workers_that_cannot_start_are_an_error_and_blame_no_call(monkeypatch):
    monkeypatch.setattr(executors, "_heed", sys.exit)
    with Processes(1) as workers, pytest.raises(DressingSimError, match="no worker can be started"):
        list(completed(workers, square, [(1, (1,))]))


def test_an_error_ends_the_workers_at_once(tmp_path):
    (tmp_path / "hold").touch()
    calls = [(number, (tmp_path, number)) for number in range(2)]

    def interrupted():
        with Processes(2) as workers:
            for _, arguments in calls:
                workers.submit(try_square, *arguments)
            wait_until(lambda: tries(tmp_path, 0) and tries(tmp_path, 1))
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    pids = tries(tmp_path, 0) + tries(tmp_path, 1)
    assert not any(is_running(pid) for pid in pids)


def test_workers_leave_an_interrupt_to_their_parent(tmp_path):
    (tmp_path / "hold").touch()
    with Processes(1) as workers:
        future = workers.submit(try_square, tmp_path, 5)
        wait_until(lambda: tries(tmp_path, 5))
        os.kill(tries(tmp_path, 5)[0], signal.SIGINT)
        (tmp_path / "hold").unlink()
        assert future.result() == 25


def test_a_call_has_one_thread_for_linear_algebra():
    with Processes(1) as workers:
        assert set(workers.submit(blas_threads).result()) == {1}


INTERRUPTED = """
import os, signal, threading, time
from dressing_sim.benchmark.run.executors import Processes
answered = 0
if __name__ == "__main__":
    # Whoever was begun in the background ignores Ctrl-C.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for moment in range(24):
        try:
            with Processes(3) as workers:
                interrupt = threading.Timer(moment / 1000, os.kill, (os.getpid(), signal.SIGINT))
                interrupt.start()
                workers.submit(abs, -1)
                while True:  # a wait would not end if another thread received it
                    time.sleep(0.01)
        except KeyboardInterrupt:
            answered += 1
        interrupt.join()
    print(answered)
"""


def test_an_interrupt_while_workers_start_leaves_none_that_complains(tmp_path):
    script = tmp_path / "interrupted.py"
    script.write_text(INTERRUPTED)
    told = subprocess.run([sys.executable, script], capture_output=True, text=True, timeout=180)
    assert (told.returncode, told.stdout, told.stderr) == (0, "24\n", "")
