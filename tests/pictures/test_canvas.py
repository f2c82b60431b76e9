"""Rendering that neither hangs nor lies, provoked for real."""

import os
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.pictures import canvas
from dressing_sim.pictures.canvas import FORKED, Canvas
from dressing_sim.pictures.rendering import OffscreenRenderer
from dressing_sim.world.scene import WorldConfig

SIZE = {"width": 64, "height": 48}


@pytest.fixture
def renderer(opengl, posture):
    with OffscreenRenderer(posture, WorldConfig(), **SIZE) as renderer:
        yield renderer


def test_another_thread_draws_the_same_picture(renderer, world):
    here = renderer.draw(world.data.qpos)
    with ThreadPoolExecutor(1) as other:
        there = other.submit(renderer.draw, world.data.qpos).result()
    assert np.ptp(here) > 100
    np.testing.assert_array_equal(there, here)


def test_many_threads_and_renderers_at_once_draw_what_one_does(opengl, posture, world):
    elsewhere = world.data.qpos.copy()
    elsewhere[:7] = 0.3
    states = [world.data.qpos.copy(), elsewhere]
    with (
        OffscreenRenderer(posture, WorldConfig(), **SIZE) as first,
        OffscreenRenderer(posture, WorldConfig(), **SIZE) as second,
        ThreadPoolExecutor(4) as threads,
    ):
        alone = [first.draw(state) for state in states]
        jobs = [(drawer, n % 2) for n in range(8) for drawer in (first, second)]
        drawn = threads.map(lambda job: job[0].draw(states[job[1]]), jobs)
        for picture, (_, state) in zip(drawn, jobs, strict=True):
            np.testing.assert_array_equal(picture, alone[state])
    assert not np.array_equal(*alone)


def test_a_closed_renderer_says_so(opengl, posture, world):
    renderer = OffscreenRenderer(posture, WorldConfig(), **SIZE)
    renderer.close()
    renderer.close()
    with pytest.raises(InvalidInputError, match="the renderer is closed; valid is a new one"):
        renderer.draw(world.data.qpos)


def test_what_is_drawn_wrongly_is_an_error_and_the_next_picture_right(renderer, world):
    before = renderer.draw(world.data.qpos)
    with pytest.raises(ValueError, match="shape"):
        renderer.draw(np.zeros(3))
    np.testing.assert_array_equal(renderer.draw(world.data.qpos), before)


def _held():
    """Threads of this process, its open files, and its memory [MiB]."""
    threads = len(os.listdir("/proc/self/task"))
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return threads, len(os.listdir("/proc/self/fd")), pages * os.sysconf("SC_PAGE_SIZE") / 2**20


@pytest.mark.skipif(not os.path.isdir("/proc/self/task"), reason="looks at /proc")
def test_twenty_renderers_in_a_row_leak_nothing(opengl):
    def use(close):
        made = Canvas(opengl, 64, 48)
        assert made.run(threading.get_ident) != threading.get_ident()
        if close:
            made.close()

    for close in (True, False):
        use(close)
        before = _held()
        for _ in range(20):
            use(close)
        threads, files, memory = np.subtract(_held(), before)
        assert threads <= 1  # the last one's may be ending
        assert files <= 0
        assert memory < 20.0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_forked_worker_says_what_to_do_instead_of_hanging(opengl):
    """In a process of its own, which forks after its first picture and before."""
    code = """
import multiprocessing, os, sys
from dressing_sim.pictures.canvas import Canvas
from dressing_sim.errors import DressingSimError

def work(old):
    try:
        made = old or Canvas(BACKEND, 32, 32)
        return str(made.run(int))
    except DressingSimError as error:
        return str(error)

fork = multiprocessing.get_context("fork")
early = fork.Pool(1)
first = Canvas(BACKEND, 32, 32)
print(early.apply(work, (None,)))
early.terminate()
with fork.Pool(1) as late:
    print(late.apply(work, (None,)))
pid = os.fork()
if pid == 0:
    print(work(first))
    sys.exit(3)
print(os.waitstatus_to_exitcode(os.waitpid(pid, 0)[1]))
print(first.run(int))
""".replace("BACKEND", repr(opengl))
    told = subprocess.run(
        [sys.executable, "-u", "-c", code], capture_output=True, text=True, timeout=120, check=True
    )
    assert told.stdout.splitlines() == ["0", FORKED, FORKED, "3", "0"]
    assert "\n" not in FORKED


def test_windows_stay_in_their_thread(monkeypatch):
    class Context:
        made = 0

        def __init__(self, width, height):
            self.current = 0

        def make_current(self):
            self.current += 1

        def free(self):
            self.current = -1

    monkeypatch.setattr(canvas, "import_module", lambda name: type("m", (), {"GLContext": Context}))
    window = Canvas("glfw", 32, 32)
    assert window.run(threading.get_ident) == threading.get_ident()
    with ThreadPoolExecutor(1) as other, pytest.raises(DressingSimError, match="another thread"):
        other.submit(window.run, int).result()
    window.close()
