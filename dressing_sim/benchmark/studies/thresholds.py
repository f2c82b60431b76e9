"""The study of thresholds: how success rates, and the ranking of rows, hang on each of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.plan import Plan, make_plan
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.study import EpisodeStudy
from dressing_sim.benchmark.studies.thresholds_document import thresholds_document
from dressing_sim.benchmark.studies.thresholds_summary import summarise
from dressing_sim.benchmark.studies.thresholds_verdicts import dress_and_judge
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.policies.registry import EXPERT

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


def thresholds_plan(protocol: Protocol = PROTOCOL, seed: int = 0) -> Plan:
    """The plan of the study: episodes go on after limits were exceeded."""
    return make_plan(protocol, seed, EpisodeConfig(protective_stop=False))


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
        self,
        folder: RunFolder,
        results: Sequence[EpisodeResult],
        summary: Mapping[str, Any],
        command: str,
    ) -> Document:
        """A table, and a plot of each threshold."""
        return thresholds_document(summary, command)
