"""The report of practice."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from dressing_sim.benchmark.report import plots
from dressing_sim.benchmark.report.document import Code, Document, Paragraph, Plot, Section, Table
from dressing_sim.benchmark.studies.columns import Column, table_of

#: What stands of each try.
TRIES: Mapping[str, Column] = {
    "policy": "{policy}",
    "dressed": "{n_success} / {n_episodes}",
    "mean margin": "{margin:.3f}",
}

NOTE = (
    "The margin of an episode is its smallest of pull, strain and reach, as shares of their "
    "limits, from -1 to 1; -1 where it failed by something else. Both rows are on the arms of "
    "practice: what they are worth on others is for a suite to tell."
)


def practice_document(found: Mapping[str, Any], command: str) -> Document:
    """The report; what was found is as from `dressing_sim.benchmark.studies.practice.practise`."""
    what = found["practice"]
    told = (
        f"`{found['policy']}` practised on {what['postures']} arms with {found['n_episodes']} "
        f"simulated episodes, having learned from {what['demonstrations']}. Practised:"
    )
    rows = [found["before"], found["after"]]
    return Document(
        f"Practice of {found['policy']}",
        command,
        (Paragraph(told), Code(found["chosen"])),
        (
            Section("Before and after", (Table(table_of(TRIES, rows)), Paragraph(NOTE))),
            Section("Generations", (_curves(found),)),
        ),
    )


def _curves(found: Mapping[str, Any]) -> Plot:
    generations, before = found["generations"], found["before"]["margin"]
    numbers = range(1, len(generations) + 1)
    with plots.figure(2.4) as drawn:
        axes = drawn.subplots()
        for name, style in (("best", plots.STYLES[1]), ("mean", plots.STYLES[2])):
            values = [one[name] for one in generations]
            axes.plot(
                numbers, values, ms=3.0, lw=1.0, label=f"{name} of a generation", **style.look
            )
        axes.axhline(before, color=plots.QUIET, ls=":", lw=1.0, label="before practice")
        axes.set(xlabel="generation", ylabel="mean margin", xlim=(0.5, len(generations) + 0.5))
        plots.legend_above(drawn, axes.get_legend_handles_labels()[0], 3)
        svg = plots.svg_of(drawn)
    last = generations[-1]
    alt = (
        f"Mean margin before practice {before:.3f}; in the last of {len(generations)} generations "
        f"the best {last['best']:.3f}, the mean {last['mean']:.3f}"
    )
    return Plot("generations", svg, alt)
