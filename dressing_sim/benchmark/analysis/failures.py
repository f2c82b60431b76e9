"""What went wrong first in episodes, and the postures in which most went wrong."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.rules import in_order
from dressing_sim.episode.thresholds import Thresholds

#: Two times that differ by less are the same [s].
_SLACK = 1e-6


@dataclass(frozen=True, slots=True)
class HardPosture:
    """A posture that several rows failed to dress.

    Attributes:
        posture: As the pictured episode dressed it.
        failed: Its failed episodes, in the order of the protocol.
        n_episodes: All its episodes that are not void.
        pictured: The failed episode to look at: of a policy that learned, if there is one.
    """

    posture: Posture
    failed: tuple[EpisodeResult, ...]
    n_episodes: int
    pictured: EpisodeResult


def valid(results: Iterable[EpisodeResult]) -> list[EpisodeResult]:
    """Results that count: those that are not void."""
    return [result for result in results if result.outcome.invalid is None]


def first_failure(outcome: Outcome) -> Failure | None:
    """What went wrong first; what has no time was wrong from the start. None for a success.

    A caught sleeve is found out by the limit that it exceeds, a moment before it stops the robot:
    of failures as near in time as that, the first of the rules counts.
    """
    times = [0.0 if failure.time is None else failure.time for failure in outcome.failures]
    # Failures come in the rules' order. Times are sums of steps, hence the slack.
    return next(
        (
            failure
            for failure, time in zip(outcome.failures, times, strict=True)
            if time <= min(times) + Thresholds().moment + _SLACK
        ),
        None,
    )


def first_reasons(results: Iterable[EpisodeResult]) -> dict[str, int]:
    """How many failed episodes each reason came first in, in the rules' order."""
    firsts = [first_failure(result.outcome) for result in valid(results)]
    reasons = [first.reason for first in firsts if first is not None]
    return {reason: reasons.count(reason) for reason in in_order(set(reasons))}


def hardest(results: Sequence[EpisodeResult], most: int = 6) -> list[HardPosture]:
    """The postures that the largest part of the rows failed to dress, the hardest first.

    Equally hard ones come in the order of the protocol; those that every row dressed are left out.
    """
    groups: dict[str, list[EpisodeResult]] = {}
    for result in valid(results):
        groups.setdefault(result.posture.name, []).append(result)
    found = []
    for group in groups.values():
        failed = tuple(r for r in group if not r.outcome.success)
        if failed:
            learned = (r for r in failed if r.entry.demonstrations is not None)
            pictured = next(learned, failed[0])
            found.append(HardPosture(pictured.posture, failed, len(group), pictured))
    found.sort(key=lambda hard: -len(hard.failed) / hard.n_episodes)
    return found[:most]


def verdict(outcome: Outcome) -> str:
    """A verdict in words: success, all that went wrong, or why it is void."""
    if outcome.invalid is not None:
        return f"void: {outcome.invalid}"
    return "success" if outcome.success else ", ".join(outcome.reasons)
