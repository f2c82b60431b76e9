"""Films and stills of episodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.pictures import AUTO, LARGEST_FPS
from dressing_sim.pictures.cameras import View, following
from dressing_sim.pictures.caption import Caption
from dressing_sim.pictures.encoding import check_format, check_still, write_film, write_still
from dressing_sim.pictures.look import Look
from dressing_sim.pictures.overlays import lasting, momentary
from dressing_sim.pictures.rendering import OffscreenRenderer
from dressing_sim.pictures.story import Moment, Story
from dressing_sim.pictures.strain_colours import StrainScale
from dressing_sim.world.scene import WorldConfig, resting_sleeve
from dressing_sim.world.simulation import World

#: Moments in a strip of stills.
STRIP = 5


class Film:
    """Keeps moments of an episode, to be drawn afterwards.

    Pass `expose` as the observer of an episode.

    Args:
        fps: Pictures a second of simulated time.

    Attributes:
        fps: As given.
        moments: What was kept.
    """

    def __init__(self, fps: int = 25) -> None:
        self.fps = whole_number(fps, "fps", 1, LARGEST_FPS)
        self.moments: list[Moment] = []
        self._next: float | None = None
        self._began = 0.0

    def __len__(self) -> int:
        return len(self.moments)

    def expose(self, world: World) -> None:
        """Take a picture if it is time for one."""
        if self._next is None:
            self._next = self._began = world.time
        # Half a microsecond of slack: times are sums of time steps.
        while world.time >= self._next - 5e-7:
            self.moments.append(Moment.of(world, self._began))
            self._next += 1.0 / self.fps

    def write(
        self,
        path: str | Path,
        posture: Posture,
        config: WorldConfig,
        camera: str = "front",
        width: int = 640,
        height: int = 480,
        story: Story | None = None,
    ) -> None:
        """Draw and encode the film; the file is whole or not there.

        Args:
            path: Where to; its suffix says the format, see `dressing_sim.pictures.encoding`.
            posture: The arm of the episode.
            config: The world of the episode.
            camera: One of `dressing_sim.pictures.CAMERAS`, or `dressing_sim.pictures.AUTO`.
            width: Of a picture [pixels].
            height: Of a picture [pixels].
            story: Of the episode, to be told in captions; no captions without.

        Raises:
            DressingSimError: No OpenGL works here.
            InvalidInputError: No film of this format and size can be made, or the robot never
                moved.
        """
        look = Look(camera, width, height, caption=story is not None)
        write_video(path, [Shot(self, posture, config, story or Story())], look)


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """An episode that was filmed.

    Attributes:
        film: Its moments.
        posture: The arm.
        config: The world.
        story: What is known of it.
    """

    film: Film
    posture: Posture
    config: WorldConfig
    story: Story

    def pictures(
        self, look: Look, rows: Sequence[int] | None = None
    ) -> Iterator[NDArray[np.uint8]]:
        """Draw moments one after the other, each of shape (height, width, 3).

        Args:
            look: How.
            rows: Which moments; all of them if not given.
        """
        moments = self.film.moments
        mesh = resting_sleeve(self.posture, self.config.sleeve)
        top = self.story.thresholds.strain if "strain" in look.overlays else None
        scale = None if top is None else StrainScale(mesh, top)
        caption = Caption(self.posture, mesh, self.story, moments[-1].time, scale)
        still = lasting(self.story, look.overlays)
        with OffscreenRenderer(
            self.posture, self.config, look.width, look.height, top, look.fine
        ) as renderer:
            views: Sequence[View | str] = [look.camera] * len(moments)
            if look.camera == AUTO:
                shape = look.width / look.height
                views = following(moments, self.posture.shoulder, shape, renderer.hidden)
            for row in range(len(moments)) if rows is None else rows:
                moment = moments[row]
                marks = [*still, *momentary(self.posture, moment, look.overlays)]
                picture = renderer.draw(moment.qpos, views[row], marks)
                if look.caption:
                    caption.write(picture, moment)
                yield picture


def write_video(path: str | Path, shots: Sequence[Shot], look: Look) -> None:
    """Draw and encode a film of one episode, or of several side by side.

    Episodes that end before the longest stay as they end.

    Raises:
        DressingSimError: No OpenGL works here.
        InvalidInputError: No film of this format and size can be made, or a robot never moved.
    """
    width = len(shots) * look.width
    check_format(path, width, look.height)
    _check_moved(path, shots)
    longest = max(len(shot.film) for shot in shots)
    panels = [_lasting(shot.pictures(look), longest) for shot in shots]
    pictures = (np.concatenate(row, axis=1) for row in zip(*panels, strict=True))
    write_film(path, pictures, shots[0].film.fps, width, look.height)


def write_stills(
    path: str | Path, shots: Sequence[Shot], look: Look, at: float | None = None
) -> None:
    """Draw a strip of `STRIP` moments from begin to end, one episode below the other.

    Args:
        path: Where to; its suffix says the format, see `dressing_sim.pictures.encoding`.
        shots: The episodes.
        look: How.
        at: Only the moment at this time [s], or the last before it.

    Raises:
        DressingSimError: No OpenGL works here.
        InvalidInputError: No picture of this format can be made, or a robot never moved.
    """
    check_still(path)
    _check_moved(path, shots)
    strips = []
    for shot in shots:
        times = np.array([moment.time for moment in shot.film.moments])
        wanted = np.linspace(0.0, times[-1], STRIP) if at is None else np.array([at])
        rows = np.clip(np.searchsorted(times, wanted + 1e-6, side="right") - 1, 0, None)
        strips.append(np.concatenate(list(shot.pictures(look, rows.tolist())), axis=1))
    write_still(path, np.concatenate(strips))


def _check_moved(path: str | Path, shots: Sequence[Shot]) -> None:
    if not all(len(shot.film) for shot in shots):
        raise InvalidInputError(f"video {path}: the robot never moved, so there is no film")


def _lasting(pictures: Iterator[NDArray[np.uint8]], length: int) -> Iterator[NDArray[np.uint8]]:
    """So many pictures, the last one again and again if there are fewer."""
    picture = None
    for _ in range(length):
        picture = next(pictures, picture)
        assert picture is not None
        yield picture
