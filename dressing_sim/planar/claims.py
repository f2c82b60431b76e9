"""What the paper says of its planar study, sentence by sentence, as ratios that can be judged.

Source: Zhu, Gienger and Kober (2022), "Learning task-parameterized skills from few demonstrations",
section V and, of the similarity of its two methods, section VII. The words here are ours.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from dressing_sim.learning.augment import Method
from dressing_sim.learning.frame import FloatArray
from dressing_sim.planar.measures import rms_difference
from dressing_sim.planar.sets import Ratio, gain
from dressing_sim.planar.study import Selection, Study, initial_policy

Side = Literal["below", "above", "near"]
Verdict = Literal["confirmed", "refuted", "undecided"]

#: Ratios up to this and down to its inverse are near to 1: the paper calls 102 % close to the
#: reference, 85 and 88 % comparable, and 111 % even higher.
NEAR = 1.1


@dataclass(frozen=True)
class Claim:
    """A statement about a ratio.

    Attributes:
        text: what is said.
        side: where the ratio would be if it held: below or above 1, or near to it.
        value: of one study, the ratio's logarithm.
        methods: that a study needs.
        needs: whether it needs demonstrations to validate with, and to test with.
    """

    text: str
    side: Side
    value: Callable[[Study], float]
    methods: tuple[Method, ...] = ()
    needs: tuple[str, ...] = ("validation",)

    def holds_for(self, study: Study) -> bool:
        """Whether a study has what it takes."""
        there = all(getattr(study.data, name) for name in self.needs)
        return there and set(self.methods) <= set(study.config.methods)


def judged(claim: Claim, studies: Sequence[Study]) -> tuple[Ratio, Verdict] | None:
    """The ratio over all studies and the verdict; None where they cannot tell.

    Confirmed if the whole interval is where the claim says, refuted if none of it is.
    """
    if not all(claim.holds_for(study) for study in studies):
        return None
    ratio = Ratio.of([claim.value(study) for study in studies])
    return ratio, verdict(ratio, claim.side)


def verdict(ratio: Ratio, side: Side) -> Verdict:
    """See ``judged``."""
    low, high = {"below": (0.0, 1.0), "above": (1.0, np.inf), "near": (1.0 / NEAR, NEAR)}[side]
    if ratio.n == 1:
        return "undecided"
    if low <= ratio.low and ratio.high <= high:
        return "confirmed"
    return "refuted" if ratio.high < low or ratio.low > high else "undecided"


def _gain(method: Method, selection: Selection, kind: str, text: str, side: Side) -> Claim:
    needs = () if (selection, kind) == ("original", "training") else ("validation",)
    return Claim(text, side, lambda one: gain(one, method, selection, kind), (method,), needs)


def _versus(a: Method, b: Method, kind: str, text: str, side: Side) -> Claim:
    """The first method's cost over the second's, with the original selection."""

    def value(study: Study) -> float:
        return gain(study, a, "original", kind) - gain(study, b, "original", kind)

    return Claim(text, side, value, (a, b), () if kind == "training" else ("validation",))


def _selections(method: Method, text: str) -> Claim:
    """Validation cost with the original selection over that with generalisation selection."""

    def value(study: Study) -> float:
        first, second = (
            gain(study, method, selection, "validation") for selection in study.selections
        )
        return first - second

    return Claim(text, "near", value, (method,))


def _held_out(method: Method) -> Claim:
    """With generalisation selection: gain on the test set over that on the validation set."""

    def value(study: Study) -> float:
        test, seen = (gain(study, method, "generalisation", k) for k in ("test", "validation"))
        return test - seen

    text = f"with generalisation selection, *{method}* fits to the validation set"
    return Claim(text, "above", value, (method,), ("validation", "test"))


def _shaken(study: Study) -> float:
    """Second differences of Noise's paths in the validation situations over the initial ones'."""
    runs = study.of("noise", "original")
    made = [_bends(study, run.augmentation.policy) for run in runs]
    return float(np.log(np.mean(made)) - np.log(_bends(study, study.initial)))


def _bends(study: Study, policy: Any) -> float:
    paths = _paths(study, policy)
    return float(np.mean([rms_difference(path, 2) for path in paths]))


def _paths(study: Study, policy: Any) -> list[FloatArray]:
    return [policy.reproduce(one).positions for one in study.data.validation]


def _alike(method: Method) -> Callable[[Study], float]:
    """Distance of a method's paths from those of RF+noise selected by generalisation, over the
    distance of the initial model's from these."""

    def value(study: Study) -> float:
        own, wanted, initial = [], [], np.stack(_paths(study, study.initial))
        pairs = zip(
            study.of(method, "original"), study.of("rf+noise", "generalisation"), strict=True
        )
        for run, other in pairs:
            target = np.stack(_paths(study, other.augmentation.policy))
            own.append(np.linalg.norm(np.stack(_paths(study, run.augmentation.policy)) - target))
            wanted.append(np.linalg.norm(initial - target))
        if np.mean(wanted) == 0.0:  # nothing was accepted: there is nothing to be like
            return 0.0
        return float(np.log(max(np.mean(own), 1e-12)) - np.log(np.mean(wanted)))

    return value


def _more_components(kind: str) -> Callable[[Study], float]:
    """Cost of an initial model of twice the components over the usual one's."""

    def value(study: Study) -> float:
        demonstrations = getattr(study.data, kind)
        larger = initial_policy(replace(study.config, components=2 * study.config.components))
        cost = larger.fit(study.data.training).cost(demonstrations)
        return float(np.log(cost) - np.log(study.initial.cost(demonstrations)))

    return value


def _unsatisfactory(study: Study) -> float:
    return float(
        np.log(study.initial.cost(study.data.validation)) - np.log(study.initial_training_cost)
    )


_SAME = "reduces the cost on the training set"

CLAIMS: tuple[Claim, ...] = (
    Claim("the initial model's cost is higher in new situations", "above", _unsatisfactory),
    _gain("noise", "original", "training", f"*noise* {_SAME}", "below"),
    _gain("rf", "original", "training", f"*rf* {_SAME}", "below"),
    _gain("rf+noise", "original", "training", f"*rf+noise* {_SAME}", "below"),
    _versus("noise", "rf", "training", "*noise* reduces it more than *rf*", "below"),
    _versus("noise", "rf+noise", "training", "*noise* reduces it more than *rf+noise*", "below"),
    _versus("noise", "copies", "training", "(control) *noise* beats exact *copies* there", "below"),
    _gain("copies", "original", "training", f"(control) *copies* {_SAME}", "below"),
    _gain("noise", "original", "validation", "*noise* overfits: costs more in new ones", "above"),
    _gain("copies", "original", "validation", "(control) so do *copies*", "above"),
    Claim("*noise* magnifies unwanted movements in new ones", "above", _shaken, ("noise",)),
    _gain("rf", "original", "validation", "*rf* costs less in new situations", "below"),
    _gain("rf+noise", "original", "validation", "*rf+noise* costs less in new ones", "below"),
    _versus("rf", "noise", "validation", "*rf* generalises better than *noise*", "below"),
    _versus("rf+noise", "noise", "validation", "*rf+noise* better than *noise*", "below"),
    _versus("rf+noise", "rf", "validation", "*rf* and *rf+noise* are alike there", "near"),
    _gain(
        "noise",
        "generalisation",
        "training",
        "selected by generalisation, *noise* keeps the training cost",
        "near",
    ),
    _gain("rf+noise", "generalisation", "training", "so does *rf+noise*", "near"),
    _gain("rf", "generalisation", "training", "and *rf* raises it", "above"),
    _selections("rf", "*rf* generalises as well by either selection"),
    _selections("rf+noise", "*rf+noise* likewise"),
    Claim(
        "*rf*'s paths are more like those of *rf+noise* selected by generalisation than the "
        "initial ones",
        "below",
        _alike("rf"),
        ("rf", "rf+noise"),
    ),
    Claim("*rf+noise*'s likewise", "below", _alike("rf+noise"), ("rf+noise",)),
    _held_out("rf"),
    _held_out("rf+noise"),
    Claim(
        "twice the components lower the training cost",
        "below",
        _more_components("training"),
        needs=(),
    ),
    Claim("and cost more in new situations", "above", _more_components("validation")),
)
