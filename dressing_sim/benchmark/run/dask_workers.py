"""A running Dask cluster as the place where the work is done."""

from __future__ import annotations

import logging
from collections.abc import Callable
from concurrent.futures import Future
from concurrent.futures import wait as wait_for
from functools import partial
from typing import Any
from weakref import WeakSet

from dressing_sim.benchmark.run.executors import Workers
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.numerics import numerics, single_threaded, unlike
from dressing_sim.provenance import versions

#: A cluster that does not answer, or has no worker, for so long is reported [s].
_PATIENCE = 30.0


class DaskWorkers(Workers):
    """A running Dask cluster, whose machines have this package installed.

    Start its workers with one thread each. Dask itself tries a call on other workers before it
    reports a death (its setting ``scheduler.allowed-failures``).

    Args:
        address: Of the scheduler, such as ``tcp://10.0.0.1:8786``.

    Raises:
        InvalidInputError: Dask is not installed, nobody answers, or a worker has other versions.
    """

    def __init__(self, address: str) -> None:
        try:
            from distributed import Client, KilledWorker
            from distributed.comm import get_address_host_port
        except ImportError as error:
            raise InvalidInputError(
                "--scheduler needs Dask; install it with: pip install 'dressing-sim[dask]'"
            ) from error
        # Its lines about lost connections would drown ours, which say what to do.
        logging.getLogger("distributed").setLevel(logging.CRITICAL)
        self.deaths, self.shared_fate = (KilledWorker,), False
        self._address = address
        try:
            # A client of what is no address would be waited for as the process ends.
            get_address_host_port(address)
            self._client = Client(address, timeout=_PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            raise InvalidInputError(f"scheduler {address!r}: nobody answers ({error})") from error
        try:
            self._check_workers()
        except BaseException:
            self._client.close()
            raise
        self._futures: WeakSet[Future[Any]] = WeakSet()

    def _check_workers(self) -> None:
        try:
            self._client.wait_for_workers(1, timeout=_PATIENCE)
            found = self._client.run(versions, on_error="return")
        except (OSError, TimeoutError) as error:
            raise InvalidInputError(f"scheduler {self._address!r} has no workers") from error
        for worker, theirs in found.items():
            if isinstance(theirs, Exception):
                raise InvalidInputError(
                    f"worker {worker} cannot run dressing-sim ({theirs!r}); install it there"
                )
            for package, ours in versions().items():
                if theirs[package] != ours:
                    raise InvalidInputError(
                        f"worker {worker} has {package} {theirs[package]}, valid is {ours} as here"
                    )
        first, *others = self._client.run(numerics).items()
        for worker, theirs in others:
            told = unlike(first[1], theirs, f"on {first[0]}", f"on {worker}")
            if told:
                raise InvalidInputError(
                    f"workers compute different bits ({told}); valid are processors of one kind, "
                    "or workers started in the environment that 'dressing-sim doctor' prints"
                )

    @property
    def count(self) -> int:
        try:
            return max(1, sum(self._client.nthreads().values()))
        except OSError as error:
            raise DressingSimError(f"lost the scheduler {self._address!r}") from error

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        # Not pure: Dask may not answer a call from memory that it has seen before.
        remote = self._client.submit(single_threaded, fn, *args, pure=False, **kwargs)
        future: Future[Any] = Future()
        self._futures.add(future)
        remote.add_done_callback(partial(_pass_on, future))
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        if wait and not cancel_futures:
            wait_for(self._futures)
        self._client.close()


def _pass_on(future: Future[Any], remote: Any) -> None:
    """Tell a future what became of Dask's.

    Dask's own executor asks for the result first and for its status afterwards; in between a dying
    worker can take the result with it, and what was a success is then unpacked as an error.
    """
    if not future.set_running_or_notify_cancel():
        return
    try:
        future.set_result(remote.result())
    except Exception as error:  # whatever the call raised is the caller's
        future.set_exception(error)
