"""The paper's table of success rates, and ours next to it.

Source: Zhu, Gienger and Kober (2022), Section V, "Success Rate of robot experiments".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from dressing_sim.benchmark.analysis.statistics import wilson_interval

#: (policy, demonstrations) -> successes, trials: five postures, each tried once.
PAPER_TABLE: Mapping[tuple[str, str], tuple[int, int]] = {
    ("tp-gmm", "case_a"): (1, 5),
    ("tp-gmm-rf", "case_a"): (4, 5),
    ("tp-gmm-rf-noise", "case_a"): (3, 5),
    ("tp-gmm", "case_b"): (1, 5),
    ("tp-gmm-rf", "case_b"): (3, 5),
    ("tp-gmm-rf-noise", "case_b"): (2, 5),
    ("tp-gmm", "baseline7"): (4, 5),
}


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
