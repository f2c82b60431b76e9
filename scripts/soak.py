"""Does the simulation hold for long, and in worlds that nobody chose it for?

    python scripts/soak.py [--episodes 1000] [--seed 0]
    python scripts/soak.py --worlds 20 [--seed 0]

The first dresses one arm after another in one process, and prints how memory and the time of an
episode go. The second draws worlds at and beyond the ends of what is measured: arms, garments,
fabrics, frictions, speeds. An operator dresses in each, and the same commands are played again in
the reference of ``dressing-sim validate``. A verdict from a broken simulation would be one that a
finer simulation, sure of itself, does not share, or a sleeve that is round the forearm and then is
not: it can have left the arm only through it.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter

import numpy as np
import psutil

from dressing_sim import Operator, load_suite, record
from dressing_sim.arm import ARM_SIZES, Posture
from dressing_sim.benchmark.studies.agreement import decided, reference
from dressing_sim.control import RobotKinematics
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.operator import OperatorConfig
from dressing_sim.episode.rollout import play
from dressing_sim.episode.trace import Trace
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.distribution import PostureDistribution, sample_posture
from dressing_sim.world.garment import Fabric, Garment
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.sleeve import SleeveConfig

#: Arms of every size, straight to bent at a right angle.
ARMS = PostureDistribution(elbow_deg=(0.0, 90.0), sizes=tuple(ARM_SIZES))

#: A sleeve is round the forearm if its hem is past this arm coordinate.
ON_THE_FOREARM = 0.1


def soak(episodes: int, seed: int) -> None:
    """Dress the arms of a suite in turn in this process; memory and time, a line each tenth."""
    arms = load_suite("test200")
    times: list[float] = []
    for number in range(episodes):
        begun = time.process_time()
        recording = record(Operator(), arms[number % len(arms)], seed + number // len(arms))
        assert recording.trajectory is not None
        times.append((time.process_time() - begun) / len(recording.trajectory))
        if (number + 1) % max(episodes // 10, 1) == 0:
            recent = np.median(times[-max(episodes // 10, 1) :])
            memory = psutil.Process().memory_info().rss / 2**20
            print(f"{number + 1} episodes: {memory:.0f} MiB, {1e3 * recent:.2f} ms a control step")


def worlds(count: int, seed: int) -> None:
    """Draw extreme worlds, and count what becomes of their verdicts."""
    found: Counter[str] = Counter()
    for number in range(count):
        posture, config, operator = extreme(np.random.default_rng([seed, number]))
        recording = record(operator, posture, number, config)
        outcome = recording.outcome
        what = "no verdict"
        if outcome.invalid is None and recording.trajectory is not None:
            finer = reference(config), reference(config, edge=1.0), reference(config, step=1.0)
            again = [play(Dressing(posture, world), recording.trajectory) for world in finer]
            what = "same verdict" if again[0].outcome.success == outcome.success else "ANOTHER"
            if any(one.outcome.invalid for one in again):
                what = "no verdict in the reference"
            elif not decided(*again, config.thresholds):
                what = "undecided"
            if recording.trace is not None and through_the_arm(recording.trace):
                what = "THROUGH THE ARM"
        found[what] += 1
        verdict = outcome.invalid or ("dressed" if outcome.success else ", ".join(outcome.reasons))
        garment = config.world.sleeve.garment
        print(
            f"{number}: {what}; {verdict}; {posture.size}, elbow {posture.elbow_deg:.0f} deg, "
            f"sleeve {garment.length:.2f} m, friction {garment.fabric.friction:.2f}, "
            f"{garment.fabric.membrane_stiffness:.0f} N/m, "
            f"{1e3 * garment.fabric.areal_density:.0f} g/m^2",
            flush=True,
        )
    print(", ".join(f"{what} {n}" for what, n in found.most_common()))


def extreme(rng: np.random.Generator) -> tuple[Posture, EpisodeConfig, Operator]:
    """A posture, a world and an operator; what no configuration accepts is drawn again."""
    posture = sample_posture(f"extreme{rng.integers(2**31)}", rng, ARMS, RobotKinematics())
    speed = float(np.exp(rng.uniform(*np.log([0.03, 0.5]))))
    while True:
        fabric = np.exp(rng.uniform(*np.log([[0.05, 15, 1e-3], [0.5, 1500, 0.1]]))).tolist()
        armscye = rng.uniform(0.40, 0.70)
        try:
            cloth = Fabric(*fabric[:2], friction=rng.uniform(0.0, 1.5), damping=fabric[2])
            hem = rng.uniform(0.24, armscye)
            garment = Garment(rng.uniform(0.12, 0.55), armscye, hem, fabric=cloth)
            world = WorldConfig(sleeve=SleeveConfig(garment))
        except InvalidInputError:
            continue
        return posture, EpisodeConfig(world=world), Operator(OperatorConfig(speed=speed))


def through_the_arm(trace: Trace) -> bool:
    """Whether a sleeve that wound round the forearm did not in the next row."""
    before, after = trace.wound[:-1], trace.wound[1:]
    return bool(np.any(before & ~after & (trace.hem_s[1:] > ON_THE_FOREARM)))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--episodes", type=int, default=1000)
    parser.add_argument("--worlds", type=int)
    parser.add_argument("--seed", type=int, default=0)
    given = parser.parse_args()
    if given.worlds is None:
        soak(given.episodes, given.seed)
    else:
        worlds(given.worlds, given.seed)
