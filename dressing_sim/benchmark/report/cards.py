"""The hardest postures as the page shows them: a picture, what went wrong, how to see it again."""

from __future__ import annotations

import base64
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from dressing_sim.benchmark.analysis.comparisons import label
from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.report.figures import HardPosture, first_failure, hardest
from dressing_sim.benchmark.report.text import replay_command
from dressing_sim.episode.rules import Failure
from dressing_sim.errors import DressingSimError

#: Draws a failed episode, as the bytes of a PNG file; None if there is nothing to be drawn. A
#: DressingSimError says why no picture can be had at all.
Picture = Callable[[EpisodeResult], bytes | None]


@dataclass(frozen=True, slots=True)
class Card:
    """A hard posture with all that the page says of it.

    Attributes:
        hard: The posture and its failed episodes.
        picture: PNG file in base64, or None.
        shown: The pictured row.
        moment: When in the episode the picture was taken.
        failures: What went wrong in the pictured episode.
        episodes: All failed episodes, a line each.
        replay: Command that shows the pictured episode.
    """

    hard: HardPosture
    picture: str | None
    shown: str
    moment: str
    failures: list[str]
    episodes: list[str]
    replay: str


def hard_postures(
    folder: Path, results: Sequence[EpisodeResult], picture: Picture | None
) -> tuple[list[Card], str | None]:
    """Cards of the hardest postures.

    Args:
        folder: Where the run is.
        results: Episodes in the order of the protocol.
        picture: Draws an episode; None for a page without pictures.

    Returns:
        The cards, and why there are no pictures, if there are none.
    """
    found = hardest(results)
    pictures: list[bytes | None] = [None] * len(found)
    reason = "pictures left out"
    if picture is not None:
        try:
            pictures = [picture(hard.pictured) for hard in found]
        except DressingSimError as error:
            reason = f"pictures left out: {error}"
    cards = [_card(folder, hard, drawn) for hard, drawn in zip(found, pictures, strict=True)]
    return cards, None if any(pictures) else reason


def _card(folder: Path, hard: HardPosture, drawn: bytes | None) -> Card:
    outcome = hard.pictured.outcome
    first = first_failure(outcome)
    timed = first is not None and first.time is not None
    return Card(
        hard=hard,
        picture=base64.b64encode(drawn).decode() if drawn else None,
        shown=label(hard.pictured.entry),
        moment=f"after {first.time:.1f} s" if first is not None and timed else "at the start",
        failures=[_failure(failure) for failure in outcome.failures],
        episodes=[
            f"{result.index}: {label(result.entry)}: {', '.join(result.outcome.reasons)}"
            for result in hard.failed
        ],
        replay=replay_command(folder, hard.pictured),
    )


def _failure(failure: Failure) -> str:
    when = "" if failure.time is None else f" at {failure.time:.1f} s"
    return f"{failure.reason}{when}: {failure.detail}"
