"""The postures in which most went wrong, and verdicts in words."""

from __future__ import annotations

from dataclasses import dataclass

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import EpisodeResult, Outcome


@dataclass(frozen=True, slots=True)
class HardPosture:
    """A posture that several rows failed to dress.

    Attributes:
        failed: Its failed episodes, in the order of the protocol.
        n_episodes: All its episodes that count.
    """

    failed: tuple[EpisodeResult, ...]
    n_episodes: int

    @property
    def pictured(self) -> EpisodeResult:
        """The failed episode to look at: of a policy that learned, if there is one."""
        learned = (r for r in self.failed if r.entry.demonstrations is not None)
        return next(learned, self.failed[0])


def hardest(episodes: EpisodeTable, most: int = 6) -> list[HardPosture]:
    """The postures that the largest part of the rows failed to dress, the hardest first.

    Equally hard ones come in the order of the protocol; those that every row dressed are left out.
    """
    valid = episodes.where(episodes.valid)
    found = [
        HardPosture(group.where(group.failed).results, len(group))
        for group in valid.by_posture.values()
        if group.failed.any()
    ]
    return sorted(found, key=lambda hard: -len(hard.failed) / hard.n_episodes)[:most]


def verdict(outcome: Outcome) -> str:
    """A verdict in words: success, all that went wrong, abstained, or why it is void."""
    if outcome.invalid is not None:
        return f"void: {outcome.invalid}"
    if outcome.abstained is not None:
        return "abstained"
    return "success" if outcome.success else ", ".join(outcome.reasons)
