"""The study of success: how often policies dress an arm in a posture that they were not shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.report.document import Document
from dressing_sim.benchmark.run.runner import repeated_demonstrations
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.pictures import failure_pictures
from dressing_sim.benchmark.studies.study import EpisodeStudy
from dressing_sim.benchmark.studies.success_document import success_document
from dressing_sim.benchmark.studies.success_films import failure_films
from dressing_sim.benchmark.studies.success_summary import summarise
from dressing_sim.config import to_plain
from dressing_sim.policies.paper import plain_config
from dressing_sim.world.robot import PANDA


@dataclass(frozen=True)
class Success(EpisodeStudy):
    """How often each row of a protocol dresses the arm.

    Attributes:
        pictures: Whether the hardest postures are drawn, which runs their episodes again.
        films: How many typical failures of each row are filmed, which runs their episodes again.
    """

    pictures: bool = False
    films: int = 0

    def summarise(self, folder: RunFolder, results: Sequence[EpisodeResult]) -> dict[str, Any]:
        """Rates, comparisons, claims."""
        plan = folder.plan
        config = {
            "seed": plan.seed,
            "repeated_demonstrations": repeated_demonstrations(folder),
            "policies": plain_config(),
            "episode": to_plain(plan.config),
        }
        robot = plan.config.world.robot
        return summarise(plan.protocol, results, config, None if robot == PANDA else robot.name)

    def document(
        self,
        folder: RunFolder,
        results: Sequence[EpisodeResult],
        summary: Mapping[str, Any],
        command: str,
    ) -> Document:
        """Tables, plots, and pictures and films if wanted."""
        drawn = failure_pictures(self, folder, results) if self.pictures else None
        protocol, films = folder.plan.protocol, None
        if self.films:
            films = failure_films(self, folder, protocol, results, self.films)
        return success_document(folder.path, protocol, results, summary, command, drawn, films)
