"""Where does a policy fail? A map of a run over the bend of elbow and shoulder.

python examples/08_a_failure_map.py [RUN] [--suite random:12] [--plot failures.png]

RUN is a folder of `dressing-sim evaluate`; without one, straight lines to the shoulder are tried.
"""

import argparse
import json
from collections import defaultdict
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import dressing_sim


class Straight:
    """Straight to above the shoulder; it knows nothing of the elbow."""

    def fit(self, demonstrations: object) -> "Straight":
        """There is nothing to learn."""
        return self

    def generate(self, frames: object, start: np.ndarray) -> np.ndarray:
        """A line (60, 3) [m]."""
        return np.linspace(start, frames.shoulder.b + [0.0, 0.0, 0.09], 60)


def of_a_run(folder: Path) -> list[tuple[float, float, str]]:
    """Elbow and flexion [deg] of each episode, and what went wrong first."""
    lines = (folder / "episodes.jsonl").read_text(encoding="utf-8").splitlines()
    episodes = [json.loads(line) for line in lines]
    return [
        (
            one["posture"]["elbow_deg"],
            one["posture"]["flexion_deg"],
            one["failures"][0]["reason"] if one["failures"] else "dressed",
        )
        for one in episodes
    ]


def of_straight_lines(suite: str) -> list[tuple[float, float, str]]:
    """The same, measured here."""
    found = []
    for arm in dressing_sim.load_suite(suite):
        outcome = dressing_sim.dress(Straight(), arm)
        found.append((arm.elbow_deg, arm.flexion_deg, (*outcome.reasons, "dressed")[0]))
    return found


def main() -> None:
    """Draw the map, and count."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("run", type=Path, nargs="?")
    parser.add_argument("--suite", default="random:12")
    parser.add_argument("--plot", default="failures.png")
    args = parser.parse_args()
    places = defaultdict(list)
    found = of_a_run(args.run) if args.run else of_straight_lines(args.suite)
    for elbow, flexion, what in found:
        places[what].append((elbow, flexion))
    axes = (figure := Figure(layout="constrained")).add_subplot()
    for what, points in places.items():
        axes.plot(*np.transpose(points), "o", label=f"{what} ({len(points)})")
        print(f"{what}: {len(points)}")
    axes.set(xlabel="elbow [deg]", ylabel="shoulder flexion [deg]")
    axes.legend()
    figure.savefig(args.plot)


if __name__ == "__main__":
    main()
