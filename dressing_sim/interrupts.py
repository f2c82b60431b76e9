"""Ctrl-C on the command line: answered at once, whatever the process is doing.

Python answers between two of its own instructions. A loop in compiled code has none, and code that
is being imported may turn the answer into an error of its own. So a thread watches as well: if the
command has not begun to leave soon after Ctrl-C, or is not gone some time later, it ends the
process.
"""

from __future__ import annotations

import os
import signal
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Final

#: What shells say of a process that Ctrl-C ended.
EXIT_CODE: Final = 130

#: So long a command has to begin to leave, and then to leave [s].
_GRACE, _MOST = 0.6, 15.0


class Interrupts:
    """What became of Ctrl-C.

    Attributes:
        heard: Set once Python has answered.
        over: Set once the command has ended.
    """

    def __init__(self) -> None:
        self.heard = threading.Event()
        self.over = threading.Event()

    def answer(self, number: int, frame: FrameType | None) -> None:
        """Raise KeyboardInterrupt, the first time; what leaves need not be told twice."""
        if not self.heard.is_set():
            self.heard.set()
            raise KeyboardInterrupt

    def watch(self, receiver: socket.socket) -> None:
        """End the process if Ctrl-C is not answered in time; for a thread."""
        while signal.SIGINT not in (received := receiver.recv(64)):
            if not received:
                return
        if not self.heard.wait(_GRACE) or not self.over.wait(_MOST):
            os.write(2, b"dressing-sim: interrupted\n")
            os._exit(EXIT_CODE)


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
    threading.Thread(target=interrupts.watch, args=(receiver,), daemon=True).start()
    try:
        yield interrupts
    finally:
        # Only now is an exception on its way out, or none: the thread has nothing more to do.
        interrupts.over.set()
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.set_wakeup_fd(earlier)
        sender.close()


def say_interrupted() -> None:
    """Tell of Ctrl-C in a line."""
    print("dressing-sim: interrupted", file=sys.stderr)
