"""What an environment adds to a control step of the core, and control steps a second.

    OMP_NUM_THREADS=1 python benchmarks/environment_speed.py [--posture bent25] [--episodes 3]

The operator dresses an arm through Gymnasium and through dm_env. In one run the processor time of
every step is taken twice: of the environment's step as a whole, and of the core's within it. The
rest is what the environment adds: rewards, observations, books. The last step, in which an episode
is judged, and resetting are not included.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from time import thread_time

import gymnasium
import numpy as np
from numpy.typing import NDArray

from dressing_sim.envs import GYMNASIUM_ID, dm
from dressing_sim.envs.task import Task
from dressing_sim.episode.operator import Operator

#: All that can be observed without drawing a picture.
EVERYTHING = ("arm_coordinate", "link_force", "cloth")


class Stopwatch:
    """Adds up the processor time of calls [s]."""

    def __init__(self) -> None:
        self.taken = 0.0

    def timed(self, function: Callable[..., object]) -> Callable[..., object]:
        """The same function, timed."""

        def run(*arguments: object) -> object:
            started = thread_time()
            made = function(*arguments)
            self.taken += thread_time() - started
            return made

        return run


def measure(
    name: str, reset: Callable[[], object], step: Callable[..., object], task: Task, episodes: int
) -> None:
    """Dress so many times and print a line."""
    whole, core, n_steps = Stopwatch(), Stopwatch(), 0
    timed = whole.timed(step)
    for episode in range(episodes):
        reset()
        actions: NDArray[np.float64] = task.actions(Operator())[:-1]
        if episode == 0:
            for method in ("step", "hold"):
                setattr(task.dressing, method, core.timed(getattr(task.dressing, method)))
        for action in actions:
            timed(action)
        n_steps += len(actions)
    added = whole.taken - core.taken
    print(
        f"{name:22} {n_steps / whole.taken:6.1f} steps/s; a step of the core takes "
        f"{1e3 * core.taken / n_steps:.2f} ms, the environment adds {1e3 * added / n_steps:.3f} ms "
        f"({100.0 * added / core.taken:.1f} %)"
    )


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--posture", default="bent25")
    parser.add_argument("--episodes", type=int, default=3)
    args = parser.parse_args()
    for name, observe in (("gymnasium", ()), ("gymnasium, sees more", EVERYTHING)):
        env = gymnasium.make(GYMNASIUM_ID, posture=args.posture, control="target", observe=observe)
        measure(name, env.reset, env.step, env.unwrapped.task, args.episodes)
    environment = dm.load(args.posture, control="target")
    task = environment.physics.task
    measure("dm_env", environment.reset, environment.step, task, args.episodes)


if __name__ == "__main__":
    main()
