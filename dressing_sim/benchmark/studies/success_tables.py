"""Tables of a run of episodes: its summary, and the episodes themselves, as cells of text."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from dressing_sim.benchmark.analysis.comparisons import label_of
from dressing_sim.benchmark.analysis.failures import HardPosture, valid, verdict
from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.report.document import Cells, percent
from dressing_sim.episode.rules import count_reasons, in_order
from dressing_sim.policies.hyperparameters import split_name

#: With more episodes than this a report lists postures instead.
MOST_EPISODES_LISTED = 60

Summary = Mapping[str, Any]


def table(summary: Summary) -> Cells:
    """The summary's rows."""
    varied = any(row["variation"] for row in summary["rows"])
    over_sets = any("pc_success_ci95_sets" in row for row in summary["rows"])
    # Of who learns nothing it is known that he observes the whole arm.
    learned = [row for row in summary["rows"] if row["demonstrations"] is not None]
    classes = any(row.get("inputs", "frames") != "frames" for row in learned)
    heading = [*_heading(varied), "success", "rate", "95 % interval"]
    heading += [*(["over sets"] if over_sets else []), "what went wrong"]
    if classes:
        heading.insert(2, "inputs")
    return [
        heading,
        *(
            [
                *_named(row, varied)[:2],
                *([row["inputs"]] if classes else []),
                *_named(row, varied)[2:],
                f"{row['n_success']} / {row['n_episodes']}",
                percent(row["pc_success"]),
                _between(row["pc_success_ci95"]),
                *([_between(row.get("pc_success_ci95_sets"))] if over_sets else []),
                _wrong(row["failures"], row["n_void"]),
            ]
            for row in summary["rows"]
        ),
    ]


def _heading(varied: bool) -> list[str]:
    return ["policy", "shown", *(["varied"] if varied else [])]


def _named(row: Mapping[str, Any], varied: bool) -> list[str]:
    variation = [", ".join(row["variation"]) or "-"] if varied else []
    return [row["policy"], row["demonstrations"] or "-", *variation]


def _between(interval: Sequence[float] | None) -> str:
    return "-" if interval is None else f"{interval[0]:.0f} - {interval[1]:.0f} %"


def _wrong(reasons: Mapping[str, int], n_void: int) -> str:
    void = f"{n_void} void" if n_void else ""
    return ", ".join(filter(None, [counted(reasons), void])) or "-"


def counted(reasons: Mapping[str, int]) -> str:
    """How often each reason occurred, in a line."""
    return ", ".join(f"{reason} {n}" for reason, n in reasons.items())


def reasons_table(summary: Summary) -> Cells:
    """How many episodes of each row failed for each reason; an episode can have several."""
    rows = summary["rows"]
    reasons = in_order({reason for row in rows for reason in row["failures"]})
    body = [[label_of(r), *(str(r["failures"].get(one, "·")) for one in reasons)] for r in rows]
    return [["row", *reasons], *body]


def claims_table(summary: Summary) -> Cells:
    """The paper's claims with their verdicts."""
    body = [[c["statement"], f"**{c['verdict']}**", c["detail"]] for c in summary["claims"]]
    return [["claim", "verdict", "numbers"], *body]


def sets_table(summary: Summary) -> Cells:
    """Successes by demonstration set; the heading alone where there is one set."""
    rows = [row for row in summary["rows"] if "sets" in row]
    varied = any(row["variation"] for row in rows)
    numbers = range(len(rows[0]["sets"])) if rows else ()
    cells = [[*_heading(varied), *(f"set {i}" for i in numbers)]]
    for row in rows:
        rates = [f"{one['n_success']} / {one['n_episodes']}" for one in row["sets"]]
        cells.append([*_named(row, varied), *rates])
    return cells


def pairs_table(pairs: Sequence[Mapping[str, Any]]) -> Cells:
    """Comparisons of a summary."""
    cells = [["first", "second", "pairs", "only first", "only second", "difference"]]
    cells[0] += ["95 % interval", "p", "P(better)"]
    for pair in pairs:
        low, high = pair["pc_difference_ci95"]
        judged = pair["n_pairs"] > 0
        cells.append(
            [
                label_of(pair["a"]),
                label_of(pair["b"]),
                str(pair["n_pairs"]),
                str(pair["n_only_a"]),
                str(pair["n_only_b"]),
                f"{pair['pc_difference']:+.3g}" if judged else "-",
                f"{low:+.0f} to {high:+.0f}",
                f"{pair['p_mcnemar']:.3f}",
                f"{pair['probability_of_improvement']:.2f}" if judged else "-",
            ]
        )
    return cells


def settings_table(summary: Summary) -> Cells:
    """Rates by the hyper-parameters after a policy's ``?``, or none; see `_side_by_side`."""

    def place(row: Mapping[str, Any]) -> tuple[str, str]:
        stem, chosen = split_name(row["policy"])
        varied = f"{_varied(row)} varied" if row["variation"] else None
        return chosen or "as chosen", _joined(stem, row["demonstrations"], varied)

    return _side_by_side(summary, "settings", ("settings", "as chosen"), place)


def variation_table(summary: Summary) -> Cells:
    """Rates by what is drawn anew for each episode, or none; see `_side_by_side`."""

    def place(row: Mapping[str, Any]) -> tuple[str, str]:
        return _varied(row) or "nothing", _joined(row["policy"], row["demonstrations"])

    return _side_by_side(summary, "variation", ("varied", "nothing"), place)


def _side_by_side(
    summary: Summary,
    kind: str,
    corner: tuple[str, str],
    place: Callable[[Mapping[str, Any]], tuple[str, str]],
) -> Cells:
    """What a change does to each policy: rows with and without it, side by side.

    Below the heading the line of rows without a change, if there are any, then one for each change;
    a column for each policy and its demonstrations, all in the order in which they first appear. A
    cell is a success rate in per cent with, where the row is compared with the one without a
    change, the paired difference to it and its 95 % interval in percentage points; "-" where
    nothing was run, or all of it is void.

    Args:
        summary: As ``summary.json`` holds it.
        kind: Of the comparisons that it shows.
        corner: First words of the heading and of the line without a change.
        place: Line and column of a row.
    """
    heading, unchanged = corner
    compared = {place(pair["a"]): pair for pair in summary["comparisons"] if pair["kind"] == kind}
    filled = {place(row): _rate(row, compared.get(place(row))) for row in summary["rows"]}
    lines = dict.fromkeys([unchanged, *(line for line, _ in filled)])
    columns = dict.fromkeys(column for _, column in filled)
    if len(lines) == 1:
        return []
    return [
        [heading, *columns],
        *(
            [line, *(filled.get((line, column), "-") for column in columns)]
            for line in lines
            if any((line, column) in filled for column in columns)
        ),
    ]


def _varied(row: Mapping[str, Any]) -> str:
    return " and ".join(row["variation"])


def _joined(*parts: str | None) -> str:
    return ", ".join(filter(None, parts))


def _rate(row: Mapping[str, Any], pair: Mapping[str, Any] | None) -> str:
    rate = percent(row["pc_success"])
    if row["pc_success"] is None or pair is None or pair["pc_difference"] is None:
        return rate
    low, high = pair["pc_difference_ci95"]
    return f"{rate} ({pair['pc_difference']:+.3g}, {low:+.0f} to {high:+.0f})"


def hardest_table(found: Sequence[HardPosture], command: Callable[[EpisodeResult], str]) -> Cells:
    """The hardest postures, and what to type to see one of their failed episodes."""
    body = [
        [
            hard.posture.name,
            f"{hard.posture.elbow_deg:.0f} deg",
            f"{len(hard.failed)} / {hard.n_episodes}",
            f"`{command(hard.pictured)}`",
        ]
        for hard in found
    ]
    return [["posture", "elbow", "failed", "to see it"], *body]


def void_table(results: Sequence[EpisodeResult]) -> Cells:
    """Episodes that count neither way; the heading alone where there are none."""
    body = [
        [str(r.index), label_of(r.entry.to_dict()), r.posture.name, r.outcome.invalid]
        for r in results
        if r.outcome.invalid is not None
    ]
    return [["episode", "row", "posture", "why"], *body]


def listing(results: Sequence[EpisodeResult]) -> tuple[str, Cells]:
    """What a report lists: every episode or, where there are many, every posture.

    Args:
        results: Episodes in the order of the protocol.

    Returns:
        What it is a list of, and the list.
    """
    if len(results) <= MOST_EPISODES_LISTED:
        return "Episodes", _episodes(results)
    return "Postures", _postures(results)


def _episodes(results: Sequence[EpisodeResult]) -> Cells:
    varied = any(result.entry.variation for result in results)
    cells = [["episode", *_heading(varied), "posture", "elbow"]]
    cells[0] += ["outcome", "armscye s", "strain", "pull"]
    for result in results:
        outcome = result.outcome
        cells.append(
            [
                str(result.index),
                *_named(result.entry.to_dict(), varied),
                result.posture.name,
                f"{result.posture.elbow_deg:.0f} deg",
                verdict(outcome),
                *(
                    f"{outcome.metrics[name]:.2f}{unit}" if name in outcome.metrics else "-"
                    for name, unit in (("armscye_s", ""), ("strain", ""), ("grip_force", " N"))
                ),
            ]
        )
    return cells


def _postures(results: Sequence[EpisodeResult]) -> Cells:
    groups: dict[str, list[EpisodeResult]] = {}
    for result in results:
        groups.setdefault(result.posture.name, []).append(result)
    cells = [["posture", "elbow", "dressed", "what went wrong"]]
    for name, group in groups.items():
        outcomes = [result.outcome for result in valid(group)]
        cells.append(
            [
                name,
                f"{group[0].posture.elbow_deg:.0f} deg",
                f"{sum(outcome.success for outcome in outcomes)} / {len(outcomes)}",
                _wrong(count_reasons(outcomes), len(group) - len(outcomes)),
            ]
        )
    return cells
