"""Where the work is done: processes of this machine, or others, and what if one dies."""

from __future__ import annotations

import multiprocessing
import os
import threading
from abc import abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent import futures
from concurrent.futures import Future
from itertools import islice
from multiprocessing import connection
from typing import Any, TypeVar

from dressing_sim.errors import DressingSimError
from dressing_sim.numerics import common_to_children, single_threaded
from dressing_sim.numerics import numerics as worker_numerics
from dressing_sim.system import (
    check_may_start_processes,
    ignore_interrupt,
    leave,
    starting_process,
)

Key = TypeVar("Key")

#: Calls handed to the workers ahead, for each worker; enough to keep it busy, and few, so that
#: memory does not grow with the number of episodes.
_AHEAD = 4


class WorkerDied(DressingSimError):
    """The worker died under a call, and so did the one that tried it again."""


class Workers(futures.Executor):
    """An executor whose workers can die.

    Each call gets one thread for linear algebra: workers do not slow down each other, and bits do
    not depend on the number of processors. Leaving its ``with`` block by an error or Ctrl-C ends
    the workers at once.

    Attributes:
        deaths: Exceptions of a future that say that a worker died, rather than the call failed.
        shared_fate: Whether a death ends all calls in flight, whichever of them it was.
    """

    deaths: tuple[type[BaseException], ...] = (futures.BrokenExecutor,)
    shared_fate: bool = True

    @property
    @abstractmethod
    def count(self) -> int:
        """How many calls run at the same time."""

    def numerics(self) -> Mapping[str, str]:
        """What the workers compute with (see `dressing_sim.numerics.numerics`)."""
        ((_, future),) = completed(self, worker_numerics, [("numerics", ())])
        found: Mapping[str, str] = future.result()
        return found

    def renew(self) -> None:
        """Make the executor usable again after a death."""

    def stop(self) -> None:
        """End all work at once."""
        self.shutdown(wait=False, cancel_futures=True)

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.shutdown()
        else:
            self.stop()


class Processes(Workers):
    """Fresh processes of this machine; they end with this process, however it ends.

    Args:
        count: How many.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._open()

    def _open(self) -> None:
        check_may_start_processes()
        # Spawned rather than forked: OpenGL, BLAS and MuJoCo hold threads that a fork would break.
        context = multiprocessing.get_context("spawn")
        # Nobody writes to the leash. It breaks when this process closes it, or is killed.
        worker_end, self._leash = context.Pipe(duplex=False)
        self._pool = futures.ProcessPoolExecutor(
            self._count, mp_context=context, initializer=_heed, initargs=(worker_end,)
        )

    @property
    def count(self) -> int:
        return self._count

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        # The pool starts its processes in here. A terminal sends Ctrl-C to all; this one answers.
        with starting_process(), common_to_children():
            return self._pool.submit(single_threaded, fn, *args, **kwargs)

    def renew(self) -> None:
        self.stop()
        self._open()

    def stop(self) -> None:
        self._leash.close()
        self._pool.shutdown(wait=True, cancel_futures=True)

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._pool.shutdown(wait, cancel_futures=cancel_futures)
        if wait:
            self._leash.close()


def _heed(leash: connection.Connection) -> None:
    """In a worker: end it as soon as the leash breaks, whatever it is doing; nothing else does."""
    ignore_interrupt()

    def watch() -> None:
        connection.wait([leash])
        leave(1)

    threading.Thread(target=watch, daemon=True).start()


def completed(
    workers: Workers, function: Callable[..., Any], calls: Iterable[tuple[Key, tuple[Any, ...]]]
) -> Iterator[tuple[Key, Future[Any]]]:
    """Call a function many times, and tell of each call as it ends, in any order.

    If a worker dies, the calls that died with it are tried again, one at a time: so the one that
    kills its worker is found, and the others are not blamed for it. A call is given up after two
    deaths of its own.

    Args:
        workers: Where to.
        function: What to call; a function of a module, as other processes must find it.
        calls: A key to know each call by, and its arguments; read as the workers come to it.

    Yields:
        The key, and a future that is done; its exception is `WorkerDied` if the worker died twice.
    """
    remaining = iter(calls)
    flying: dict[Future[Any], tuple[Key, tuple[Any, ...]]] = {}
    while True:
        suspects = []
        for call in islice(remaining, max(0, _AHEAD * workers.count - len(flying))):
            try:
                flying[workers.submit(function, *call[1])] = call
            except workers.deaths:
                suspects.append(call)
                break
        if not flying and not suspects:
            return
        done, _ = futures.wait(flying, return_when=futures.FIRST_COMPLETED)
        if suspects or any(_died(workers, future) for future in done):
            done, _ = futures.wait(flying)
        # In the order of the calls: if one of them is in error, those before it are told of.
        for future in [future for future in flying if future in done]:
            call = flying.pop(future)
            if _died(workers, future):
                suspects.append(call)
            else:
                yield call[0], future
        if suspects:
            workers.renew()
            # Workers that die whatever they do are no fault of a call.
            if _died(workers, workers.submit(os.getpid)):
                raise DressingSimError(
                    "no worker can be started here; is there enough memory, and is a script's work "
                    "under if __name__ == '__main__':?"
                )
        for key, arguments in suspects:
            yield key, _alone(workers, function, arguments)


def _alone(
    workers: Workers, function: Callable[..., Any], arguments: tuple[Any, ...]
) -> Future[Any]:
    """Try with nothing else in flight, until two deaths are known to be the call's own."""
    for _ in range(2 if workers.shared_fate else 1):
        future = workers.submit(function, *arguments)
        if not _died(workers, future):
            return future
        workers.renew()
    future = Future()
    future.set_exception(WorkerDied("worker died twice"))
    return future


def _died(workers: Workers, future: Future[Any]) -> bool:
    """Whether the worker died under a call; waits for its end."""
    try:
        found = future.exception()
    except futures.CancelledError as error:
        found = error
    if isinstance(found, futures.CancelledError):
        raise DressingSimError("the work was cancelled: the scheduler is gone") from found
    return isinstance(found, workers.deaths)
