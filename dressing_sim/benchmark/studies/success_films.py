"""Films of the typical failures of each row."""

from __future__ import annotations

import shlex
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.failures import typical
from dressing_sim.benchmark.records import EpisodeResult, Protocol, first_failure
from dressing_sim.benchmark.report.document import Block, Cards, Film, Paragraph, Section
from dressing_sim.benchmark.run.replay import Repeatable, replay_episode
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.errors import DressingSimError
from dressing_sim.pictures import AUTO
from dressing_sim.pictures.look import Look
from dressing_sim.pictures.story import Story
from dressing_sim.pictures.video import Film as Exposed
from dressing_sim.pictures.video import Shot, write_video

#: Of a picture [pixels], and pictures a second: what is to be seen, in half a megabyte.
_SIZE, _FPS = (480, 360), 12

#: No run is asked for more of a row.
MOST_FILMS = 100


@dataclass(frozen=True, slots=True)
class Films:
    """Films of typical failures.

    Attributes:
        count: How many of a row were wanted.
        mp4: A file each, by the index of the episode.
        missing: Why an episode has none, by its index.
    """

    count: int
    mp4: Mapping[int, bytes] = field(default_factory=dict)
    missing: Mapping[int, str] = field(default_factory=dict)


def failure_films(
    study: Repeatable,
    folder: RunFolder,
    protocol: Protocol,
    results: Sequence[EpisodeResult],
    count: int,
) -> Films:
    """Run the typical failures of each row again, and film them.

    Args:
        study: The run's.
        folder: The run.
        protocol: Its rows.
        results: Its episodes.
        count: Films of a row, see `typical`.
    """
    mp4, missing = {}, {}
    episodes = EpisodeTable.of(results)
    for entry in protocol.entries:
        for result in typical(episodes.of_entry(entry), count):
            try:
                mp4[result.index] = _film(study, folder, result)
            except DressingSimError as error:
                missing[result.index] = str(error)
    return Films(count, mp4, missing)


def _film(study: Repeatable, folder: RunFolder, result: EpisodeResult) -> bytes:
    """An episode as MP4; an error if it does not come out as it was recorded."""
    exposed = Exposed(_FPS)
    again = replay_episode(study, folder, result.index, exposed.expose)
    if again.differences:
        raise DressingSimError("this episode does not come out as it was recorded")
    if not len(exposed):
        raise DressingSimError("the robot never moved")
    title = f"{result.entry.label} on {again.posture.name}"
    story = Story(title, again.result.outcome, thresholds=again.config.thresholds)
    shot = Shot(exposed, again.posture, again.config.world, story)
    with TemporaryDirectory() as made:
        file = Path(made) / "film.mp4"
        write_video(file, [shot], Look(AUTO, *_SIZE, caption=True))
        return file.read_bytes()


def films_section(
    folder: Path, protocol: Protocol, episodes: EpisodeTable, films: Films | None
) -> Section:
    """The films, row by row; an empty section without films."""
    title = "Typical failures, filmed"
    if films is None:
        return Section(title, ())
    cards = []
    for entry in protocol.entries:
        row = episodes.of_entry(entry)
        firsts = Counter(map(_reason, row.where(row.failed).results))
        for result in typical(row, films.count):
            reason = _reason(result)
            card = f"{entry.label}: {reason}, {firsts[reason]} of {row.failed.sum()} failures"
            cards.append(Section(card, (_block(folder, result, films),)))
    if not cards:
        return Section(title, (Paragraph("No episode failed."),))
    told = (
        "Of each row, the most frequent reason first: of the episodes that failed by it, the one "
        "in which the sleeve came as far up the arm as in half of them. Each was run again, and "
        "came out as it was recorded."
    )
    return Section(title, (Paragraph(told), Cards(tuple(cards))))


def _reason(result: EpisodeResult) -> str:
    failure = first_failure(result.outcome)
    return "no reason" if failure is None else failure.reason


def _block(folder: Path, result: EpisodeResult, films: Films) -> Block:
    """A film with what is to be seen in it, or why there is none."""
    mp4 = films.mp4.get(result.index)
    if mp4 is None:
        return Paragraph(f"No film: {films.missing.get(result.index, 'it was not drawn')}.")
    told = "; ".join(
        f"{one.reason}{'' if one.time is None else f' after {one.time:.1f} s'}: {one.detail}"
        for one in result.outcome.failures
    )
    where = f"{result.posture.name}, elbow bent by {result.posture.elbow_deg:.0f} deg"
    again = f"dressing-sim replay {shlex.quote(str(folder))} {result.index} --video film.mp4"
    return Film(
        f"success-episode{result.index}",
        mp4,
        _SIZE,
        f"Film of {result.entry.label} dressing {result.posture.name}, which fails: {told}",
        f"Episode {result.index}, {where}. {told}. `{again}`",
    )
