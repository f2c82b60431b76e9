"""The report of a search for hyper-parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import (
    Cells,
    Code,
    Document,
    Paragraph,
    Plot,
    Section,
    Table,
)
from dressing_sim.benchmark.studies.columns import Column, table_of

_COLUMNS: Mapping[str, Column] = {
    "hyper-parameters": lambda trial: trial["policy"].partition("?")[2] or "as it is",
    "dressed": "{n_success} / {n_episodes}",
    "score": "{score:.3f}",
    "rung": "{rung}",
}

#: How many of the best trials the report shows; the others are in ``summary.json``.
_SHOWN = 12


def trials_table(found: Mapping[str, Any], most: int = _SHOWN) -> Cells:
    """The best trials, those that got furthest first, and the policy as it is after them."""
    trials = sorted(found["trials"], key=lambda trial: (-trial["rung"], -trial["score"]))
    as_it_is = [trial for trial in trials[most:] if trial["policy"] == found["policy"]]
    return table_of(_COLUMNS, [*trials[:most], *as_it_is])


def search_document(found: Mapping[str, Any], command: str) -> Document:
    """The report; what was found is as from `dressing_sim.benchmark.studies.search.search`."""
    what, trials = found["search"], found["trials"]
    rungs = ", ".join(map(str, what["postures"]))
    screened = (
        f"{len(what['screened'])} trials of `{found['policy']}` drew paths on `val50`, without "
        f"physics; the best {len(trials)} of them, the policy as it is among them, dressed: "
        if what["screened"]
        else f"{len(trials)} trials of `{found['policy']}`, "
    )
    told = (
        f"{screened}{found['n_episodes']} episodes on {', '.join(what['cases'])} and the first "
        f"{rungs} postures of `val50`; the best quarter of each rung goes on to the next. Best:"
    )
    note = (
        "The score of an episode is a half for success and a half for its smallest margin of "
        "pull, strain and reach, as shares of their limits. The curve is of the first rung, in "
        "which all trials are; the first trial is the policy as it is."
    )
    return Document(
        f"Hyper-parameters of {found['policy']}",
        command,
        (Paragraph(told), Code(found["chosen"])),
        (
            Section("The best trials", (Table(trials_table(found)), Paragraph(note))),
            Section("The best so far", (_curve(found),)),
        ),
    )


def _curve(found: Mapping[str, Any]) -> Plot:
    best = found["best_so_far"]
    with plots.figure(2.4) as drawn:
        axes = drawn.subplots()
        axes.step(range(1, len(best) + 1), best, where="post", color=plots.STYLES[0].colour)
        axes.set(xlabel="trials", ylabel="best score", xlim=(1, max(2, len(best))))
        svg = plots.svg_of(drawn)
    return Plot("best", svg, f"The best score rises from {best[0]:.3f} to {best[-1]:.3f}")
