"""Another task than dressing: two people hand over a hammer, and the library learns from them.

python examples/07_a_second_task.py [--counts 2 3 4] [--splits 10] [--page PAGE] [--plot PLOT]

Nothing here knows of arms or sleeves. Each recording has two frames: where the gripper began, and
the hammer, which lay or was held differently every time. Methods learn from a few recordings and
are asked for the others; `docs/second_task.md` tells what came out.
"""

import argparse
import json
import logging
import re
from collections.abc import Callable
from itertools import combinations
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy import stats

from dressing_sim.learning import (
    Alignment,
    AugmentOptions,
    Clock,
    Frame,
    SyntheticDemonstration,
    TrajectoryTPGMM,
    dtw_distance,
)
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.learning.carried import CarriedDemonstrations
from dressing_sim.learning.registration import corners
from dressing_sim.learning.rivals import METHODS as RIVALS
from dressing_sim.learning.rivals.method import Method, Shown, begun_at
from dressing_sim.learning.rivals.references import apart
from dressing_sim.learning.rivals.regression import FrameRegression

RECORDINGS = Path(__file__).parent / "recordings" / "handover.json"
PHASES = {"reach": "reach for the hammer", "take": "take it from the other hand"}
# People begin and end as they like, which would otherwise be taken for a recording cut short.
ALIGNMENT = Alignment(least_share=0.0)
NOISE = (
    0.05  # of landmarks: that of the dressing policy; lengths are the distance between the frames
)
Shows = list[SyntheticDemonstration]
Skill = Callable[[tuple[Frame, ...], np.ndarray], np.ndarray]


def recordings(phase: str) -> Shows:
    """What was recorded of a phase [m, s]."""
    entries = json.loads(RECORDINGS.read_text(encoding="utf-8"))
    return [
        SyntheticDemonstration(
            np.array(one["positions"]),
            one["dt"],
            tuple(Frame(np.array(frame["A"]), np.array(frame["b"])) for frame in one["frames"]),
        )
        for one in entries
        if one["phase"] == phase
    ]


def tp_gmm(shown: Shows, seed: int) -> Skill:
    """The paper's policy with this library's defaults, recordings on one clock."""
    return TrajectoryTPGMM().fit(Clock.of(shown, ALIGNMENT).align(shown)).generate


def augmented(shown: Shows, seed: int) -> Skill:
    """The same, and Algorithm 1 with random frames and noise."""
    policy = AugmentedTPGMM(AugmentOptions("rf+noise"), seed=seed)
    return policy.fit(Clock.of(shown, ALIGNMENT).align(shown)).generate


def transport(shown: Shows, seed: int) -> Skill:
    """The mean of all recordings, each carried along with the frames' corners."""
    phased = Shown.of(shown, 100)
    reach = float(np.mean([apart(one.frames) for one in shown]))
    marks = np.stack([corners(one.frames, reach) for one in shown])
    times = np.tile(phased.phase * phased.duration, (len(shown), 1))
    alike = np.zeros(len(shown))
    carried = CarriedDemonstrations(phased.points, times, marks, alike, reach, NOISE, 0.0)
    return lambda frames, start: begun_at(
        start, carried.answer(corners(frames, reach), 0.0).points, phased.phase
    )


def reference(method: Method) -> Callable[[Shows, int], Skill]:
    """One of the rivals, begun where the gripper is."""

    def learned(shown: Shows, seed: int) -> Skill:
        phased = Shown.of(shown, method.samples)
        skill = method.learn(phased, np.random.default_rng(seed))
        return lambda frames, start: begun_at(start, skill(frames, start), phased.phase)

    return learned


METHODS = {
    "TP-GMM": tp_gmm,
    "TP-GMM, Algorithm 1": augmented,
    "TP-GMM over time": reference(RIVALS["tp-gmr"]),
    "over time, K by BIC": reference(RIVALS["tp-gmr-bic"]),
    "transport regression": transport,
    "nearest recording, moved": reference(RIVALS["nearest"]),
    "GMR in the hammer's frame": reference(FrameRegression(frame="last")),
    "straight line": reference(RIVALS["straight"]),
}
BASE = "straight line"  # what others are compared with


def judged(shown: Shows, count: int, splits: int) -> dict[str, np.ndarray]:
    """Errors at the end and by DTW in [mm], (R, 2): of each recording, mean over splits without it.

    A split is a set of ``count`` recordings to learn from; every other one is asked for.
    """
    sets = [*combinations(range(len(shown)), count)]
    chosen = np.random.default_rng(0).permutation(len(sets))[:splits]
    errors = {name: [[] for _ in shown] for name in METHODS}
    for seed in chosen:
        for name, learn in METHODS.items():
            skill = learn([shown[one] for one in sets[seed]], int(seed))
            for one in set(range(len(shown))) - set(sets[seed]):
                asked = shown[one]
                path = skill(asked.frames, asked.positions[0])
                miss = np.linalg.norm(path[-1] - asked.positions[-1])
                errors[name][one].append([miss, dtw_distance(path, asked.positions)])
    return {
        name: np.array([np.mean(one, axis=0) for one in held if one]) * 1e3
        for name, held in errors.items()
    }


def difference(paired: np.ndarray) -> str:
    """The mean of paired differences (R,) with Student's 95 % interval over the recordings."""
    half = stats.t.ppf(0.975, len(paired) - 1) * stats.sem(paired)
    return f"{paired.mean():+.0f} ({paired.mean() - half:+.0f} to {paired.mean() + half:+.0f})"


def table(results: dict[tuple[str, int], dict[str, np.ndarray]]) -> str:
    """Markdown: a row for each phase, number of recordings and method."""
    lines = [
        f"| | shown | method | end [mm] | against a {BASE} | DTW [mm] | against a {BASE} |",
        "|---|---|---|---|---|---|---|",
    ]
    for (phase, count), errors in results.items():
        for name, values in errors.items():
            cells = [phase, str(count), name]
            for measure, base in zip(values.T, errors[BASE].T, strict=True):
                compared = "" if name == BASE else difference(measure - base)
                cells += [f"{measure.mean():.0f}", compared]
            lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def plot(path: Path, results: dict[tuple[str, int], dict[str, np.ndarray]]) -> None:
    """Each phase: what two recordings make of the third, from above; DTW by recordings shown."""
    figure = Figure(figsize=(9, 7), layout="constrained")
    for (above, errors), phase in zip(figure.subplots(len(PHASES), 2), PHASES, strict=True):
        *known, asked = recordings(phase)[2:5]
        for one in known:
            above.plot(*one.positions[:, :2].T, color="0.75", lw=3)
        above.plot(*asked.positions[:, :2].T, color="black", lw=3, label="recorded")
        goal = asked.frames[-1]
        above.plot(*np.array([goal.to_world(x)[:2] for x in ([-0.09, 0, 0], [0.12, 0, 0])]).T, "k:")
        counts = [count for found, count in results if found == phase]
        for name, learn in METHODS.items():
            made = learn(known, 0)(asked.frames, asked.positions[0])
            above.plot(*made[:, :2].T, lw=1.2, label=name)
            means = [results[phase, count][name][:, 1].mean() for count in counts]
            errors.plot(counts, means, "o-", label=name)
        above.set(title=PHASES[phase], xlabel="x [m]", ylabel="y [m]", aspect="equal")
        errors.set(xlabel="recordings shown", ylabel="DTW distance [mm]", xticks=counts, ylim=0)
        errors.legend(frameon=False, fontsize=8)
    figure.savefig(path, dpi=120)


def main() -> None:
    """Learn from every split, ask for what was held out, tell."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--counts", type=int, nargs="+", default=[2, 3, 4])
    parser.add_argument("--splits", type=int, default=10, help="sets to learn from, of each count")
    parser.add_argument("--page", type=Path, help="whose table is written anew")
    parser.add_argument("--plot", type=Path)
    args = parser.parse_args()
    logging.getLogger("dressing_sim").setLevel(logging.ERROR)  # of recordings taken for cut short
    asked = [(phase, count) for phase in PHASES for count in args.counts]
    results = {one: judged(recordings(one[0]), one[1], args.splits) for one in asked}
    made = table(results)
    print(made)
    if args.page:
        text = args.page.read_text(encoding="utf-8")
        inside = re.compile(r"(<!-- table -->\n).*?(<!-- end -->)", re.DOTALL)
        args.page.write_text(inside.sub(rf"\1{made}\n\2", text), encoding="utf-8")
    if args.plot:
        plot(args.plot, results)


if __name__ == "__main__":
    main()
