"""Ctrl-C on the command line: answered at once, whatever the process is doing.

Python answers between two of its own instructions. A loop in compiled code has none, and code that
is being imported may turn the answer into an error of its own. The system may hand the signal to
any thread, while Python answers in the main one, which may be waiting; and what is raised within a
callback of C, or where C clears errors, is dropped there. So a thread watches as well: it wakes the
main one, again if the answer was dropped; and if the command has not begun to leave soon after
Ctrl-C, or is not gone some time later, it ends the process.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
import time
import weakref
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from types import FrameType
from typing import Final, TypeAlias

#: What shells say of a process that Ctrl-C ended.
EXIT_CODE: Final = 130

#: So long a command has until it is woken, to begin to leave then, and to leave [s].
_NAP, _GRACE, _MOST = 0.1, 0.5, 15.0

Hook: TypeAlias = "Callable[[sys.UnraisableHookArgs], object]"


class Interrupted(KeyboardInterrupt):
    """The answer to Ctrl-C; unlike its base it can be referred to weakly."""


class Interrupts:
    """What became of Ctrl-C.

    Attributes:
        heard: Set once Python has answered.
        over: Set once the command has ended.
    """

    def __init__(self) -> None:
        self.heard = threading.Event()
        self.over = threading.Event()
        self._raised: weakref.ref[Interrupted] | None = None

    def answer(self, number: int, frame: FrameType | None) -> None:
        """Raise KeyboardInterrupt, the first time; what leaves need not be told twice."""
        if not self.heard.is_set():
            raise self._answer()  # no name: its traceback has this frame, and would keep it

    def _answer(self) -> Interrupted:
        answer = Interrupted()
        self._raised = weakref.ref(answer)
        self.heard.set()
        return answer

    def unraisable(self, usual: Hook, dropped: sys.UnraisableHookArgs) -> None:
        """Say nothing of an answer that was dropped, as it is given again; of others as usual."""
        if not issubclass(dropped.exc_type, Interrupted) or self.over.is_set():
            usual(dropped)

    def watch(self, receiver: socket.socket) -> None:
        """End the process if Ctrl-C is not answered in time; for a thread."""
        while signal.SIGINT not in (received := receiver.recv(64)):
            if not received:
                return
        end = time.monotonic() + _MOST
        while self._answered() and time.monotonic() < end:
            if self.over.wait(_NAP):
                return
            # While it is on its way out, or what was made of it is, it is referred to.
            if self._raised is not None and self._raised() is None:
                self.heard.clear()
        if not self.over.is_set():
            os.write(2, b"dressing-sim: interrupted\n")
            os._exit(EXIT_CODE)

    def _answered(self) -> bool:
        """Whether the main thread answers soon, by itself or because it is woken."""
        if not self.heard.wait(_NAP) and not self.over.is_set():
            wake_main_thread()
        return self.heard.wait(_GRACE)


@contextmanager
def answered_at_once() -> Iterator[Interrupts]:
    """Within the block Ctrl-C is answered at once; nothing changes where it is ignored already."""
    interrupts = Interrupts()
    usual = signal.getsignal(signal.SIGINT) is signal.default_int_handler
    if not usual or threading.current_thread() is not threading.main_thread():
        yield interrupts
        return
    receiver, sender = socket.socketpair()
    sender.setblocking(False)
    earlier = signal.set_wakeup_fd(sender.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGINT, interrupts.answer)
    told = sys.unraisablehook
    sys.unraisablehook = partial(interrupts.unraisable, told)
    threading.Thread(target=interrupts.watch, args=(receiver,), daemon=True).start()
    try:
        yield interrupts
    finally:
        # Only now is an exception on its way out, or none: the thread has nothing more to do.
        interrupts.over.set()
        sys.unraisablehook = told
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.set_wakeup_fd(earlier)
        sender.close()


def wake_main_thread() -> None:
    """Interrupt what the main thread waits for, by Ctrl-C to it alone, where the system can."""
    main = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main is not None:
        signal.pthread_kill(main, signal.SIGINT)


def say_interrupted() -> None:
    """Tell of Ctrl-C in a line."""
    print("dressing-sim: interrupted", file=sys.stderr)
