"""State that others watch: a page that draws it, or a test that waits for it."""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

from dressing_sim.errors import DressingSimError, one_line

_LOG = logging.getLogger("dressing_sim")

#: Longest error that is told.
_LONGEST = 400


class Watched:
    """Attributes that change, and a count of the changes.

    Attributes:
        status: What is being done, or nothing.
        error: What went wrong last, or nothing.
    """

    def __init__(self) -> None:
        self.status = self.error = ""
        self._news = threading.Condition()
        self._version = 0

    def tell(self, **changes: object) -> None:
        """Change attributes, and wake whoever waits."""
        with self._news:
            for name, value in changes.items():
                setattr(self, name, value)
            self._version += 1
            self._news.notify_all()

    @property
    def version(self) -> int:
        """How often something has changed."""
        return self._version

    def news(self, seen: int, timeout: float | None = None) -> int:
        """Wait until there is something newer than a version; returns what it is now."""
        with self._news:
            self._news.wait_for(lambda: self._version != seen, timeout)
            return self._version

    def wait(self, condition: Callable[[], bool], timeout: float) -> bool:
        """Wait until something is so; whether it is."""
        with self._news:
            return self._news.wait_for(condition, timeout)

    def telling(self, busy: bool = False) -> AbstractContextManager[None]:
        """Within the block an error is told on the page instead of ending the thread.

        Args:
            busy: Whether the block sets the status, which is then empty after it.
        """
        return _Telling(self, busy)

    def _told(self, status: str) -> None:
        self.tell(status=status)


class _Telling(AbstractContextManager[None]):
    """See `Watched.telling`."""

    def __init__(self, watched: Watched, busy: bool) -> None:
        self._watched, self._busy = watched, busy

    def __exit__(self, kind: object, value: BaseException | None, traceback: object) -> bool:
        if value is None:
            if self._busy:
                self._watched.tell(status="")
            return False
        if not isinstance(value, Exception):
            return False
        if not isinstance(value, DressingSimError):
            _LOG.error("the page: %r", value, exc_info=value)
        self._watched.tell(status="", error=one_line(str(value) or repr(value), _LONGEST))
        return True
