"""What the settings of the trajectory policy are worth: a kinematic study without a simulator.

    python benchmarks/trajectory_settings.py [--seeds 12] [--situations 40]

A scripted person leads a gripper over random bent arms, from above the wrist past the elbow to
above the shoulder, 9 cm high, with human variability. Each policy learns from M such paths and is
asked for new arms. A path *reaches* where it ends within 8 cm of the expert's end and passes within
10 cm of all of the expert's path. No cloth, no robot: use it to compare settings, not to predict
success rates. Prints a Markdown table.
"""

import argparse

import numpy as np

from dressing_sim.learning import Frame, SyntheticDemonstration, TrajectoryTPGMM

UPPER_ARM, FOREARM = 0.279, 0.257  # [m]
HEIGHT = 0.09  # of the gripper over the arm [m]
DT = 0.05  # [s]
REACHED, ON_THE_WAY = 0.08, 0.10  # [m]

SETTINGS = {
    "defaults (regression-then-product, floors 10 %, 10 %, K = 4)": {},
    "each frame its own responsibilities": {"shared": False},
    "product-then-regression": {"fusion": "product-then-regression"},
    "floors 1e-4 m^2, 1e-4 m^2 (as pbdlib)": {
        "relative_floor": False,
        "position_floor": 1e-4,
        "displacement_floor": 1e-4,
    },
    "floors 1e-3 m^2, 1e-6 m^2": {
        "relative_floor": False,
        "position_floor": 1e-3,
        "displacement_floor": 1e-6,
    },
    "floors 1 %, 1 %": {"position_floor": 0.01, "displacement_floor": 0.01},
    "floors 3 %, 3 %": {"position_floor": 0.03, "displacement_floor": 0.03},
    "floors 30 %, 10 %": {"position_floor": 0.3, "displacement_floor": 0.1},
    "floors 10 %, 1 %": {"position_floor": 0.1, "displacement_floor": 0.01},
    "no end radius (rest only)": {"end_radius": 0.0},
    "K = 3": {"n_components": 3},
    "K = 6": {"n_components": 6},
    "100 samples": {"samples": 100},
    "shrinkage": {"shrinkage": True},
    "shrinkage, floors 3 %, 3 %": {
        "shrinkage": True,
        "position_floor": 0.03,
        "displacement_floor": 0.03,
    },
}


def random_arm(rng: np.random.Generator) -> np.ndarray:
    """Shoulder, elbow and wrist (3, 3) of an arm held out and bent by 10 to 80 degrees."""
    azimuth, elevation = rng.uniform(-0.6, 0.6), rng.uniform(-0.5, 0.5)
    upper = np.array(
        [
            np.cos(azimuth) * np.cos(elevation),
            np.sin(azimuth) * np.cos(elevation),
            np.sin(elevation),
        ]
    )
    bend = np.deg2rad(rng.uniform(10, 80))
    side = np.cross(upper, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side)
    roll = rng.uniform(-0.5, 0.5) + np.pi / 2
    axis = side * np.cos(roll) + np.cross(upper, side) * np.sin(roll)
    lower = upper * np.cos(bend) + np.cross(axis, upper) * np.sin(bend)
    elbow = UPPER_ARM * upper
    return np.stack([np.zeros(3), elbow, elbow + FOREARM * lower])


def frames_of(arm: np.ndarray) -> tuple[Frame, Frame]:
    """Frames at the shoulder and at the wrist, x towards the elbow, z as far up as it goes."""

    def frame(origin: np.ndarray, towards: np.ndarray) -> Frame:
        x = (towards - origin) / np.linalg.norm(towards - origin)
        z = np.array([0.0, 0.0, 1.0]) - x[2] * x
        z /= np.linalg.norm(z)
        return Frame(np.stack([x, np.cross(z, x), z], axis=1), origin)

    shoulder, elbow, wrist = arm
    return frame(shoulder, elbow), frame(wrist, elbow)


def lead(
    arm: np.ndarray, rng: np.random.Generator, variability: float = 1.0
) -> SyntheticDemonstration:
    """A scripted demonstration: waypoints, duration, timing and tremor vary."""
    from scipy.interpolate import PchipInterpolator

    shoulder, elbow, wrist = arm
    along = (wrist - elbow) / np.linalg.norm(wrist - elbow)
    waypoints = np.array([wrist + 0.03 * along, elbow, shoulder])
    waypoints += [0.0, 0.0, HEIGHT]
    waypoints += variability * rng.normal(0.0, 0.012, (3, 3))
    knots = np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(waypoints, axis=0), axis=1))])
    count = round(10.0 * np.exp(variability * rng.normal(0.0, 0.15)) / DT)
    phase = np.linspace(0.0, 1.0, count)
    phase = phase + variability * rng.normal(0.0, 0.05) * np.sin(2 * np.pi * phase)
    progress = np.clip(phase**3 * (10 - 15 * phase + 6 * phase**2), 0.0, 1.0)
    path = PchipInterpolator(knots, waypoints, axis=0)(progress * knots[-1])
    times = DT * np.arange(count)[:, None]
    tremor = np.sin(2 * np.pi * rng.uniform(0.3, 1.0, 3) * times + rng.uniform(0, 6.3, 3))
    return SyntheticDemonstration(path + 0.002 * variability * tremor, DT, frames_of(arm))


def share_reached(settings: dict, n_demonstrations: int, seeds: int, situations: int) -> float:
    """Share of new arms over which the policy's path reaches."""
    reached = []
    for seed in range(seeds):
        rng = np.random.default_rng(seed)
        demonstrations = [lead(random_arm(rng), rng) for _ in range(n_demonstrations)]
        policy = TrajectoryTPGMM(**settings).fit(demonstrations)
        rng = np.random.default_rng(10_000)  # the same new arms for everyone
        for _ in range(situations):
            expert = lead(random_arm(rng), rng, variability=0.0)
            path = policy.generate(expert.frames, expert.positions[0])
            gaps = np.linalg.norm(path[:, None] - expert.positions[None, ::5], axis=2)
            end = np.linalg.norm(path[-1] - expert.positions[-1])
            reached.append(end < REACHED and gaps.min(axis=0).max() < ON_THE_WAY)
    return float(np.mean(reached))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--situations", type=int, default=40)
    arguments = parser.parse_args()
    counts = (2, 3, 7)
    print("| settings | " + " | ".join(f"{count} demonstrations" for count in counts) + " |")
    print("|-" * (len(counts) + 1) + "|")
    for name, settings in SETTINGS.items():
        shares = [
            share_reached(settings, count, arguments.seeds, arguments.situations)
            for count in counts
        ]
        print(f"| {name} | " + " | ".join(f"{100 * share:.0f} %" for share in shares) + " |")


if __name__ == "__main__":
    main()
