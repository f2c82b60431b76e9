"""Loops compiled by numba, kept in a cache that never stands in the way.

Numba's own cache takes whatever it finds in its files, which may end in machine code that was cut
off, and refuses to compile at all where no folder can be written to. Here every file has a
checksum; what is damaged, or cannot be read or written, costs compiling anew and one warning.
"""

from __future__ import annotations

import hashlib
import logging
import threading
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, TypeVar

from numba import njit
from numba.core.caching import FunctionCache, IndexDataCacheFile

F = TypeVar("F", bound=Callable[..., Any])

_LOG = logging.getLogger("dressing_sim")

_SHA = hashlib.sha256().digest_size


def compiled(function: F) -> F:
    """A function compiled by numba at its first call, or by an earlier process."""
    # Without the interpreter's lock: else nothing could answer Ctrl-C.
    dispatcher: Any = njit(error_model="numpy", nogil=True)(function)
    try:
        dispatcher._cache = _Cache(function)
    except (RuntimeError, OSError) as error:
        _warn(f"{error}; set NUMBA_CACHE_DIR to a folder of yours")
    compiled_function: F = dispatcher
    return compiled_function


class _Cache(FunctionCache):
    """Numba's cache, in which a fault is a miss; `free` of the lock, which earlier ones held."""

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        name = f"{self._impl.filename_base}.free"
        # Numba looks at the function's own file, but loops call those of other files.
        folder = Path(function.__code__.co_filename).parent
        self._cache_file = _CheckedFile(self._cache_path, name, _source(folder))

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled function for a signature, or None."""
        try:
            found = super().load_overload(sig, target_context)
        except Exception as error:  # whatever numba, pickle or LLVM make of a damaged file
            _warn(f"{self.cache_path}: cannot be used ({type(error).__name__}: {error})")
            found = None
        if found is None:
            _say_that_it_compiles()
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep a compiled function."""
        try:
            super().save_overload(sig, data)
        except Exception as error:  # a full disk, for instance, or an index that is damaged
            _warn(f"{self.cache_path}: cannot be written ({error})")


class _CheckedFile(IndexDataCacheFile):
    """Numba's index and data files, with a checksum of each."""

    def _dump(self, obj: Any) -> bytes:
        content: bytes = super()._dump(obj)
        return hashlib.sha256(content).digest() + content

    def _load_index(self) -> dict[Any, str]:
        try:
            with open(self._index_path, "rb") as file:
                content = self._checked(file.read())
        except OSError:
            return {}
        return {} if content is None else self._of_index(content)

    def _of_index(self, content: bytes) -> dict[Any, str]:
        version, stamp, overloads = _loads(content)
        fresh = version == self._version and stamp == self._source_stamp
        return overloads if fresh else {}

    def _save_index(self, overloads: dict[Any, str]) -> None:
        with self._open_for_write(self._index_path) as file:
            file.write(self._dump((self._version, self._source_stamp, overloads)))

    def _load_data(self, name: str) -> Any:
        with open(self._data_path(name), "rb") as file:
            content = self._checked(file.read())
        return None if content is None else _loads(content)

    def _checked(self, content: bytes) -> bytes | None:
        """What is after the checksum; None if it is not that of it."""
        good = hashlib.sha256(content[_SHA:]).digest() == content[:_SHA]
        if not good:
            _warn(f"{self._cache_path}: a file of theirs is damaged", "are made anew")
        return content[_SHA:] if good else None


@cache
def _source(folder: Path) -> str:
    """A hash of all loops in a folder."""
    digest = hashlib.sha256()
    for path in sorted(folder.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _loads(content: bytes) -> Any:
    # What numba writes, and nobody else could have: the checksum has been compared.
    from numba.core.serialize import pickle

    return pickle.loads(content)


def _warn(message: str, so: str = "are not kept") -> None:
    """Tell of the first fault in a process; the others are the same for other functions."""
    if not _told.is_set():
        _told.set()
        _LOG.warning("compiled loops %s, which costs some seconds: %s", so, message)


_told = threading.Event()

#: Compiling that takes longer says so [s].
PATIENCE = 1.0


@cache
def _say_that_it_compiles() -> None:
    """What is going on, should it take longer than `PATIENCE`."""
    told = "compiling loops, once; this can take half a minute"
    timer = threading.Timer(PATIENCE, _LOG.warning, (told,))
    timer.daemon = True
    timer.start()
