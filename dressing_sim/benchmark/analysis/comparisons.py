"""The pairs of rows of a table that matter, each compared over the same postures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.statistics import compare
from dressing_sim.benchmark.records import Entry

#: The policy without synthetic demonstrations; the names of augmented ones begin with it.
INITIAL = "tp-gmm"

#: What seven expert demonstrations are called: as a suite, or as the last step of a budget.
BASELINES = ("baseline7", "baseline7:7")


def label_of(row: Mapping[str, Any]) -> str:
    """A row of a summary, or a side of a comparison, in words."""
    return Entry(row["policy"], row["demonstrations"], tuple(row["variation"])).label


def comparisons(episodes: EpisodeTable, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Compare the pairs of rows that matter.

    Kinds: ``augmentation`` (augmented against the initial policy, same demonstrations),
    ``policy`` (any other policy against the initial one, same demonstrations),
    ``baseline`` (against seven demonstrations), ``case`` (case A against case B), all four under
    the same variation; ``variation`` (a row under variation against the same row without);
    ``settings`` (a policy with hyper-parameters after a ``?`` against the same row without).

    Args:
        episodes: Those of a protocol.
        rng: Source of randomness. One number is drawn of it, from which every interval starts
            anew: no comparison depends on which others there are.

    Returns:
        ``{"kind", "a": {"policy", "demonstrations", "variation"}, "b": {...}}`` and what
        `Paired.to_dict` holds, of a less b.
    """
    rows = episodes.rows
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
        chosen = replace(a, policy=a.stem)
        if a != chosen and chosen in entries:
            yield "settings", a, chosen


def _initial(entry: Entry) -> Entry:
    """The row without augmentation: same demonstrations, variation and hyper-parameters."""
    return replace(entry, policy=f"{INITIAL}{entry.policy.removeprefix(entry.stem)}")
