"""The pairs of rows of a table that matter, each compared over the same postures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from dressing_sim.benchmark.analysis.statistics import Row, compare
from dressing_sim.benchmark.records import Entry
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.hyperparameters import split_name

if TYPE_CHECKING:
    from dressing_sim.benchmark.records import EpisodeResult

#: The policy without synthetic demonstrations; the names of augmented ones begin with it.
INITIAL = "tp-gmm"

#: What seven expert demonstrations are called: as a suite, or as the last step of a budget.
BASELINES = ("baseline7", "baseline7:7")


def rows_by_entry(results: Sequence[EpisodeResult]) -> dict[Entry, Row]:
    """Success by demonstration set and posture of each row, None where void.

    Raises:
        InvalidInputError: A row has two episodes with the same posture and set.
    """
    rows: dict[Entry, dict[tuple[int, str], bool | None]] = {}
    for result in results:
        row = rows.setdefault(result.entry, {})
        key = result.demonstration_set, result.posture.name
        if key in row:
            raise InvalidInputError(
                f"row {label(result.entry)}: posture {key[1]!r} with demonstration set {key[0]} "
                "occurs twice; valid is once"
            )
        row[key] = None if result.outcome.invalid is not None else bool(result.outcome.success)
    return dict(rows)


def label(entry: Entry) -> str:
    """A row in words."""
    shown = f" on {entry.demonstrations}" if entry.demonstrations else ""
    varied = f", {' and '.join(entry.variation)} varied" if entry.variation else ""
    return f"{entry.policy}{shown}{varied}"


def label_of(row: Mapping[str, Any]) -> str:
    """A row of a summary, or a side of a comparison, in words."""
    return label(Entry(row["policy"], row["demonstrations"], tuple(row["variation"])))


def comparisons(results: Sequence[EpisodeResult], rng: np.random.Generator) -> list[dict[str, Any]]:
    """Compare the pairs of rows that matter.

    Kinds: ``augmentation`` (augmented against the initial policy, same demonstrations),
    ``policy`` (any other policy against the initial one, same demonstrations),
    ``baseline`` (against seven demonstrations), ``case`` (case A against case B), all four under
    the same variation; ``variation`` (a row under variation against the same row without);
    ``settings`` (a policy with settings after a ``?`` against the same row without).

    Args:
        results: Episodes of a protocol.
        rng: Source of randomness. One number is drawn of it, from which every interval starts
            anew: no comparison depends on which others there are.

    Returns:
        ``{"kind", "a": {"policy", "demonstrations", "variation"}, "b": {...}}`` and what
        `Paired.to_dict` holds, of a less b.
    """
    rows = rows_by_entry(results)
    seed = int(rng.integers(2**32))
    return [
        {
            "kind": kind,
            "a": a.to_dict(),
            "b": b.to_dict(),
            **compare(rows[a], rows[b], np.random.default_rng(seed)).to_dict(),
        }
        for kind, a, b in _pairs(list(rows))
    ]


def _pairs(entries: Sequence[Entry]) -> Iterator[tuple[str, Entry, Entry]]:
    for kind, augmented in (("augmentation", True), ("policy", False)):
        for a in entries:
            initial = _initial(a)
            if a == initial or initial not in entries or a.demonstrations is None:
                continue
            if a.policy.startswith(f"{INITIAL}-") == augmented:
                yield kind, a, initial
    for a in entries:
        initial = _initial(a)
        known = [replace(initial, demonstrations=name) for name in BASELINES]
        baseline = next((b for b in known if b in entries), None)
        # A policy on the baseline's demonstrations has been compared with it above.
        if baseline is not None and baseline != initial:
            yield "baseline", a, baseline
    for a in entries:
        other = replace(a, demonstrations="case_b")
        if a.demonstrations == "case_a" and other in entries:
            yield "case", a, other
    for a in entries:
        nominal = replace(a, variation=())
        if a.variation and nominal in entries:
            yield "variation", a, nominal
    for a in entries:
        stem, settings = split_name(a.policy)
        chosen = replace(a, policy=stem)
        if settings is not None and chosen in entries:
            yield "settings", a, chosen


def _initial(entry: Entry) -> Entry:
    """The row without augmentation: same demonstrations, variation and settings after a ``?``."""
    _, settings = split_name(entry.policy)
    return replace(entry, policy=INITIAL if settings is None else f"{INITIAL}?{settings}")
