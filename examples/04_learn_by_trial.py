"""An agent learns to dress an arm by trial: CMA-ES on where its path goes, through Gymnasium.

python examples/04_learn_by_trial.py [--posture bent40] [--generations 8] [--population 8]
                                     [--seed 0] [--out learning.png]

It needs pip install 'dressing-sim[gymnasium]' cmaes. The agent sees what a policy of class `frames`
may see: its gripper and the two frames. It begins with a path straight above the arm, moves three
points of it, and is told nothing but its return: what the dense reward of an episode adds up to.
That is 1.4 to 1.8 for a dressed arm and below 1 for any other.
"""

import argparse
from dataclasses import dataclass

import gymnasium
import matplotlib
import numpy as np
from cmaes import CMA

import dressing_sim.envs  # registers the environment

matplotlib.use("Agg")
from matplotlib import pyplot as plt

HEIGHT = 0.09  # of the first path above the arm [m]
SPEED = 0.10  # of the gripper along its path [m/s]
SPREAD = 0.03  # standard deviation of the first offsets [m]
FURTHEST = 0.20  # an offset is no larger, in each coordinate [m]
DT = 0.02  # of a control step [s]
ORANGE, BLUE = "#d55e00", "#0072b2"


@dataclass(frozen=True)
class Trial:
    """One episode: what it added up to and how it ended."""

    gained: float
    success: bool
    reasons: tuple[str, ...]


@dataclass(frozen=True)
class Generation:
    """What the agent tried, and then the path that it held to be the best: its mean."""

    tried: list[Trial]
    learned: Trial


def elbow_of(seen: dict[str, np.ndarray]) -> np.ndarray:
    """Where the x axes of both frames meet, (3,) [m]: the point nearest to both lines."""
    origins = np.stack([seen["wrist_position"], seen["shoulder_position"]])
    along = np.stack([seen["wrist_axes"][:, 0], seen["shoulder_axes"][:, 0]])
    across = np.eye(3) - along[:, :, None] * along[:, None, :]
    total = across.sum(axis=0) + 1e-9 * np.eye(3)
    return np.linalg.solve(total, np.einsum("nij,nj->i", across, origins))


def first_points(seen: dict[str, np.ndarray]) -> np.ndarray:
    """Points (5, 3) [m] straight above the arm, from the gripper to the shoulder."""
    wrist, shoulder = seen["wrist_position"], seen["shoulder_position"]
    elbow, above = elbow_of(seen), np.array([0.0, 0.0, HEIGHT])
    on_arm = [(wrist + elbow) / 2, elbow, (elbow + shoulder) / 2, shoulder]
    return np.vstack([seen["target"], np.array(on_arm) + above])


def path_through(points: np.ndarray) -> np.ndarray:
    """A path (n, 3) [m] at even speed, its corners rounded over 0.4 s; it ends where it should."""
    lengths = np.linalg.norm(np.diff(points, axis=0), axis=1)
    distance = np.concatenate([[0.0], np.cumsum(lengths)])
    steps = np.arange(0.0, distance[-1], SPEED * DT)
    path = np.column_stack([np.interp(steps, distance, column) for column in points.T])
    half = round(0.2 / DT)
    window = np.hanning(2 * half + 3)[1:-1] / np.hanning(2 * half + 3)[1:-1].sum()
    padded = np.pad(np.vstack([path, points[-1]]), ((2 * half, 2 * half), (0, 0)), mode="edge")
    return np.column_stack([np.convolve(column, window, "valid") for column in padded.T])


def try_out(env: gymnasium.Env, offsets: np.ndarray) -> Trial:
    """Dress the arm once along the path with its middle points moved by offsets (3, 3) [m]."""
    seen, info = env.reset()
    points = first_points(seen)
    points[1:4] += offsets
    path, gained, over, step = path_through(points), 0.0, False, 0
    while not over:
        action = np.zeros(4)
        if step < len(path):
            action[:3] = path[step] - seen["target"]
        else:
            action[3] = 1.0  # I have finished
        seen, reward, terminated, truncated, info = env.step(action)
        gained, over, step = gained + float(reward), terminated or truncated, step + 1
    return Trial(gained, info["is_success"], tuple(info["reasons"]))


def learn(env: gymnasium.Env, generations: int, population: int, seed: int) -> list[Generation]:
    """Every generation; before the first the agent would go straight above the arm."""
    bounds = np.tile([-FURTHEST, FURTHEST], (9, 1))
    search = CMA(np.zeros(9), SPREAD, bounds=bounds, seed=seed, population_size=population)
    history = [Generation([], try_out(env, np.zeros((3, 3))))]
    tell(0, history[0])
    for number in range(1, generations + 1):
        asked = [search.ask() for _ in range(population)]
        tried = [try_out(env, offsets.reshape(3, 3)) for offsets in asked]
        search.tell([(x, -trial.gained) for x, trial in zip(asked, tried, strict=True)])
        history.append(Generation(tried, try_out(env, search.mean.reshape(3, 3))))
        tell(number, history[-1])
    return history


def tell(number: int, generation: Generation) -> None:
    """One line a generation."""
    learned, tried = generation.learned, generation.tried
    how = "dressed" if learned.success else ", ".join(learned.reasons)
    dressed = sum(trial.success for trial in tried)
    print(
        f"generation {number}: {dressed} of {len(tried)} tries dressed the arm; "
        f"learned so far: return {learned.gained:.2f}, {how}",
        flush=True,
    )


def draw(history: list[Generation], posture: str, out: str) -> None:
    """The learning curve: every try, and what was learned after each generation."""
    figure, axes = plt.subplots(figsize=(6.0, 3.8), layout="constrained")
    for success, colour, name in ((True, BLUE, "a try, dressed"), (False, ORANGE, "not dressed")):
        points = [
            (number, trial.gained)
            for number, generation in enumerate(history)
            for trial in generation.tried
            if trial.success == success
        ]
        if points:
            axes.scatter(*zip(*points, strict=True), s=18, color=colour, label=name, zorder=3)
    axes.plot([one.learned.gained for one in history], color="#555555", label="learned so far")
    axes.set_xlabel(f"generation of {len(history[-1].tried)} tries (0: straight above the arm)")
    axes.set_ylabel("return")
    axes.set_title(f"CMA-ES on three points of the path, posture {posture}", fontsize=10)
    axes.grid(alpha=0.3)
    figure.legend(loc="outside lower center", ncols=3, frameon=False, fontsize=9)
    figure.savefig(out, dpi=150)
    plt.close(figure)


def main() -> None:
    """Learn, tell, draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--posture", default="bent40")
    parser.add_argument("--generations", type=int, default=8)
    parser.add_argument("--population", type=int, default=8)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", help="file for the learning curve")
    args = parser.parse_args()
    env = gymnasium.make(dressing_sim.envs.GYMNASIUM_ID, posture=args.posture)
    history = learn(env, args.generations, args.population, args.seed)
    env.close()
    episodes = sum(len(one.tried) + 1 for one in history)
    first, last = history[0].learned.gained, history[-1].learned.gained
    print(f"{episodes} episodes; the return went from {first:.2f} to {last:.2f}")
    if args.out:
        draw(history, args.posture, args.out)
        print(f"wrote {args.out}")


if __name__ == "__main__":
    main()
