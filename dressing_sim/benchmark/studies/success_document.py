"""The report of a run of episodes."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.failures import HardPosture, hardest
from dressing_sim.benchmark.records import EpisodeResult, Failure, Protocol, first_failure
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
    tabulate,
)
from dressing_sim.benchmark.studies import success_plots as plots
from dressing_sim.benchmark.studies import success_tables as tables
from dressing_sim.benchmark.studies.protocols import PROTOCOLS
from dressing_sim.benchmark.studies.success_changes import (
    HYPERPARAMETERS,
    STYLE,
    VARIATION,
    Change,
    side_by_side,
)
from dressing_sim.benchmark.studies.success_films import Films, films_section
from dressing_sim.benchmark.studies.success_map import failure_map
from dressing_sim.benchmark.studies.success_tables import Summary
from dressing_sim.policies.registry import EXPERT
from dressing_sim.world.robot import PANDA

#: Policies that a title may name.
_FEW = 3

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
    "tuning": "tuned, less as published",
    "style": "shown by an operator of another style, less shown by the usual one",
    "default": "less the default policy, shown the same demonstrations",
}


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
    films: Films | None = None,
) -> Document:
    """The report; the same arguments make the same report.

    Args:
        folder: Where the run is, as it was given, for the commands that replay an episode.
        protocol: What was measured.
        results: Its episodes, in any order.
        summary: As from `dressing_sim.benchmark.studies.success_summary.summarise`.
        command: What was typed to get it.
        pictures: Of the hardest postures.
        films: Of typical failures, if they are wanted.
    """
    episodes = EpisodeTable.of(results)
    listed, cells = tables.listing(episodes)
    sections = (
        Section("How often the arm was dressed", tuple(_rates(protocol, summary))),
        Section(
            "Success against the number of demonstrations",
            tuple(filter(None, [plots.budget_plot(protocol, episodes)])),
        ),
        *(_change(summary, change) for change in (HYPERPARAMETERS, VARIATION, STYLE)),
        Section("The paper's claims", tuple(_claims(summary))),
        Section("Methods by rank", tuple(_ranks(summary))),
        Section("Pairs of rows, posture by posture", tuple(_comparisons(summary))),
        Section("What went wrong first", tuple(_failures(protocol, episodes, summary))),
        films_section(folder, protocol, episodes, films),
        Section("Success against the bend of the elbow", (plots.elbow_plot(protocol, episodes),)),
        Section(
            "Where the arm was dressed, and where not",
            tuple(filter(None, [failure_map(protocol, episodes)])),
        ),
        Section(
            "Success against friction",
            tuple(filter(None, [plots.friction_plot(protocol, episodes)])),
        ),
        Section("The hardest postures", tuple(_hardest(folder, episodes, pictures or Pictures()))),
        _folded("Policies that gave no answer", tables.unanswered_table(episodes)),
        _folded("Success by demonstration set", tables.sets_table(summary)),
        _folded("Void episodes, counted neither way", tables.void_table(episodes)),
        Section(listed, (Table(cells),), folded=True),
        config_section(summary),
    )
    return Document(
        f"{_what(protocol)} on suite {protocol.suite}",
        command,
        tuple(_lead(protocol, summary)),
        tuple(section for section in sections if section.blocks),
    )


def _what(protocol: Protocol) -> str:
    """The protocol, or the policies that were put in place of its rows."""
    stems = list(dict.fromkeys(entry.stem for entry in protocol.entries))
    known = PROTOCOLS.get(protocol.name, protocol)
    if known.entries == protocol.entries or len(stems) > _FEW:
        return f"Protocol {protocol.name}"
    return " and ".join(stems)


def _lead(protocol: Protocol, summary: Summary) -> Iterator[Block]:
    yield Paragraph(headline(protocol, summary))
    yield Table(tables.table(summary))
    if robots := sorted({row["robot"] for row in summary["rows"] if "robot" in row}):
        yield Paragraph(
            f"The robot is {', '.join(robots)}, in the run's own demonstrations too. Suites, "
            f"operator and policies were made for the Panda's reach and hand.{_grip(summary)}"
        )
    mixed = [label_of(row) for row in summary["rows"] if row.get("mixed_code")]
    if mixed:
        yield Paragraph(
            f"Made with more than one version of the code: {', '.join(mixed)}. What changed, and "
            f"after how many episodes, stands in summary.json under provenance."
        )
    beside = tables.next_to_paper(summary["rows"])
    if protocol.name == "paper" and len(beside) > 1:
        yield Table(
            beside,
            "Next to the paper's table, whose trials were made with a real robot, on postures of "
            "its own.",
        )


def _grip(summary: Summary) -> str:
    """How hard the robot holds, and who says so."""
    world = summary["config"]["episode"]["world"]
    source = world["robot"].get("grip_source", PANDA.grip_source)
    return f" Its grip holds {world['grip_strength']:g} N ({source})."


def headline(protocol: Protocol, summary: Summary) -> str:
    """The result in two sentences: the best rows that learned, and the expert's.

    Of the rows in the nominal world, if there are any.
    """
    labels = [entry.label for entry in protocol.entries]
    every = [
        (label, row)
        for label, row in zip(labels, summary["rows"], strict=True)
        if row["pc_success"] is not None
    ]
    rows = [(label, row) for label, row in every if not row["variation"]] or every
    learned = [(label, row) for label, row in rows if row["demonstrations"] is not None]
    most = max((row["pc_success"] for _, row in learned), default=None)
    best = [(label, row) for label, row in learned if row["pc_success"] == most]
    sentences = []
    if most == 0.0:
        sentences.append("No policy that learned dressed an arm.")
    elif len(best) == 1:
        label, row = best[0]
        sentences.append(f"Of the policies that learned, {label} did best: {_dressed(row)}.")
    elif best:
        *others, last = (label for label, _ in best)
        names = "all" if len(best) == len(learned) else f"{', '.join(others)} and {last}"
        sentences.append(
            f"Of the policies that learned, {names} did equally well: {percent(most)} dressed."
        )
    sentences += [
        f"The {label}, who sees the whole arm, dressed {_dressed(row)}."
        for label, row in rows
        if row["policy"] == EXPERT
    ]
    return " ".join(sentences) or "No episode could be judged."


def _dressed(row: Summary) -> str:
    low, high = plots.interval(row)
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
    yield plots.rates_plot(summary)


def _change(summary: Summary, change: Change) -> Section:
    cells = side_by_side(summary, change)
    return Section(change.title, (Table(cells), Paragraph(change.rule)) if cells else ())


def _claims(summary: Summary) -> Iterator[Block]:
    found = [claim["verdict"] for claim in summary["claims"]]
    if found:
        counts = [f"{found.count(v)} {v}" for v in ("confirmed", "refuted", "undecided")]
        yield Paragraph(
            f"{', '.join(counts)}. The 95 % interval decides, not the estimate; where it does not, "
            "the claim is undecided."
        )
        yield Table(tabulate(summary["claims"], tables.CLAIMS))


def _ranks(summary: Summary) -> Iterator[Block]:
    if found := summary.get("ranks"):
        yield Paragraph(
            "Methods by their success over the demonstrations that most of them learned from, "
            "equals with the mean of their places. Intervals: demonstration sets are drawn anew, "
            "and episodes within them, the same for all methods."
        )
        yield plots.ranks_plot(found)
        yield Table(tabulate(found, tables.RANKS))


def _comparisons(summary: Summary) -> Iterator[Block]:
    if summary["comparisons"]:
        yield Paragraph(
            "Difference of success rates over the same postures and demonstration sets, in "
            "percentage points, with its bootstrap interval; p of McNemar's exact test, and, where "
            "many are held against one, corrected for their number (Holm); P(better) is the "
            "probability of improvement, in which a tie counts half."
        )
    for kind, group in groupby(summary["comparisons"], key=lambda pair: pair["kind"]):
        pairs, name = list(group), f"First {COMPARISONS.get(kind, 'less second')}"
        yield Paragraph(f"{name}:")
        yield Table(tabulate(pairs, tables.PAIRS, optional=tables.PAIRS_OPTIONAL))
        yield plots.differences_plot(pairs, f"differences-{kind}", f"{name}, with 95 % intervals.")


def _failures(protocol: Protocol, episodes: EpisodeTable, summary: Summary) -> Iterator[Block]:
    if not any(row["failures"] for row in summary["rows"]):
        yield Paragraph("No episode failed.")
        return
    yield Paragraph(
        "Each failed episode is counted once, by the reason that came first in time; a "
        "sleeve that was caught counts as `stuck`, not as the limit that stopped the robot."
    )
    yield plots.failures_plot(protocol, episodes)
    yield Paragraph("All reasons, of which an episode can have several:")
    yield Table(tables.reasons_table(summary))


def _hardest(folder: Path, episodes: EpisodeTable, pictures: Pictures) -> Iterator[Block]:
    def replay(result: EpisodeResult) -> str:
        return f"dressing-sim replay {shlex.quote(str(folder))} {result.index} --video film.mp4"

    found = hardest(episodes)
    if found:
        told = (
            "with a failed episode as it was when the first thing went wrong."
            if pictures.png
            else f"{pictures.missing}."
        )
        yield Paragraph(f"Those that the largest part of the rows failed to dress; {told}")
        yield Table(tables.hardest_table(found, replay))
        yield Cards(tuple(_card(hard, pictures) for hard in found))


def _card(hard: HardPosture, pictures: Pictures) -> Section:
    result = hard.pictured
    posture, row, png = result.posture, result.entry.label, pictures.png.get(result.index)
    failures = tuple(map(_failure, result.outcome.failures))
    first = first_failure(result.outcome)
    time = None if first is None else first.time
    moment = "at the start" if time is None else f"after {time:.1f} s"
    blocks: list[Block] = []
    if png is not None:
        alt = f"{row} dressing {posture.name}, {moment}: {'; '.join(failures)}"
        blocks.append(Picture(f"episode{result.index}", png, alt))
    elif pictures.png:
        blocks.append(Paragraph("No picture: this episode does not come out as it was recorded."))
    blocks += [
        Paragraph(
            f"Elbow bent by {posture.elbow_deg:.0f} deg; shoulder {posture.flexion_deg:.0f} deg "
            f"flexed, {posture.abduction_deg:.0f} deg abducted, {posture.rotation_deg:.0f} deg "
            f"rotated; {posture.size_name} arm."
        ),
        Paragraph(f"{row}{f', pictured {moment}' if png is not None else ''}:"),
        Items(failures),
        Paragraph("Failed episodes:"),
        Items(
            tuple(
                f"{failed.index}: {failed.entry.label}: {', '.join(failed.outcome.reasons)}"
                for failed in hard.failed
            )
        ),
    ]
    title = f"{posture.name}: {len(hard.failed)} of {hard.n_episodes} failed"
    return Section(title, tuple(blocks))


def _failure(failure: Failure) -> str:
    when = "" if failure.time is None else f" at {failure.time:.1f} s"
    return f"{failure.reason}{when}: {failure.detail}"


def _folded(title: str, cells: Cells) -> Section:
    return Section(title, (Table(cells),) if len(cells) > 1 else (), folded=True)
