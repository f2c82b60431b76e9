"""Tables of a run of episodes: its summary, and the episodes themselves, as cells of text."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias, TypeVar

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.analysis.failures import HardPosture
from dressing_sim.benchmark.analysis.hypotheses import PAPER_TABLE
from dressing_sim.benchmark.records import Entry, EpisodeResult, in_order
from dressing_sim.benchmark.report.document import Cells, Column, percent, tabulate
from dressing_sim.episode.metrics import METRICS
from dressing_sim.episode.rules import UNANSWERED

#: With more episodes than this a report lists postures instead.
MOST_EPISODES_LISTED = 60

#: A row or a comparison of ``summary.json``, or all of it.
Summary: TypeAlias = Mapping[str, Any]

T = TypeVar("T")


def _named(entry_of: Callable[[T], Entry]) -> list[Column[T]]:
    """What says which row of the protocol something is of."""
    return [
        ("policy", lambda one: entry_of(one).policy),
        ("shown", lambda one: entry_of(one).demonstrations or "-"),
        ("varied", lambda one: ", ".join(entry_of(one).variation) or "-"),
    ]


def _entry(result: EpisodeResult) -> Entry:
    return result.entry


_ROWS: list[Column[Summary]] = [
    *_named(Entry.of),
    ("robot", lambda row: row.get("robot", "-")),
    ("success", lambda row: _success(row)),
    ("rate", lambda row: percent(row["pc_success"])),
    ("95 % interval", lambda row: between(row["pc_success_ci95"])),
    ("over sets", lambda row: between(row.get("pc_success_ci95_sets"))),
    ("abstained", lambda row: _abstained(row)),
    ("what went wrong", lambda row: _wrong(row["failures"], row["n_void"])),
]

#: Of comparisons.
PAIRS: list[Column[Summary]] = [
    ("first", lambda pair: label_of(pair["a"])),
    ("second", lambda pair: label_of(pair["b"])),
    ("pairs", lambda pair: str(pair["n_pairs"])),
    ("only first", lambda pair: str(pair["n_only_a"])),
    ("only second", lambda pair: str(pair["n_only_b"])),
    ("difference", lambda pair: number(pair["pc_difference"], "+.3g")),
    ("95 % interval", lambda pair: signed_interval(pair)),
    ("p", lambda pair: f"{pair['p_mcnemar']:.3f}"),
    ("p (Holm)", lambda pair: number(pair.get("p_holm"), ".3f")),
    ("P(better)", lambda pair: number(pair["probability_of_improvement"], ".2f")),
]

#: Columns of `PAIRS` that are left out where nothing is in them.
PAIRS_OPTIONAL = ("p (Holm)",)

#: Of methods by rank.
RANKS: list[Column[Summary]] = [
    ("rank", lambda one: f"{one['rank']:g}"),
    ("95 % interval", lambda one: "{:g} - {:g}".format(*one["rank_ci95"])),
    ("policy", lambda one: one["policy"]),
    ("rate", lambda one: percent(one["pc_success"])),
]

#: Of the paper's claims with their verdicts.
CLAIMS: list[Column[Summary]] = [
    ("claim", lambda claim: claim["statement"]),
    ("verdict", lambda claim: f"**{claim['verdict']}**"),
    ("numbers", lambda claim: claim["detail"]),
]

_EPISODES: list[Column[EpisodeResult]] = [
    ("episode", lambda result: str(result.index)),
    *_named(_entry),
    ("posture", lambda result: result.posture.name),
    ("elbow", lambda result: _elbow(result)),
    ("outcome", lambda result: result.outcome.verdict),
    ("armscye s", lambda result: _metric(result, "armscye_s")),
    ("strain", lambda result: _metric(result, "strain")),
    ("pull", lambda result: _metric(result, "grip_force")),
]

_POSTURES: list[Column[EpisodeTable]] = [
    ("posture", lambda group: group.results[0].posture.name),
    ("elbow", lambda group: _elbow(group.results[0])),
    ("dressed", lambda group: f"{group.rate.n_success} / {group.rate.n}"),
    ("what went wrong", lambda group: _wrong(group.reasons, group.rate.n_void)),
]

_VOID: list[Column[EpisodeResult]] = [
    ("episode", lambda result: str(result.index)),
    ("row", lambda result: result.entry.label),
    ("posture", lambda result: result.posture.name),
    ("why", lambda result: result.outcome.invalid or ""),
]


def number(value: float | None, form: str) -> str:
    """A number, or a dash where there is none."""
    return "-" if value is None else f"{value:{form}}"


def between(interval: Sequence[float] | None) -> str:
    """An interval of a rate, in per cent."""
    return "-" if interval is None else f"{interval[0]:.0f} - {interval[1]:.0f} %"


def signed_interval(pair: Summary) -> str:
    """The interval of a difference."""
    low, high = pair["pc_difference_ci95"]
    return f"{low:+.0f} to {high:+.0f}"


def counted(reasons: Mapping[str, int]) -> str:
    """How often each reason occurred, in a line."""
    return ", ".join(f"{reason} {n}" for reason, n in reasons.items())


def _wrong(reasons: Mapping[str, int], n_void: int) -> str:
    void = f"{n_void} void" if n_void else ""
    return ", ".join(filter(None, [counted(reasons), void])) or "-"


def _abstained(row: Summary) -> str:
    """How often, and the rate of the others; the row's own rate is of all."""
    if "n_abstained" not in row:
        return "-"
    interval = between(row["pc_success_attempted_ci95"])
    rate = percent(row["pc_success_attempted"])
    return f"{row['n_abstained']}; of {row['n_attempted']} attempted {rate} ({interval})"


def _success(row: Summary) -> str:
    return f"{row['n_success']} / {row['n_episodes']}"


def _elbow(result: EpisodeResult) -> str:
    return f"{result.posture.elbow_deg:.0f} deg"


def _metric(result: EpisodeResult, name: str) -> str:
    metrics = result.outcome.metrics
    return METRICS[name].text(metrics[name], digits=2) if name in metrics else "-"


def table(summary: Summary) -> Cells:
    """The summary's rows."""
    columns = list(_ROWS)
    # Of who learns nothing it is known that he observes the whole arm.
    learned = [row for row in summary["rows"] if row["demonstrations"] is not None]
    if any(row.get("inputs", "frames") != "frames" for row in learned):
        columns.insert(2, ("inputs", lambda row: row["inputs"]))
    return tabulate(
        summary["rows"], columns, optional=("varied", "robot", "over sets", "abstained")
    )


def printed_rate(row: Summary) -> Rate | None:
    """The rate that the paper prints for a row, if it does."""
    printed = PAPER_TABLE.get((row["policy"], row["demonstrations"] or ""))
    return None if printed is None or row.get("variation") else Rate(*printed)


def next_to_paper(rows: Sequence[Summary]) -> Cells:
    """Our success rates next to the paper's, without rows under variation.

    The heading alone where no row is in the paper's table.
    """

    def ours(row: Summary) -> Rate:
        return Rate(row["n_success"], row["n_episodes"])

    def rates(heading: str, rate: Callable[[Summary], Rate | None]) -> list[Column[Summary]]:
        def interval(row: Summary) -> str:
            found = rate(row)
            return between(None if found is None else found.interval)

        return [(heading, lambda row: _counts(rate(row))), ("95 % interval", interval)]

    nominal = [row for row in rows if not row.get("variation")]
    columns = [*_named(Entry.of)[:2], *rates("ours", ours), *rates("the paper's", printed_rate)]
    return tabulate(nominal if any(map(printed_rate, nominal)) else [], columns)


def _counts(rate: Rate | None) -> str:
    if rate is None or not rate.n:
        return "-"
    return f"{percent(rate.percent)} ({rate.n_success} / {rate.n})"


def reasons_table(summary: Summary) -> Cells:
    """How many episodes of each row failed for each reason; an episode can have several."""
    reasons = in_order({reason for row in summary["rows"] for reason in row["failures"]})

    def count_of(reason: str) -> Column[Summary]:
        return reason, lambda row: str(row["failures"].get(reason, "·"))

    return tabulate(summary["rows"], [("row", label_of), *map(count_of, reasons)])


def sets_table(summary: Summary) -> Cells:
    """Successes by demonstration set; the heading alone where there is one set."""
    rows = [row for row in summary["rows"] if "sets" in row]

    def of_set(i: int) -> Column[Summary]:
        return f"set {i}", lambda row: _success(row["sets"][i])

    sets = range(len(rows[0]["sets"])) if rows else ()
    return tabulate(rows, [*_named(Entry.of), *map(of_set, sets)], optional=("varied",))


def hardest_table(found: Sequence[HardPosture], command: Callable[[EpisodeResult], str]) -> Cells:
    """The hardest postures, and what to type to see one of their failed episodes."""
    columns: list[Column[HardPosture]] = [
        ("posture", lambda hard: hard.pictured.posture.name),
        ("elbow", lambda hard: _elbow(hard.pictured)),
        ("failed", lambda hard: f"{len(hard.failed)} / {hard.n_episodes}"),
        ("to see it", lambda hard: f"`{command(hard.pictured)}`"),
    ]
    return tabulate(found, columns)


def void_table(episodes: EpisodeTable) -> Cells:
    """Episodes that count neither way; the heading alone where there are none."""
    return tabulate(episodes.where(~episodes.valid).results, _VOID)


def unanswered_table(episodes: EpisodeTable) -> Cells:
    """What policies said that gave no answer, by row; the heading alone where all answered."""
    said = Counter(
        (result.entry.label, failure.detail)
        for result in episodes.results
        for failure in result.outcome.failures
        if failure.reason == UNANSWERED.name
    )
    body = [[label, str(n), detail] for (label, detail), n in said.items()]
    return [["row", "episodes", "what happened"], *body]


def listing(episodes: EpisodeTable) -> tuple[str, Cells]:
    """What a report lists, and the list: every episode or, where there are many, every posture."""
    if len(episodes) <= MOST_EPISODES_LISTED:
        return "Episodes", tabulate(episodes.results, _EPISODES, optional=("varied",))
    return "Postures", tabulate(list(episodes.by_posture.values()), _POSTURES)
