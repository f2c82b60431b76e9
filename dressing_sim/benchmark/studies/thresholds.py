"""The study of thresholds: how success rates, and the ranking of rows, hang on each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import permutations
from typing import Any

import numpy as np

from dressing_sim.benchmark.analysis.episodes import EpisodeTable, Rate
from dressing_sim.benchmark.analysis.statistics import Row, compare
from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.plan import Plan, dressing_person, make_plan
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.study import EpisodeStudy, Summary
from dressing_sim.benchmark.studies.thresholds_document import thresholds_document
from dressing_sim.benchmark.studies.thresholds_verdicts import (
    FACTORS,
    NAMES,
    TOLERATED,
    dress_and_judge,
    scaled,
    verdict_of,
)
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.thresholds import Thresholds, threshold_sources, threshold_units
from dressing_sim.policies.registry import EXPERT
from dressing_sim.provenance import versions
from dressing_sim.suites.wardrobe import world_with

PROTOCOL = Protocol(
    "thresholds",
    "val50",
    (
        Entry(EXPERT),
        Entry("tp-gmm", "case_a"),
        Entry("tp-gmm-rf", "case_a"),
        Entry("tp-gmm-rf-noise", "case_a"),
        Entry("tp-gmm", "case_b"),
        Entry("tp-gmm-rf-noise", "case_b"),
        Entry("tp-gmm", "baseline7"),
    ),
    demonstration_sets=5,
    study="thresholds",
)

#: Seed of the bootstrap: the same episodes give the same summary.
_BOOTSTRAP_SEED = 0


def thresholds_plan(
    protocol: Protocol = PROTOCOL,
    seed: int = 0,
    garment: str | None = None,
    person: str | None = None,
) -> Plan:
    """The plan of the study: episodes go on after limits were exceeded.

    Garment and person are names or TOML files, see `load_garment` and `load_person`.
    """
    config = world_with(garment, EpisodeConfig(protective_stop=False))
    return dressing_person(make_plan(protocol, seed, config), person)


@dataclass(frozen=True)
class ThresholdStudy(EpisodeStudy):
    """Each episode is simulated once and judged with one threshold after the other changed."""

    work: Work = field(default_factory=lambda: Work(dress=dress_and_judge))

    def summarise(self, folder: RunFolder, results: Sequence[EpisodeResult]) -> dict[str, Any]:
        """Success rates under every variant of the rules."""
        plan = folder.plan
        config = {"seed": plan.seed, "episode": to_plain(plan.config)}
        return summarise(plan.protocol, results, plan.config.thresholds, config)

    def document(
        self, folder: RunFolder, results: Sequence[EpisodeResult], summary: Summary, command: str
    ) -> Document:
        """A table, and a plot of each threshold."""
        return thresholds_document(summary, command)


def summarise(
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    rules: Thresholds,
    config: Mapping[str, Any],
) -> dict[str, Any]:
    """Success rates under every variant of the rules, and pairs of rows whose order turns.

    A pair turns if one row is above the other with the threshold as it is, and below it with the
    threshold multiplied; beyond their intervals, if the 95 % bootstrap intervals of both
    differences, posture by posture, exclude zero.

    Args:
        protocol: What was measured.
        results: Its episodes, as from `dress_and_judge`, in any order.
        rules: The thresholds they were recorded with.
        config: What else is to be told of the run.

    Returns:
        ``{"factors": [...], "thresholds": [{"name", "value", "unit", "source", "values": [...],
        "rows": [...], "turned": [...], "acceptable"}], "n_void", "versions", "config"}``; a row
        has policy, demonstrations, variation, n_episodes, and a list over the factors for each of
        n_success, pc_success and pc_success_ci95 (Wilson), percentages from 0 to 100; what turned
        has factor, above and below (as at factor 1), beyond_intervals, and before and after, as
        from `dressing_sim.benchmark.analysis.statistics.Paired`.
    """
    ordered = sorted(results, key=lambda result: result.index)
    episodes = EpisodeTable.of(ordered)
    sources, units = threshold_sources(), threshold_units()
    return {
        "factors": list(FACTORS),
        "thresholds": [
            {
                "name": name,
                "value": getattr(rules, name),
                "unit": units[name],
                "source": sources[name],
                "values": [getattr(scaled(rules, name, factor), name) for factor in FACTORS],
                **_sensitivity(protocol, episodes, ordered, name),
            }
            for name in NAMES
        ],
        "n_void": episodes.rate.n_void,
        "versions": versions(),
        "config": {"protocol": protocol.name, "suite": protocol.suite, **config},
    }


def _sensitivity(
    protocol: Protocol, episodes: EpisodeTable, results: Sequence[EpisodeResult], name: str
) -> dict[str, Any]:
    """What of the summary is about one threshold; `episodes` are the results as a table."""
    judged = {
        factor: episodes.judged([verdict_of(result, name, factor) for result in results]).rows
        for factor in FACTORS
    }
    turned = [
        {"factor": factor, **turn}
        for factor, rows in judged.items()
        for turn in _turned(judged[1.0], rows)
    ]
    low, high = TOLERATED
    return {
        "rows": [
            _rates(entry, [Rate.of(rows.get(entry, {}).values()) for rows in judged.values()])
            for entry in protocol.entries
        ],
        "turned": turned,
        "acceptable": not any(
            turn["beyond_intervals"] and low <= turn["factor"] <= high for turn in turned
        ),
    }


def _rates(entry: Entry, rates: Sequence[Rate]) -> dict[str, Any]:
    """An entry with its success rate for each factor."""
    return {
        **entry.to_dict(),
        "n_episodes": max(rate.n for rate in rates),
        "n_success": [rate.n_success for rate in rates],
        "pc_success": [rate.percent for rate in rates],
        "pc_success_ci95": [list(rate.interval) for rate in rates],
    }


def _turned(before: Mapping[Entry, Row], after: Mapping[Entry, Row]) -> list[dict[str, Any]]:
    """Pairs of rows of which the first is above before and below after."""
    found = []
    for a, b in permutations(before, 2):
        if _lead(before[a], before[b]) > 0 > _lead(after[a], after[b]):
            first, second = (
                compare(rows[a], rows[b], np.random.default_rng(_BOOTSTRAP_SEED))
                for rows in (before, after)
            )
            found.append(
                {
                    "above": a.to_dict(),
                    "below": b.to_dict(),
                    "beyond_intervals": first.interval[0] > 0.0 > second.interval[1],
                    "before": first.to_dict(),
                    "after": second.to_dict(),
                }
            )
    return found


def _lead(a: Row, b: Row) -> int:
    """Successes of the first less those of the second, over the episodes that both have."""
    pairs = [(a[key], b[key]) for key in a if key in b]
    return sum(int(x) - int(y) for x, y in pairs if x is not None and y is not None)
