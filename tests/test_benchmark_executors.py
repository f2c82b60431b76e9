import json
import os
import signal
import sys
from concurrent.futures import BrokenExecutor, Future, ThreadPoolExecutor

import distributed
import numpy as np
import pytest
from fake_benchmark import (
    Threads,
    dask_cluster,
    fake_work,
    is_running,
    obey,
    tries,
    wait_until,
    write_suite,
)
from threadpoolctl import threadpool_info

from dressing_sim import demonstration
from dressing_sim.benchmark import executors
from dressing_sim.benchmark.executors import (
    DaskWorkers,
    Processes,
    WorkerDied,
    completed,
)
from dressing_sim.benchmark.plan import make_plan
from dressing_sim.benchmark.protocol import Entry, Protocol
from dressing_sim.benchmark.runner import run_plan
from dressing_sim.benchmark.store import open_run
from dressing_sim.demonstration import versions
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


def small_plan(folder):
    suite = write_suite(folder / "suite.json", 8)
    return make_plan(Protocol("p", suite, (Entry("expert"), Entry("tp-gmm", "case_a"))))


def run(folder, plan, workers):
    with open_run(folder / "run", plan) as opened:
        run_plan(opened, workers, work=fake_work(folder))
    return (folder / "run/episodes.jsonl").read_bytes()


@pytest.fixture
def places(tmp_path):
    for name in ("here", "there"):
        (tmp_path / name).mkdir()
    return tmp_path / "here", tmp_path / "there"


def test_a_dask_cluster_gives_the_same_bytes_while_its_workers_are_killed(places, tmp_path):
    here, there = places
    plan = small_plan(tmp_path)
    with Processes(1) as workers:
        expected = run(here, plan, workers)
    (there / "kill-5").touch()  # one worker dies in an episode,
    (there / "hold").touch()
    with dask_cluster(tmp_path, 4) as cluster, DaskWorkers(cluster.address) as workers:
        running = ThreadPoolExecutor(1).submit(run, there, plan, workers)
        shown = [f"demonstration-{posture.name}" for posture in plan.shown["case_a"]]
        wait_until(lambda: all(tries(there, name) for name in shown))
        pid = tries(there, shown[0])[0]
        os.kill(pid, signal.SIGKILL)  # and another from outside, while it works
        (there / "hold").unlink()
        assert running.result() == expected
        assert len(tries(there, shown[0])) == len(tries(there, 5)) == 2
        wait_until(lambda: sum(worker.poll() is not None for worker in cluster.workers) == 2)
        wait_until(lambda: workers.count == 2)


def test_an_episode_that_kills_two_dask_workers_is_void_and_no_other(tmp_path):
    plan = small_plan(tmp_path)
    (tmp_path / "deadly-5").touch()
    with dask_cluster(tmp_path, 3) as cluster, DaskWorkers(cluster.address) as workers:
        lines = [json.loads(line) for line in run(tmp_path, plan, workers).splitlines()]
    assert [line["index"] for line in lines] == list(range(16))
    void = {line["index"]: line["void"] for line in lines if line["void"]}
    assert void == {5: "worker died twice"}


async def lost(self, *args, result=distributed.Future._result, **kwargs):
    """Dask's result of a call whose worker dies as soon as it has told of it."""
    told = await result(self, *args, **kwargs)
    self._state.lose()
    return told


def test_a_result_is_a_result_whatever_becomes_of_its_worker(tmp_path, monkeypatch):
    """Once fetched it is here; a worker that is lost meanwhile may not turn it into an error."""
    monkeypatch.setattr(distributed.Future, "_result", lost)
    with dask_cluster(tmp_path, 1) as cluster, DaskWorkers(cluster.address) as workers:
        found = [future.result() for _, future in completed(workers, square, [(3, (3,))])]
    assert found == [9]


def test_a_scheduler_that_goes_away_is_an_error(tmp_path):
    (tmp_path / "hold").touch()
    with dask_cluster(tmp_path, 1) as cluster, DaskWorkers(cluster.address) as workers:
        told = completed(workers, try_square, [(0, (tmp_path, 0))])
        asked = ThreadPoolExecutor(1).submit(next, told)
        wait_until(lambda: tries(tmp_path, 0))
        cluster.scheduler.kill()
        with pytest.raises(DressingSimError, match="scheduler"):
            asked.result()


def test_a_scheduler_that_does_not_answer_is_an_error_in_one_line(monkeypatch):
    monkeypatch.setattr(executors, "_PATIENCE", 0.5)
    with pytest.raises(InvalidInputError, match=r"127\.0\.0\.1:9.*nobody answers") as caught:
        DaskWorkers("tcp://127.0.0.1:9")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("address", ["nonsense", "foo://x:1", "tcp://x", ""])
def test_what_is_no_address_is_refused_before_a_client_is_made(address, monkeypatch):
    """One of no address would keep the process waiting as it ends."""

    def made(*_, **__):
        raise AssertionError("a client was made")

    monkeypatch.setattr(distributed, "Client", made)
    with pytest.raises(InvalidInputError, match="nobody answers"):
        DaskWorkers(address)


def test_a_cluster_without_workers_is_an_error(tmp_path, monkeypatch):
    with dask_cluster(tmp_path, 0) as cluster:
        monkeypatch.setattr(executors, "_PATIENCE", 2.0)
        with pytest.raises(InvalidInputError, match="has no workers"):
            DaskWorkers(cluster.address)


class OtherVersions:
    """What is installed here, in the eyes of this process; elsewhere it is the real function."""

    def __call__(self):
        return versions() | {"mujoco": "0.1"}

    def __reduce__(self):
        return getattr, (demonstration, "versions")


def test_a_worker_with_other_versions_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(executors, "versions", OtherVersions())
    with (
        dask_cluster(tmp_path, 1) as cluster,
        pytest.raises(InvalidInputError, match=r"has mujoco [1-9].*, valid is 0\.1"),
    ):
        DaskWorkers(cluster.address)
