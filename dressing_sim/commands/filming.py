"""Films and stills of the commands that dress."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from dressing_sim.commands.options import check_positive, names
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output
from dressing_sim.pictures import AUTO, CAMERAS, LARGEST_FPS, LARGEST_SIDE, OVERLAYS

if TYPE_CHECKING:
    from dressing_sim.pictures.look import Look
    from dressing_sim.pictures.video import Film, Shot


@dataclass(frozen=True, slots=True)
class Filming:
    """What is filmed, and how."""

    video: Path | None = None
    """film to write: .mp4 or .gif."""
    still: Path | None = None
    """picture to write, a strip of five moments: .png or .jpg."""
    at: float | None = None
    """only this moment in the still, in seconds."""
    camera: str = "front"
    """front, close, above, side, person, room, or auto, which keeps the sleeve in view."""
    overlays: str = ""
    """what is drawn besides: some of frames,path,demonstrations,strain,forces."""
    caption: bool = True
    """write time, arm coordinate, force, strain and verdict into the picture."""
    fine: bool = False
    """smooth edges and cast shadows; takes six times as long."""
    fps: int = 25
    """pictures a second."""
    width: int = 640
    """of a picture, in pixels; even for .mp4."""
    height: int = 480
    """of a picture, in pixels; even for .mp4."""
    force: bool = False
    """replace a film that is there already."""

    @property
    def look(self) -> Look:
        """How it is to look."""
        from dressing_sim.pictures.look import Look

        chosen = tuple(names(self.overlays)) if self.overlays else ()
        return Look(self.camera, self.width, self.height, chosen, self.caption, self.fine)

    def films(self, inputs: Iterable[str | Path], n_panels: int = 1) -> list[Film]:
        """Films to expose, none if none is wanted, once it is known that they can be written.

        Args:
            inputs: Files that are read, which no film may replace.
            n_panels: How many episodes are side by side.

        Raises:
            InvalidInputError: An option is not valid, or the file cannot be written, or is one of
                the inputs, or is there already and not to be replaced by force.
            DressingSimError: No OpenGL works here.
        """
        for option, number, most in (
            ("fps", self.fps, LARGEST_FPS),
            ("width", self.width, LARGEST_SIDE),
            ("height", self.height, LARGEST_SIDE),
        ):
            check_positive(option, number, most)
        if self.camera not in (*CAMERAS, AUTO):
            valid = ", ".join((*CAMERAS, AUTO))
            raise InvalidInputError(f"unknown camera {self.camera!r:.60}; valid is {valid}")
        for overlay in names(self.overlays) if self.overlays else ():
            if overlay not in OVERLAYS:
                valid = ", ".join(OVERLAYS)
                raise InvalidInputError(f"unknown overlay {overlay!r:.60}; valid is {valid}")
        if self.at is not None and not 0.0 <= self.at < float("inf"):
            raise InvalidInputError(f"at is {self.at}, valid is 0 seconds or more")
        if self.video is None and self.still is None:
            return []
        from dressing_sim.pictures.encoding import check_format, check_still
        from dressing_sim.pictures.rendering import gl_backend
        from dressing_sim.pictures.video import Film

        if self.video is not None:
            check_format(self.video, n_panels * self.width, self.height)
            check_output(self.video, self.force, inputs)
        if self.still is not None:
            check_still(self.still)
            check_output(self.still, self.force, inputs)
        gl_backend()  # without OpenGL, say so before simulating
        return [Film(self.fps) for _ in range(n_panels)]

    def write(self, shots: Sequence[Shot], inputs: Iterable[str | Path], json: bool) -> None:
        """Write what is wanted of episodes that were filmed, and say so."""
        from dressing_sim.pictures.video import write_stills, write_video

        out = sys.stderr if json else sys.stdout
        if self.video is not None:
            check_output(self.video, self.force, inputs)  # it took long
            write_video(self.video, shots, self.look)
            print(f"film written to {self.video}", file=out)
        if self.still is not None:
            check_output(self.still, self.force, inputs)
            write_stills(self.still, shots, self.look, self.at)
            print(f"still written to {self.still}", file=out)
