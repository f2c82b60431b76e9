"""A recording as a lab would have it, and what the simulator makes of it.

python examples/05_a_recording.py [--posture bent40] [--out recording.csv] [--plot recording.png]

The operator dresses an arm. What is known of it is written down in a lab's way: millimetres and
milliseconds, in a frame of the lab's own, at uneven times. Then it is imported and played again.
"""

import argparse
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import dressing_sim
from dressing_sim.datasets.prepare import ImportConfig
from dressing_sim.datasets.sources import read_source
from dressing_sim.suites.suites import find_posture

TURN_DEG, ORIGIN = 70.0, np.array([1.2, -0.4, 0.75])  # of the lab's frame [deg, m]
KEPT = 0.6  # of the rows: the lab's clock is not even
DT = 0.02  # [s]


def write(path: Path, positions: np.ndarray, posture: dressing_sim.Posture) -> None:
    """Positions (T, 3) [m] and the arm's joints as a lab's CSV."""

    def in_lab(places: np.ndarray) -> np.ndarray:
        return 1e3 * (Rotation.from_euler("z", TURN_DEG, degrees=True).apply(places) + ORIGIN)

    rows = np.flatnonzero(np.random.default_rng(0).uniform(size=len(positions)) < KEPT)
    columns = {"time_ms": 1e3 * DT * rows[:, None]}
    for name in ("gripper", "shoulder", "elbow", "wrist"):
        joint = getattr(posture, name, None)
        columns[name] = in_lab(positions[rows] if joint is None else np.tile(joint, (len(rows), 1)))
    names = ["time_ms", *(f"{one}_{axis}_mm" for one in [*columns][1:] for axis in "xyz")]
    lines = [",".join(f"{number:.2f}" for number in row) for row in np.hstack([*columns.values()])]
    path.write_text("\n".join([",".join(names), *lines, ""]), encoding="utf-8")


def plot(path: Path, recorded: np.ndarray, simulated: np.ndarray) -> None:
    """Recording (T, 3) against what the simulated gripper did, in the robot's base frame [m]."""
    figure = Figure(figsize=(7, 3), layout="constrained")
    for axes, (across, up) in zip(figure.subplots(1, 2), ((0, 1), (1, 2)), strict=True):
        axes.plot(recorded[:, across], recorded[:, up], lw=4, alpha=0.4, label="recording")
        axes.plot(simulated[:, across], simulated[:, up], lw=1, label="simulated gripper")
        axes.set(xlabel=f"{'xyz'[across]} [m]", ylabel=f"{'xyz'[up]} [m]", aspect="equal")
    axes.legend(frameon=False)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Dress, write, read, play."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--posture", default="bent40")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, default=Path("recording.csv"))
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    posture = find_posture(args.posture)
    shown = dressing_sim.record(dressing_sim.Operator(), posture, args.seed)
    write(args.out, shown.positions, posture)
    (made,) = read_source(args.out, ImportConfig(turn_deg=-TURN_DEG, trim_pauses=True))
    path = dressing_sim.Path(made.positions, made.dt)
    played = dressing_sim.record(path, made.posture)
    print(f"{args.out}: {len(made.positions)} rows, played again: {played.outcome.success}")
    if args.plot:
        plot(args.plot, made.positions, played.positions)


if __name__ == "__main__":
    main()
