"""What the paper says of its dressing experiment, as data: its table and its claims.

A claim is about a weighted sum of success rates over the same postures and demonstration sets. The
95 % interval of the sum decides, not its estimate: with five postures hardly anything can be told.

Source: Zhu, Gienger and Kober (2022), Learning Task-Parameterized Skills from Few Demonstrations:
the study of data generation (Noise), the dressing experiment, the conclusion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal

from dressing_sim.benchmark.records import Entry

#: (policy, demonstrations) -> successes, trials: five postures, each tried once. From Section V,
#: "Success Rate of robot experiments".
PAPER_TABLE: Mapping[tuple[str, str], tuple[int, int]] = {
    ("tp-gmm", "case_a"): (1, 5),
    ("tp-gmm-rf", "case_a"): (4, 5),
    ("tp-gmm-rf-noise", "case_a"): (3, 5),
    ("tp-gmm", "case_b"): (1, 5),
    ("tp-gmm-rf", "case_b"): (3, 5),
    ("tp-gmm-rf-noise", "case_b"): (2, 5),
    ("tp-gmm", "baseline7"): (4, 5),
}

Verdict = Literal["confirmed", "refuted", "undecided"]

#: Success rates that differ by less than this count as equal. Own choice.
MARGIN = 0.10

#: A gain that stays below this is no help worth the name. Own choice: one posture in twenty.
NO_EFFECT = 0.05


@dataclass(frozen=True, slots=True)
class Rule:
    """How an interval becomes a verdict.

    Attributes:
        criterion: The rule in words.
        confirms: Whether bounds, from -1 to 1 for a difference, confirm the claim.
        refutes: Whether bounds that do not confirm it refute it.
    """

    criterion: str
    confirms: Callable[[float, float], bool]
    refutes: Callable[[float, float], bool]

    def verdict(self, low: float, high: float) -> Verdict:
        """The verdict by the interval's bounds."""
        if self.confirms(low, high):
            return "confirmed"
        return "refuted" if self.refutes(low, high) else "undecided"


_SMALL, _WIDE = f"{100 * NO_EFFECT:.0f} points", f"{100 * MARGIN:.0f} points"

#: The first is better. No gain, or next to none, refutes it as a loss does.
MORE = Rule(
    f"confirmed if the interval is above 0; else refuted if it is below +{_SMALL}",
    lambda low, high: low > 0.0,
    lambda low, high: high < NO_EFFECT,
)

#: The first is not better: the contrary of `MORE`.
NOT_MORE = Rule(
    f"refuted if the interval is above 0; else confirmed if it is below +{_SMALL}",
    lambda low, high: low <= 0.0 and high < NO_EFFECT,
    lambda low, high: low > 0.0,
)

#: Both are equally good.
ALIKE = Rule(
    f"confirmed if the interval is within {_WIDE} of 0, refuted if it is wholly outside",
    lambda low, high: low >= -MARGIN and high <= MARGIN,
    lambda low, high: low > MARGIN or high < -MARGIN,
)

#: The first is as good as the second, or better.
NO_LESS = Rule(
    f"confirmed if the interval is above -{_WIDE}, refuted if it is wholly below",
    lambda low, high: low >= -MARGIN,
    lambda low, high: high < -MARGIN,
)

#: Of a rate rather than a difference: in most cases.
MOSTLY = Rule(
    "confirmed if the interval is above 50 %, refuted if it is below",
    lambda low, high: low > 0.5,
    lambda low, high: high < 0.5,
)


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A claim as data.

    Attributes:
        name: Short name.
        statement: What the paper says.
        terms: Weight of each row's success rate in the sum that is judged.
        rule: What decides.
    """

    name: str
    statement: str
    terms: tuple[tuple[int, Entry], ...]
    rule: Rule


CASES = {"case_a": "case A (distinct postures)", "case_b": "case B (similar postures)"}
BASELINE = Entry("tp-gmm", "baseline7")
_INITIAL, _NOISE, _RF, _BOTH = "tp-gmm", "tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise"

#: Of the policies of one case: name, statement, first and second policy, rule.
_WITHIN_A_CASE = (
    ("rf_helps", "RF helps", _RF, _INITIAL, MORE),
    ("rf_noise_helps", "RF+noise helps", _BOTH, _INITIAL, MORE),
    (
        "noise_does_not_help",
        "Noise alone overfits: it does not help in new situations",
        *(_NOISE, _INITIAL, NOT_MORE),
    ),
    ("rf_beats_noise", "RF generalises better than Noise alone", _RF, _NOISE, MORE),
    ("rf_noise_beats_noise", "RF+noise generalises better than Noise alone", _BOTH, _NOISE, MORE),
    ("rf_like_rf_noise", "RF and RF+noise perform alike", _RF, _BOTH, ALIKE),
)


def _between_cases(name: str, key: str, policy: str) -> tuple[Hypothesis, Hypothesis]:
    ends = ((1, Entry(policy, "case_a")), (-1, Entry(policy, "case_b")))
    begins = ((-1, Entry(_INITIAL, "case_a")), (1, Entry(_INITIAL, "case_b")))
    gains = (ends[0], begins[0], ends[1], begins[1])
    more, better = f"case_a_gains_more_{key}", f"case_a_ends_better_{key}"
    return (
        Hypothesis(more, f"case A gains more from {name} than case B", gains, MORE),
        Hypothesis(better, f"with {name}, case A outperforms case B", ends, MORE),
    )


#: The claims about weighted sums of success rates.
HYPOTHESES: tuple[Hypothesis, ...] = (
    *(
        Hypothesis(
            f"{name}_{case}",
            f"{statement}, {where}",
            ((1, Entry(a, case)), (-1, Entry(b, case))),
            rule,
        )
        for case, where in CASES.items()
        for name, statement, a, b, rule in _WITHIN_A_CASE
    ),
    *_between_cases("RF", "rf", _RF),
    *_between_cases("RF+noise", "rf_noise", _BOTH),
)

#: Two demonstrations and synthetic ones, each held against seven: one of them may match these.
AUGMENTED: tuple[Hypothesis, ...] = tuple(
    Hypothesis(
        "best_matches_baseline",
        "the best augmented policy of two demonstrations matches that of seven",
        ((1, Entry(policy, case)), (-1, BASELINE)),
        NO_LESS,
    )
    for case in CASES
    for policy in (_NOISE, _RF, _BOTH)
)
