"""Policies that go wrong, each in its own way; other processes import them by name."""

import os
import subprocess
import sys
import time

import numpy as np


class _Straight:
    """A straight path from the gripper to the shoulder, which is a fair answer."""

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        return np.linspace(start, frames.shoulder.b + [0.0, 0.0, 0.1], 40)


class Fine(_Straight):
    """It does what it should."""


class Talks(_Straight):
    """A megabyte on both streams, by Python and by the system."""

    def generate(self, frames, start):
        print("x" * 500_000)
        print("y" * 500_000, file=sys.stderr)
        os.write(1, b"from below\n")
        return super().generate(frames, start)


class Raises(_Straight):
    def generate(self, frames, start):
        raise ValueError("no idea\nwhat to do")


class RaisesInFit(_Straight):
    def fit(self, demonstrations):
        raise RuntimeError("cannot learn this")


class Hangs(_Straight):
    def generate(self, frames, start):
        while True:
            time.sleep(0.1)


class HangsInFit(_Straight):
    def fit(self, demonstrations):
        while True:
            pass


class Nan(_Straight):
    def generate(self, frames, start):
        return np.full((10, 3), np.nan)


class Shape(_Straight):
    def generate(self, frames, start):
        return np.zeros((10, 2))


class Text(_Straight):
    def generate(self, frames, start):
        return "straight ahead"


class Nothing(_Straight):
    def generate(self, frames, start):
        return None


class Endless(_Straight):
    def generate(self, frames, start):
        def points():
            while True:
                yield start

        return points()


class EndlessArray(_Straight):
    class Lazy:
        def __array__(self, *_, **__):
            while True:
                time.sleep(0.1)

    def generate(self, frames, start):
        return self.Lazy()


class Exits(_Straight):
    def generate(self, frames, start):
        raise SystemExit(3)


class ExitsAtOnce(_Straight):
    def generate(self, frames, start):
        os._exit(7)


class ExitsInFit(_Straight):
    def fit(self, demonstrations):
        os._exit(0)


class Aborts(_Straight):
    def generate(self, frames, start):
        os.abort()


class Recurses(_Straight):
    def generate(self, frames, start):
        return self.generate(frames, start)


class Eats(_Straight):
    def generate(self, frames, start):
        held = []
        while True:
            held.append(np.ones(20_000_000))


class Closes(_Straight):
    """All files, also the way back to who asked."""

    def generate(self, frames, start):
        os.closerange(3, 200)
        return super().generate(frames, start)


class LeavesChildren(_Straight):
    """A process that outlives it."""

    def generate(self, frames, start):
        subprocess.Popen([sys.executable, "-c", "import time; time.sleep(600)  # left behind"])
        while True:
            time.sleep(0.1)


class Kept(_Straight):
    """It cannot be handed to another process."""

    def fit(self, demonstrations):
        self.what = lambda: None
        return self


class ReturnsNothingFromFit(_Straight):
    def fit(self, demonstrations):
        return None


class Timeless(_Straight):
    dt = "soon"


class ActsWrong:
    """In closed loop, and then no longer."""

    def fit(self, demonstrations):
        return self

    def reset(self):
        self.n = 0

    def act(self, observation):
        self.n += 1
        if self.n > 3:
            raise KeyError("the fourth")
        return observation.target


class MakesNoInstance(_Straight):
    def __init__(self):
        raise OSError("no such file: weights.bin")
