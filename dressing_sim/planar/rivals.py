"""The methods of ``learning.rivals`` in the plane, next to the paper's, on the same demonstrations.

Everybody is asked for the motion in a situation from where the expert began it, and compared with
the expert's in phase: both trimmed of standing still, at evenly spaced moments of their own
duration. The cost is the root mean square distance, in the units of the task; ratios are those to
the initial model of the paper's study, the time-based TP-GMM, set by set.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.augment import METHODS as AUGMENTATIONS
from dressing_sim.learning.demonstrations import SyntheticDemonstration
from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals import METHODS, Method, Shown
from dressing_sim.learning.rivals.method import begun_at, resampled
from dressing_sim.planar.box import penetration
from dressing_sim.planar.generator import PlanarData
from dressing_sim.planar.sets import Ratio
from dressing_sim.planar.study import StudyConfig, augmented, initial_policy

#: A path in phase (N, 2) in a situation from a start.
Answer = Callable[[Sequence[Frame], FloatArray], FloatArray]

INITIAL = "tp-gmm"

#: Points of a path that are compared.
_SAMPLES = 100


@dataclass(frozen=True, slots=True)
class Compared:
    """One method over all sets.

    Attributes:
        name: of the method.
        training, unseen: cost in the situations of training and in those never seen, of each set.
        depth: how deep paths go into walls there at worst, mean over the unseen situations.
    """

    name: str
    training: tuple[float, ...]
    unseen: tuple[float, ...]
    depth: float

    def ratio(self, other: "Compared") -> Ratio:
        """Unseen cost over another method's."""
        pairs = zip(self.unseen, other.unseen, strict=True)
        return Ratio.of([float(np.log(own) - np.log(theirs)) for own, theirs in pairs])


def compare(
    sets: Sequence[PlanarData], config: StudyConfig, on_method: Callable[[str], None] | None = None
) -> tuple[tuple[Compared, ...], dict[str, str]]:
    """Every method on every set.

    Args:
        sets: to learn from, each with demonstrations to validate or to test with.
        config: of the paper's methods: the initial model, and Algorithm 1 once with each of its
            ways of making demonstrations.
        on_method: called with each method's name before it learns, for progress.

    Returns:
        The methods that can learn this task, and why the others cannot.

    Raises:
        InvalidInputError: a set without unseen demonstrations.
    """
    if not all(data.validation for data in sets):
        raise InvalidInputError("a comparison needs demonstrations to validate on")
    compared, refused = [], {}
    for name, learn in learners(config).items():
        if on_method is not None:
            on_method(name)
        try:
            compared.append(_compared(name, learn, sets))
        except InvalidInputError as error:
            refused[name] = str(error)
    return tuple(compared), refused


def learners(config: StudyConfig) -> dict[str, Callable[[PlanarData], Answer]]:
    ours: dict[str, Callable[[PlanarData], Answer]] = {
        INITIAL: lambda data: _answer(initial_policy(config).fit(data.training))
    }
    for method in AUGMENTATIONS:
        ours[f"{INITIAL}, {method}"] = _augmenting(config, method)
    return {**ours, **{name: _learning(method, config.seed) for name, method in METHODS.items()}}


def _augmenting(config: StudyConfig, method: Any) -> Callable[[PlanarData], Answer]:
    return lambda data: _answer(augmented(config, data, method, "original", 0).policy)


def _answer(policy: Any) -> Answer:
    def answer(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
        made = SyntheticDemonstration(policy.generate(frames, start), policy.dt, frames)
        return _in_phase(made)

    return answer


def _learning(method: Method, seed: int) -> Callable[[PlanarData], Answer]:
    def learn(data: PlanarData) -> Answer:
        if method.inputs != "frames":
            raise InvalidInputError(f"it is asked with more than the two frames: {method.inputs}")
        shown = Shown.of(data.training, method.samples)
        skill = method.learn(shown, np.random.default_rng(seed))

        def answer(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            path = begun_at(start, skill(frames, start), shown.phase)
            return resampled(path, _SAMPLES)  # it was learned in phase: nothing to trim

        return answer

    return learn


def _compared(
    name: str, learn: Callable[[PlanarData], Answer], sets: Sequence[PlanarData]
) -> Compared:
    training, unseen, depths = [], [], []
    for data in sets:
        answer = learn(data)
        training.append(float(np.mean([_cost(answer, one)[0] for one in data.training])))
        found = [_cost(answer, one) for one in (*data.validation, *data.test)]
        unseen.append(float(np.mean([cost for cost, _ in found])))
        depths.append(float(np.mean([depth for _, depth in found])))
    return Compared(name, tuple(training), tuple(unseen), float(np.mean(depths)))


def _cost(answer: Answer, expert: SyntheticDemonstration) -> tuple[float, float]:
    """Root mean square distance from an expert's path, and depth in the walls."""
    theirs = _in_phase(expert)
    ours = answer(expert.frames, theirs[0])
    distance = float(np.sqrt(np.mean(np.sum((ours - theirs) ** 2, axis=1))))
    return distance, max(penetration(ours, frame) for frame in expert.frames)


def _in_phase(demonstration: SyntheticDemonstration) -> FloatArray:
    return Shown.of([demonstration], _SAMPLES).points[0]


def comparison(
    compared: Sequence[Compared], refused: dict[str, str], config: StudyConfig, n_sets: int
) -> dict[str, Any]:
    """The result as JSON-able numbers, the best in unseen situations first."""
    reference = next(one for one in compared if one.name == INITIAL)
    rows = []
    for one in sorted(compared, key=lambda one: float(np.mean(np.log(one.unseen)))):
        ratio = one.ratio(reference)
        bounded = ratio.n > 1 and one is not reference
        rows.append(
            {
                "method": one.name,
                "training": float(np.mean(one.training)),
                "unseen": float(np.mean(one.unseen)),
                "unseen_of_sets": list(one.unseen),
                "percent": 100.0 * ratio.estimate,
                "percent_low": 100.0 * ratio.low if bounded else None,
                "percent_high": 100.0 * ratio.high if bounded else None,
                "wall_depth": one.depth,
            }
        )
    settings = {"sets": n_sets, "seed": config.seed, "components": config.components}
    return {"rows": rows, "refused": refused, "settings": {**settings, "fusion": config.fusion}}


def comparison_markdown(result: dict[str, Any]) -> str:
    """The table of ``comparison``."""
    settings = result["settings"]
    lines = [
        f"{settings['sets']} sets, seed {settings['seed']}; tp-gmm: K = {settings['components']}, "
        f"{settings['fusion']}",
        "",
        f"| method | training | unseen | % of {INITIAL}'s [95 %] | wall depth |",
        "|-|-|-|-|-|",
    ]
    for row in result["rows"]:
        percent = f"{row['percent']:.0f}"
        if row["percent_low"] is not None:
            percent += f" [{row['percent_low']:.0f}, {row['percent_high']:.0f}]"
        cells = (row["method"], f"{row['training']:.3f}", f"{row['unseen']:.3f}", percent)
        lines.append("| " + " | ".join((*cells, f"{row['wall_depth']:.3f}")) + " |")
    if result["refused"]:
        lines += ["", "Cannot learn this task:", ""]
        lines += [f"* {name}: {reason}" for name, reason in result["refused"].items()]
    return "\n".join(lines) + "\n"
