"""An OpenGL context that any thread may draw with, and no forked process."""

from __future__ import annotations

import os
import sys
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from typing import ParamSpec, Protocol, TypeVar, runtime_checkable

from dressing_sim.errors import DressingSimError, InvalidInputError

_Given = ParamSpec("_Given")
_Got = TypeVar("_Got")

#: Modules that are there once this process has opened a display to draw with.
_DISPLAYS = ("mujoco.egl", "mujoco.osmesa", "OpenGL.EGL", "OpenGL.osmesa")

#: Windows belong to the thread that made them, on some systems to the main one.
_OF_THE_CALLER = ("glfw",)

FORKED = (
    "no pictures can be drawn in a process that was forked from one that has drawn before, because "
    "OpenGL does not survive the fork; start workers with the method 'spawn' or 'forkserver', or "
    "before the first picture"
)


class Resource(Protocol):
    """Something of OpenGL's that is given back."""

    def free(self) -> None:
        """Give it back; in the thread whose context it belongs to."""


@runtime_checkable
class Context(Resource, Protocol):
    """What the backends of MuJoCo have as ``GLContext``."""

    def make_current(self) -> None:
        """Draw with this one from now on, in this thread."""


class Canvas:
    """An OpenGL context, current in a thread of its own in which all drawing is done.

    A context is current in one thread, and drawing without one is silently garbage. So callers of
    any thread hand their work over and wait. What is not closed is given back when it is forgotten.

    Args:
        backend: One of `dressing_sim.pictures.rendering.BACKENDS`.
        width: Of what is drawn [pixels].
        height: Of what is drawn [pixels].

    Raises:
        DressingSimError: This process was forked from one that had drawn.
    """

    def __init__(self, backend: str, width: int, height: int) -> None:
        if _forked.is_set():
            raise DressingSimError(FORKED)
        self._thread: ThreadPoolExecutor | None = None
        self._home = threading.get_ident()
        self._closed = False
        self._resources: list[Resource] = []
        if backend not in _OF_THE_CALLER:
            self._thread = ThreadPoolExecutor(1, thread_name_prefix="pictures")
        self._forget = weakref.finalize(self, _give_back, self._thread, self._resources)
        self._forget.atexit = False  # the process's end gives everything back
        try:
            if self._thread is None:
                _open(backend, width, height, self._resources)
            else:
                self.run(_open, backend, width, height, self._resources)
        except BaseException:
            self.close()
            raise
        _live.add(self)

    def run(
        self, work: Callable[_Given, _Got], *args: _Given.args, **options: _Given.kwargs
    ) -> _Got:
        """Do something with the context, and wait for its result.

        Raises:
            InvalidInputError: It is closed, or cannot be used from this thread.
            DressingSimError: This process was forked from one that had drawn.
        """
        if _forked.is_set():
            raise DressingSimError(FORKED)
        if self._closed:
            raise InvalidInputError("the renderer is closed; valid is a new one")
        if self._thread is not None:
            return self._thread.submit(work, *args, **options).result()
        if threading.get_ident() != self._home:
            raise InvalidInputError(
                "the renderer was made in another thread; valid with this OpenGL is to draw in "
                "that one, or to make a renderer in each thread"
            )
        context = self._resources[0]
        assert isinstance(context, Context)
        context.make_current()
        return work(*args, **options)

    def keep(self, resource: Resource) -> None:
        """Give this back, too, when the canvas is closed; in its thread."""
        self._resources.append(resource)

    def close(self) -> None:
        """Give everything back; closing twice is closing once."""
        if self._closed:
            return
        self._closed = True
        if self._forget.detach() is not None and not _forked.is_set():
            _give_back(self._thread, self._resources, wait=True)

    def abandon(self) -> None:
        """Forget the context without a call to OpenGL, in a process where that would hang."""
        self._forget.detach()
        self._closed = True
        for resource in self._resources:
            # What `free` and `__del__` of MuJoCo's contexts look at; no call says "not mine".
            if hasattr(resource, "_context"):
                resource._context = None


def _open(backend: str, width: int, height: int, resources: list[Resource]) -> None:
    context = import_module(f"mujoco.{backend}").GLContext(width, height)
    resources.append(context)
    context.make_current()


def _give_back(
    thread: ThreadPoolExecutor | None, resources: list[Resource], wait: bool = False
) -> None:
    """Free the last first; in their thread, which ends."""
    if thread is None:
        _free(resources)
        return
    done = thread.submit(_free, resources)
    thread.shutdown(wait=False)
    if wait:
        done.result()


def _free(resources: list[Resource]) -> None:
    while resources:
        resources.pop().free()


def _after_fork() -> None:
    """In the child: its parent's threads are gone, and with them whatever they held."""
    if any(name in sys.modules for name in _DISPLAYS):
        _forked.set()
    for canvas in list(_live):
        canvas.abandon()


_forked = threading.Event()
_live: weakref.WeakSet[Canvas] = weakref.WeakSet()

if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_after_fork)
