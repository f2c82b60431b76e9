"""The pairs of rows of a table that matter, each compared over the same postures."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.statistics import compare, holm
from dressing_sim.benchmark.records import Entry
from dressing_sim.policies.hyperparameters import split_name
from dressing_sim.policies.registry import DEFAULT

#: The policy without synthetic demonstrations; the names of augmented ones begin with it.
INITIAL = "tp-gmm"

#: What seven expert demonstrations are called: as a suite, or as the last step of a budget.
BASELINES = ("baseline7", "baseline7:7")


def label_of(row: Mapping[str, Any]) -> str:
    """A row of a summary, or a side of a comparison, in words."""
    return Entry.of(row).label


def comparisons(episodes: EpisodeTable, rng: np.random.Generator) -> list[dict[str, Any]]:
    """Compare the pairs of rows that matter.

    Kinds: ``augmentation`` (augmented against the initial policy, same demonstrations),
    ``policy`` (any other policy against the initial one, same demonstrations),
    ``baseline`` (against seven demonstrations), ``case`` (case A against case B), all four under
    the same variation, tuned rows with tuned ones; ``variation`` (a row under variation against the
    same row without); ``settings`` (a policy with hyper-parameters after a ``?`` against the same
    row without); ``tuning`` (a tuned row against the same as published); ``style`` (learned from
    an operator of another style against the usual one); ``default`` (any other policy against the
    package's own, same demonstrations and variation), with ``p_holm`` besides, the p-value
    corrected for how many policies are held against it.

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
    found: list[dict[str, Any]] = [
        {
            "kind": kind,
            "a": a.to_dict(),
            "b": b.to_dict(),
            **compare(rows[a], rows[b], np.random.default_rng(seed)).to_dict(),
        }
        for kind, partner in _PARTNERS.items()
        for a in rows
        if (b := partner(a, rows)) in rows and b != a
    ]
    family = [pair for pair in found if pair["kind"] == "default"]
    for pair, p in zip(family, holm([pair["p_mcnemar"] for pair in family]), strict=True):
        pair["p_holm"] = p
    return found


def _initial(entry: Entry) -> Entry:
    """The row without augmentation: same demonstrations, variation and hyper-parameters.

    Of a tuned policy it is the tuned one. What is no policy of the paper has no such partner of its
    own and meets the paper's, tuned or not as it is itself.
    """
    plain = replace(entry, policy=f"{INITIAL}{entry.policy.removeprefix(entry.stem)}")
    return plain if entry.untuned == entry else plain.tuned


def _same_demonstrations(entry: Entry, augmented: bool) -> Entry:
    wanted = entry.untuned.policy.startswith(f"{INITIAL}-") == augmented
    return _initial(entry) if wanted and entry.demonstrations is not None else entry


def _baseline(entry: Entry, rows: Collection[Entry]) -> Entry:
    initial = _initial(entry)
    known = [replace(initial, demonstrations=name) for name in BASELINES]
    baseline = next((one for one in known if one in rows), entry)
    # A policy on the baseline's demonstrations is compared with it already.
    return entry if baseline == initial else baseline


def _other_case(entry: Entry) -> Entry:
    return replace(entry, demonstrations="case_b") if entry.demonstrations == "case_a" else entry


def _usual_operator(entry: Entry) -> Entry:
    suite = split_name(entry.demonstrations)[0] if entry.demonstrations else None
    return replace(entry, demonstrations=suite)


#: What a row is compared with, itself if with nothing, by kind.
_PARTNERS: Mapping[str, Callable[[Entry, Collection[Entry]], Entry]] = {
    "augmentation": lambda entry, _: _same_demonstrations(entry, augmented=True),
    "policy": lambda entry, _: _same_demonstrations(entry, augmented=False),
    "baseline": _baseline,
    "case": lambda entry, _: _other_case(entry),
    "variation": lambda entry, _: replace(entry, variation=()),
    "settings": lambda entry, _: replace(entry, policy=entry.stem),
    "tuning": lambda entry, _: entry.untuned,
    "style": lambda entry, _: _usual_operator(entry),
    "default": lambda entry, _: replace(entry, policy=DEFAULT),
}
