"""What an episode costs next to its bare physics steps.

    OMP_NUM_THREADS=1 python benchmarks/episode_overhead.py [--suite val50] [--arms 4] [--rounds 5]

The operator dresses arms whose worlds are made already. Once, what every call of MuJoCo's step was
given is kept; then episodes and the same steps without anything between them take turns, so that
a busy machine slows both. Per arm the ratio of the two medians of processor time is printed. The
last state of the bare steps is compared with the episode's: they did the same work.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from copy import copy
from dataclasses import dataclass, field
from statistics import mean, median
from time import thread_time
from unittest.mock import patch

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim import Operator, Posture, load_suite, record


@dataclass
class Steps:
    """The calls of MuJoCo's step in one episode."""

    model: mujoco.MjModel | None = None
    start: mujoco.MjData | None = None
    end: mujoco.MjData | None = None
    controls: list[NDArray[np.float64]] = field(default_factory=list)
    held: list[NDArray[np.uint8]] = field(default_factory=list)

    def keep(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Take a step, and keep what it was given."""
        if self.start is None:
            self.model, self.start, self.end = copy(model), copy(data), data
        self.controls.append(data.ctrl.copy())
        self.held.append(data.eq_active.copy())
        _step(model, data)

    def repeat(self, data: mujoco.MjData) -> None:
        """Take all steps again, from a copy of `start`."""
        control, active = data.ctrl, data.eq_active
        for controls, held in zip(self.controls, self.held, strict=True):
            control[:], active[:] = controls, held
            _step(self.model, data)


_step = mujoco.mj_step


def seconds(function: Callable[..., object], *arguments: object) -> float:
    """Processor time of a call [s]."""
    started = thread_time()
    function(*arguments)
    return thread_time() - started


def measure(arm: Posture, rounds: int) -> float:
    """Print what an episode and its bare steps cost, and return the ratio."""
    record(Operator(), arm)  # makes the world, and compiles
    steps = Steps()
    with patch("mujoco.mj_step", steps.keep):
        record(Operator(), arm)
    whole, bare = [], []
    for _ in range(rounds):
        whole.append(seconds(record, Operator(), arm))
        data = copy(steps.start)
        bare.append(seconds(steps.repeat, data))
        assert steps.end is not None
        np.testing.assert_array_equal(data.qpos, steps.end.qpos)
    ratio, n_steps = median(whole) / median(bare), len(steps.controls)
    print(
        f"{arm.name:12} {n_steps} steps: episode {median(whole):.3f} s, bare {median(bare):.3f} s, "
        f"ratio {ratio:.3f}, {1e6 * (median(whole) - median(bare)) / n_steps:.0f} us a step beside",
        flush=True,
    )
    return ratio


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--suite", default="val50")
    parser.add_argument("--arms", type=int, default=4)
    parser.add_argument("--rounds", type=int, default=5)
    args = parser.parse_args()
    ratios = [measure(arm, args.rounds) for arm in load_suite(args.suite)[: args.arms]]
    print(f"an episode costs {mean(ratios):.3f} times its bare steps")


if __name__ == "__main__":
    main()
