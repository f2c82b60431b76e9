import json
import os
import signal
from concurrent.futures import ThreadPoolExecutor

import distributed
import pytest
from fake_benchmark import by_process, dask_cluster, obey, run, small_plan, tries, wait_until

from dressing_sim import provenance
from dressing_sim.benchmark.run import dask_workers
from dressing_sim.benchmark.run.dask_workers import DaskWorkers
from dressing_sim.benchmark.run.executors import Processes, completed
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.provenance import versions


def square(number):
    return number**2


def try_square(folder, number):
    obey(folder, str(number))
    return number**2


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
        shown = [f"demonstration-{posture.name}" for posture in plan.demonstrated["case_a"]]
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
    monkeypatch.setattr(dask_workers, "_PATIENCE", 0.5)
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
        monkeypatch.setattr(dask_workers, "_PATIENCE", 2.0)
        with pytest.raises(InvalidInputError, match="has no workers"):
            DaskWorkers(cluster.address)


class OtherVersions:
    """What is installed here, in the eyes of this process; elsewhere it is the real function."""

    def __call__(self):
        return versions() | {"mujoco": "0.1"}

    def __reduce__(self):
        return getattr, (provenance, "versions")


def test_a_worker_with_other_versions_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(dask_workers, "versions", OtherVersions())
    with (
        dask_cluster(tmp_path, 1) as cluster,
        pytest.raises(InvalidInputError, match=r"has mujoco [1-9].*, valid is 0\.1"),
    ):
        DaskWorkers(cluster.address)


def test_workers_that_compute_different_bits_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(dask_workers, "numerics", by_process)
    with dask_cluster(tmp_path, 2) as cluster:
        with distributed.Client(cluster.address, set_as_default=False) as client:
            client.wait_for_workers(2)
        with pytest.raises(InvalidInputError, match=r"different bits \(blas openblas \d+ on tcp"):
            DaskWorkers(cluster.address)


def test_a_call_that_is_cancelled_keeps_nobody_waiting(tmp_path):
    (tmp_path / "hold").touch()
    with dask_cluster(tmp_path, 1) as cluster, DaskWorkers(cluster.address) as workers:
        futures = [workers.submit(try_square, tmp_path, number) for number in (0, 1)]
        wait_until(lambda: tries(tmp_path, 0))
        assert futures[1].cancel()
        (tmp_path / "hold").unlink()
        assert futures[0].result() == 0
    assert futures[1].cancelled()
