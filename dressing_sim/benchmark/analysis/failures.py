"""The postures in which most went wrong, typical failures, and verdicts in words."""

from __future__ import annotations

from dataclasses import dataclass

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.records import EpisodeResult, first_failure, in_order


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


def typical(row: EpisodeTable, count: int, metric: str = "armscye_s") -> list[EpisodeResult]:
    """Failed episodes to look at, those first that stand for most.

    One of each reason that came first in an episode, the most frequent reason first, then a second
    one of each, and so on. Of a reason's episodes the median by a metric comes first, then those
    next to it, the lesser before the greater.

    Args:
        row: Episodes of one row of a table.
        count: How many at most.
        metric: By its name; an episode that was over before it was measured has zero. By default,
            how far up the arm the sleeve came.
    """
    groups: dict[str, list[EpisodeResult]] = {}
    for result in row.where(row.failed).results:
        first = first_failure(result.outcome)
        if first is not None:
            groups.setdefault(first.reason, []).append(result)
    reasons = sorted(in_order(groups.keys()), key=lambda reason: -len(groups[reason]))
    queues = [_from_the_median(groups[reason], metric) for reason in reasons]
    longest = max(map(len, queues), default=0)
    turns = [queue[turn] for turn in range(longest) for queue in queues if turn < len(queue)]
    return turns[:count]


def _from_the_median(group: list[EpisodeResult], metric: str) -> list[EpisodeResult]:
    ranked = sorted(group, key=lambda r: (r.outcome.metrics.get(metric, 0.0), r.index))
    middle = (len(ranked) - 1) // 2
    order = sorted(range(len(ranked)), key=lambda rank: (abs(rank - middle), rank))
    return [ranked[rank] for rank in order]
