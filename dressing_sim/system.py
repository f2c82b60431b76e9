"""What differs between operating systems, in one place; importing it needs nothing but Python."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from types import FrameType
from typing import IO, Any, Final, NoReturn

#: The file that libraries print errors to.
_STANDARD_ERROR = 2

#: Starting a process takes no longer [s].
_START: Final = 5.0


def lock_file(file: IO[Any]) -> None:
    """Lock an open file for this process until it is closed.

    Raises:
        BlockingIOError: Another process holds it.
        OSError: Files cannot be locked there.
    """
    try:
        fcntl: Any = import_module("fcntl")
    except ImportError:
        _lock_byte(file)
        return
    fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)


def _lock_byte(file: IO[Any]) -> None:
    """The same on Windows, where a lock is on bytes, whether the file has them or not."""
    msvcrt: Any = import_module("msvcrt")
    file.seek(0)
    try:
        msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
    except PermissionError as error:
        raise BlockingIOError(error.errno, error.strerror) from error


#: Held while this process starts another.
_starting = threading.RLock()


@contextmanager
def starting_process() -> Iterator[None]:
    """Start processes in the block: whole, or not at all, and deaf to Ctrl-C.

    A process that is started reads what it is to do from this one, and complains at length of one
    that leaves halfway: so Ctrl-C is answered after the block, and `leave` waits for its end.
    What this thread blocks they inherit. Where they do not (Windows), a process that must not
    answer Ctrl-C calls `ignore_interrupt` as it begins.
    """
    with _starting, _interrupt_deferred():
        mask = getattr(signal, "pthread_sigmask", None)
        if mask is None:
            yield
            return
        before = mask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            mask(signal.SIG_SETMASK, before)


@contextmanager
def _interrupt_deferred() -> Iterator[None]:
    """Python answers Ctrl-C after the block.

    Blocking it is not enough: another thread may receive it, and the main one answers.
    """
    answer = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(answer):
        yield
        return
    received: list[tuple[int, FrameType | None]] = []
    signal.signal(signal.SIGINT, lambda number, frame: received.append((number, frame)))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, answer)
        if received:
            answer(*received[0])


def leave(code: int) -> NoReturn:
    """End this process at once, from any of its threads."""
    _starting.acquire(timeout=_START)
    os._exit(code)


def check_may_start_processes() -> None:
    """End this process with a line if it is a worker that runs a script from its top again.

    A script that starts workers is imported by each of them; without a guard it would begin to
    start workers there too, which Python refuses at length.
    """
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        raise SystemExit(
            "dressing-sim: a script that evaluates starts processes, which import it again: put "
            "what it does under if __name__ == '__main__':"
        )


def ignore_interrupt() -> None:
    """In a worker's main thread: leave Ctrl-C, which a terminal sends to all, to the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def processors() -> int:
    """Processors that this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity is not None else os.cpu_count() or 1


def limit_own_resources(memory: int, file: int) -> None:
    """Let this process, where the platform can, allocate and write no more than so much [bytes].

    Beyond, an allocation raises MemoryError, and writing to a file raises OSError.
    """
    try:
        resource: Any = import_module("resource")
    except ImportError:
        return
    for limit, most in ((resource.RLIMIT_DATA, memory), (resource.RLIMIT_FSIZE, file)):
        _, hard = resource.getrlimit(limit)
        allowed = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(limit, (allowed, hard))
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)


def lead_own_group() -> None:
    """Make this process the leader of a group, with which `end_group` ends what it starts too."""
    setsid = getattr(os, "setsid", None)
    if setsid is not None:
        setsid()


def end_group(pid: int) -> None:
    """End a process that called `lead_own_group`, and those that it started."""
    kill = getattr(os, "killpg", None)
    try:
        if kill is not None and os.getpgid(pid) == pid:
            kill(pid, signal.SIGKILL)
    except ProcessLookupError:  # it is gone already
        return


@contextmanager
def silent_libraries() -> Iterator[None]:
    """What compiled libraries print to standard error meanwhile is not seen; nor is anybody else's.

    For a moment in which nothing else is going on.
    """
    try:
        kept = os.dup(_STANDARD_ERROR)
    except OSError:  # it is closed: nothing is seen anyway
        yield
        return
    try:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, _STANDARD_ERROR)
        os.close(nowhere)
        yield
    finally:
        os.dup2(kept, _STANDARD_ERROR)
        os.close(kept)
