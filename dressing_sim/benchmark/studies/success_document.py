"""The report of a run of episodes."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

from dressing_sim.benchmark.analysis.failures import HardPosture, first_failure, hardest
from dressing_sim.benchmark.analysis.hypotheses import next_to_paper
from dressing_sim.benchmark.records import EpisodeResult, Protocol
from dressing_sim.benchmark.report.document import (
    Block,
    Cards,
    Cells,
    Document,
    Items,
    Paragraph,
    Picture,
    Section,
    Table,
    config_section,
    percent,
)
from dressing_sim.benchmark.studies.success_plots import (
    budget_plot,
    differences_plot,
    elbow_plot,
    failures_plot,
    interval,
    rates_plot,
)
from dressing_sim.benchmark.studies.success_tables import (
    claims_table,
    hardest_table,
    listing,
    pairs_table,
    reasons_table,
    sets_table,
    settings_table,
    table,
    variation_table,
    void_table,
)
from dressing_sim.episode.outcome import Failure
from dressing_sim.policies.registry import EXPERT

Summary = Mapping[str, Any]

SUCCESS_RULE = (
    "Success: the sleeve is on, up to the shoulder; the robot touched nobody; the cloth was "
    "neither stretched nor pulled too far. One episode can fail for several reasons. Intervals of "
    "rates are Wilson's, for the demonstrations that were given; over sets they are bootstrap "
    "intervals for other demonstrations too. Void episodes count neither way."
)

#: What the kinds of comparison are called, see `dressing_sim.benchmark.analysis.comparisons`.
COMPARISONS = {
    "augmentation": "with synthetic demonstrations, less without",
    "policy": "less the paper's initial policy, shown the same demonstrations",
    "baseline": "less the policy that was shown seven demonstrations",
    "case": "shown distinct postures, less shown similar ones",
    "variation": "under variation, less without",
    "settings": "with other settings, less as chosen",
}

_SIDE_BY_SIDE = (
    "in brackets the difference to the same policy {}, over the same postures and demonstration "
    "sets, in percentage points, with its 95 % bootstrap interval."
)


@dataclass(frozen=True, slots=True)
class Pictures:
    """Failed episodes as they were when the first thing went wrong.

    Attributes:
        png: A PNG file each, by the index of the episode.
        missing: Why there are none at all.
    """

    png: Mapping[int, bytes] = field(default_factory=dict)
    missing: str = "pictures left out"


def success_document(
    folder: Path,
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    summary: Summary,
    command: str,
    pictures: Pictures | None = None,
) -> Document:
    """The report; the same arguments make the same report.

    Args:
        folder: Where the run is, as it was given, for the commands that replay an episode.
        protocol: What was measured.
        results: Its episodes, in any order.
        summary: As from `dressing_sim.benchmark.studies.success_summary.summarise`.
        command: What was typed to get it.
        pictures: Of the hardest postures.
    """
    ordered = sorted(results, key=lambda result: result.index)
    listed, cells = listing(ordered)
    return Document(
        f"Protocol {protocol.name} on suite {protocol.suite}",
        command,
        tuple(_lead(protocol, summary)),
        (
            Section("How often the arm was dressed", tuple(_rates(protocol, summary))),
            *_budget(protocol, ordered),
            *_side_by_side(summary),
            *_claims(summary),
            *_comparisons(summary),
            *_failures(protocol, ordered, summary),
            Section("Success against the bend of the elbow", (elbow_plot(protocol, ordered),)),
            *_hardest(folder, ordered, pictures or Pictures()),
            *_folded("Success by demonstration set", sets_table(summary)),
            *_folded("Void episodes, counted neither way", void_table(ordered)),
            Section(listed, (Table(cells),), folded=True),
            config_section(summary),
        ),
    )


def paper_table(protocol: Protocol, summary: Summary) -> Cells:
    """The summary's rows next to the paper's; none unless the protocol, and some row, is its."""
    cells = next_to_paper(summary["rows"])
    return cells if protocol.name == "paper" and len(cells) > 1 else []


def _lead(protocol: Protocol, summary: Summary) -> Iterator[Block]:
    yield Paragraph(headline(protocol, summary))
    yield Table(table(summary))
    beside = paper_table(protocol, summary)
    if beside:
        yield Table(
            beside,
            "Next to the paper's table, whose trials were made with a real robot, on postures of "
            "its own.",
        )


def headline(protocol: Protocol, summary: Summary) -> str:
    """The result in two sentences: the best rows that learned, and the expert's.

    Of the rows in the nominal world, if there are any.
    """
    every = [
        (entry, row)
        for entry, row in zip(protocol.entries, summary["rows"], strict=True)
        if row["pc_success"] is not None
    ]
    nominal = [(entry, row) for entry, row in every if not entry.variation]
    rows = [(entry.label, row) for entry, row in nominal or every]
    learned = [(name, row) for name, row in rows if row["demonstrations"] is not None]
    most = max((row["pc_success"] for _, row in learned), default=None)
    best = [(name, row) for name, row in learned if row["pc_success"] == most]
    sentences = []
    if len(best) == 1:
        name, row = best[0]
        sentences.append(f"Of the policies that learned, {name} did best: {_dressed(row)}.")
    elif best:
        *others, last = (name for name, _ in best)
        names = "all" if len(best) == len(learned) else f"{', '.join(others)} and {last}"
        sentences.append(
            f"Of the policies that learned, {names} did equally well: {percent(most)} dressed."
        )
    sentences += [
        f"The {name}, who sees the whole arm, dressed {_dressed(row)}."
        for name, row in rows
        if row["policy"] == EXPERT
    ]
    return " ".join(sentences) or "No episode could be judged."


def _dressed(row: Mapping[str, Any]) -> str:
    low, high = interval(row)
    return (
        f"{row['n_success']} of {row['n_episodes']} arms ({percent(row['pc_success'])}, "
        f"95 % interval {low:.0f} to {high:.0f} %)"
    )


def _rates(protocol: Protocol, summary: Summary) -> Iterator[Block]:
    yield Paragraph(SUCCESS_RULE)
    if protocol.demonstration_sets > 1:
        yield Paragraph(
            f"With {protocol.demonstration_sets} demonstration sets, each posture is dressed by "
            "the policy that learned from one of them; all rows are paired by posture and set."
        )
    yield rates_plot(summary)


def _budget(protocol: Protocol, results: Sequence[EpisodeResult]) -> Iterator[Section]:
    plot = budget_plot(protocol, results)
    if plot is not None:
        yield Section("Success against the number of demonstrations", (plot,))


def _side_by_side(summary: Summary) -> Iterator[Section]:
    for title, cells, rule in (
        (
            "Settings of policies",
            settings_table(summary),
            "Success rates of policies with settings changed as each line says; "
            + _SIDE_BY_SIDE.format("as chosen"),
        ),
        (
            "Robustness",
            variation_table(summary),
            "Success rates where what each line says is drawn anew for each episode; "
            + _SIDE_BY_SIDE.format("in the nominal world"),
        ),
    ):
        if cells:
            yield Section(title, (Table(cells), Paragraph(rule)))


def _claims(summary: Summary) -> Iterator[Section]:
    claims = summary["claims"]
    if claims:
        found = [claim["verdict"] for claim in claims]
        counts = [f"{found.count(v)} {v}" for v in ("confirmed", "refuted", "undecided")]
        rule = (
            f"{', '.join(counts)}. The 95 % interval decides, not the estimate; where it does not, "
            "the claim is undecided."
        )
        yield Section("The paper's claims", (Paragraph(rule), Table(claims_table(summary))))


def _comparisons(summary: Summary) -> Iterator[Section]:
    blocks: list[Block] = []
    for kind, group in groupby(summary["comparisons"], key=lambda pair: pair["kind"]):
        pairs, name = list(group), f"First {COMPARISONS.get(kind, 'less second')}"
        plot = differences_plot(pairs, f"differences-{kind}", f"{name}, with 95 % intervals.")
        blocks += [Paragraph(f"{name}:"), Table(pairs_table(pairs)), plot]
    if blocks:
        rule = Paragraph(
            "Difference of success rates over the same postures and demonstration sets, in "
            "percentage points, with its bootstrap interval; p of McNemar's exact test; P(better) "
            "is the probability of improvement, in which a tie counts half."
        )
        yield Section("Pairs of rows, posture by posture", (rule, *blocks))


def _failures(
    protocol: Protocol, results: Sequence[EpisodeResult], summary: Summary
) -> Iterator[Section]:
    blocks: list[Block] = [Paragraph("No episode failed.")]
    if any(row["failures"] for row in summary["rows"]):
        blocks = [
            Paragraph(
                "Each failed episode is counted once, by the reason that came first in time; a "
                "sleeve that was caught counts as `stuck`, not as the limit that stopped the robot."
            ),
            failures_plot(protocol, results),
            Table(reasons_table(summary), "All reasons; an episode can have several."),
        ]
    yield Section("What went wrong first", tuple(blocks))


def _hardest(
    folder: Path, results: Sequence[EpisodeResult], pictures: Pictures
) -> Iterator[Section]:
    found = hardest(results)
    if not found:
        return

    def replay(result: EpisodeResult) -> str:
        return f"dressing-sim replay {shlex.quote(str(folder))} {result.index} --video film.mp4"

    told = (
        "with a failed episode as it was when the first thing went wrong."
        if pictures.png
        else f"{pictures.missing}."
    )
    yield Section(
        "The hardest postures",
        (
            Paragraph(f"Those that the largest part of the rows failed to dress; {told}"),
            Table(hardest_table(found, replay)),
            Cards(tuple(_card(hard, pictures) for hard in found)),
        ),
    )


def _card(hard: HardPosture, pictures: Pictures) -> Section:
    posture, outcome = hard.posture, hard.pictured.outcome
    row, png = hard.pictured.entry.label, pictures.png.get(hard.pictured.index)
    failures = tuple(map(_failure, outcome.failures))
    first = first_failure(outcome)
    time = None if first is None else first.time
    moment = "at the start" if time is None else f"after {time:.1f} s"
    blocks: list[Block] = []
    if png is not None:
        alt = f"{row} dressing {posture.name}, {moment}: {'; '.join(failures)}"
        blocks.append(Picture(f"episode{hard.pictured.index}", png, alt))
    elif pictures.png:
        blocks.append(Paragraph("No picture: this episode does not come out as it was recorded."))
    blocks += [
        Paragraph(
            f"Elbow bent by {posture.elbow_deg:.0f} deg; shoulder {posture.flexion_deg:.0f} deg "
            f"flexed, {posture.abduction_deg:.0f} deg abducted, {posture.rotation_deg:.0f} deg "
            f"rotated; {posture.size} arm."
        ),
        Paragraph(f"{row}{f', pictured {moment}' if png is not None else ''}:"),
        Items(failures),
        Paragraph("Failed episodes:"),
        Items(
            tuple(
                f"{result.index}: {result.entry.label}: {', '.join(result.outcome.reasons)}"
                for result in hard.failed
            )
        ),
    ]
    title = f"{posture.name}: {len(hard.failed)} of {hard.n_episodes} failed"
    return Section(title, tuple(blocks))


def _failure(failure: Failure) -> str:
    when = "" if failure.time is None else f" at {failure.time:.1f} s"
    return f"{failure.reason}{when}: {failure.detail}"


def _folded(title: str, cells: Cells) -> Iterator[Section]:
    if len(cells) > 1:
        yield Section(title, (Table(cells),), folded=True)
