"""What the paper says of its dressing experiment, as data: its table and its claims.

A claim is about a weighted sum of success rates over the same postures and demonstration sets. The
95 % interval of the sum decides, not its estimate: with five postures hardly anything can be told.

Source: Zhu, Gienger and Kober (2022), Learning Task-Parameterized Skills from Few Demonstrations:
the study of data generation (Noise), the dressing experiment, the conclusion.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from dressing_sim.benchmark.analysis.statistics import wilson_interval
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
    """How the interval of a difference becomes a verdict.

    Attributes:
        criterion: The rule in words.
        verdict: Verdict by the interval's lower and upper bound, -1 to 1 for a difference.
    """

    criterion: str
    verdict: Callable[[float, float], Verdict]


def _more(low: float, high: float) -> Verdict:
    if low > 0.0:
        return "confirmed"
    return "refuted" if high < NO_EFFECT else "undecided"


def _not_more(low: float, high: float) -> Verdict:
    contrary: dict[Verdict, Verdict] = {"confirmed": "refuted", "refuted": "confirmed"}
    verdict = _more(low, high)
    return contrary.get(verdict, verdict)


def _alike(low: float, high: float) -> Verdict:
    if low >= -MARGIN and high <= MARGIN:
        return "confirmed"
    return "refuted" if low > MARGIN or high < -MARGIN else "undecided"


def _no_less(low: float, high: float) -> Verdict:
    if low >= -MARGIN:
        return "confirmed"
    return "refuted" if high < -MARGIN else "undecided"


_SMALL, _WIDE = f"{100 * NO_EFFECT:.0f} points", f"{100 * MARGIN:.0f} points"

#: The first is better. No gain, or next to none, refutes it as a loss does.
MORE = Rule(f"confirmed if the interval is above 0; else refuted if it is below +{_SMALL}", _more)

#: The first is not better: the contrary of `MORE`.
NOT_MORE = Rule(
    f"refuted if the interval is above 0; else confirmed if it is below +{_SMALL}", _not_more
)

#: Both are equally good.
ALIKE = Rule(
    f"confirmed if the interval is within {_WIDE} of 0, refuted if it is wholly outside", _alike
)

#: The first is as good as the second, or better.
NO_LESS = Rule(
    f"confirmed if the interval is above -{_WIDE}, refuted if it is wholly below", _no_less
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


def _difference(name: str, statement: str, a: Entry, b: Entry, rule: Rule) -> Hypothesis:
    return Hypothesis(name, statement, ((1, a), (-1, b)), rule)


def _of_case(case: str) -> list[Hypothesis]:
    where = CASES[case]
    initial, noise, rf, both = (
        Entry(policy, case) for policy in ("tp-gmm", "tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise")
    )
    return [
        _difference(f"rf_helps_{case}", f"RF helps, {where}", rf, initial, MORE),
        _difference(f"rf_noise_helps_{case}", f"RF+noise helps, {where}", both, initial, MORE),
        _difference(
            f"noise_does_not_help_{case}",
            f"Noise alone overfits: it does not help in new situations, {where}",
            noise,
            initial,
            NOT_MORE,
        ),
        _difference(
            f"rf_beats_noise_{case}",
            f"RF generalises better than Noise alone, {where}",
            rf,
            noise,
            MORE,
        ),
        _difference(
            f"rf_noise_beats_noise_{case}",
            f"RF+noise generalises better than Noise alone, {where}",
            both,
            noise,
            MORE,
        ),
        _difference(
            f"rf_like_rf_noise_{case}", f"RF and RF+noise perform alike, {where}", rf, both, ALIKE
        ),
    ]


def _between_cases(name: str, policy: str) -> list[Hypothesis]:
    a, b = Entry(policy, "case_a"), Entry(policy, "case_b")
    initial_a, initial_b = Entry("tp-gmm", "case_a"), Entry("tp-gmm", "case_b")
    key = policy.removeprefix("tp-gmm-").replace("-", "_")
    return [
        Hypothesis(
            f"case_a_gains_more_{key}",
            f"case A gains more from {name} than case B",
            ((1, a), (-1, initial_a), (-1, b), (1, initial_b)),
            MORE,
        ),
        _difference(
            f"case_a_ends_better_{key}", f"with {name}, case A outperforms case B", a, b, MORE
        ),
    ]


#: The claims about weighted sums of success rates.
HYPOTHESES: tuple[Hypothesis, ...] = (
    *_of_case("case_a"),
    *_of_case("case_b"),
    *_between_cases("RF", "tp-gmm-rf"),
    *_between_cases("RF+noise", "tp-gmm-rf-noise"),
)

#: Two demonstrations and synthetic ones: who may match the baseline.
AUGMENTED: tuple[Entry, ...] = tuple(
    Entry(policy, case)
    for case in CASES
    for policy in ("tp-gmm-noise", "tp-gmm-rf", "tp-gmm-rf-noise")
)


def next_to_paper(rows: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """Our success rates next to the paper's, as cells of text, the first row the heading.

    Args:
        rows: Rows of ``summary.json``; those under variation are left out.

    Returns:
        The heading, then one row each of ours; where the paper has none, its cells are "-". The
        heading alone where no row is in the paper's table.
    """
    cells = [["policy", "shown", "ours", "95 % interval", "the paper's", "95 % interval"]]
    nominal = [row for row in rows if not row.get("variation")]
    if not any(_key(row) in PAPER_TABLE for row in nominal):
        return cells
    for row in nominal:
        ours = _cells(row["n_success"], row["n_episodes"])
        printed = PAPER_TABLE.get(_key(row))
        theirs = _cells(*printed) if printed else ["-", "-"]
        cells.append([row["policy"], row["demonstrations"] or "-", *ours, *theirs])
    return cells


def _key(row: Mapping[str, Any]) -> tuple[str, str]:
    return row["policy"], row["demonstrations"] or ""


def _cells(successes: int, trials: int) -> list[str]:
    low, high = wilson_interval(successes, trials)
    return [_rate(successes, trials), f"{100.0 * low:.0f} - {100.0 * high:.0f} %"]


def _rate(successes: int, trials: int) -> str:
    return f"{100.0 * successes / trials:.3g} % ({successes} / {trials})" if trials else "-"
