"""A film of an episode."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import imageio.v2 as imageio
import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import whole_number
from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.files import fill, replacing, write_file
from dressing_sim.pictures import LARGEST_FPS
from dressing_sim.pictures.rendering import OffscreenRenderer, check_size
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.simulation import World

FORMATS = (".mp4", ".gif")


class Film:
    """Keeps the scene's positions during an episode, to be drawn afterwards.

    Pass `expose` as the observer of an episode.

    Args:
        fps: Pictures a second of simulated time.
    """

    def __init__(self, fps: int = 25) -> None:
        self.fps = whole_number(fps, "fps", 1, LARGEST_FPS)
        self._states: list[NDArray[np.float64]] = []
        self._next: float | None = None

    def __len__(self) -> int:
        return len(self._states)

    def expose(self, world: World) -> None:
        """Take a picture if it is time for one."""
        if self._next is None:
            self._next = world.time
        # Half a microsecond of slack: times are sums of time steps.
        while world.time >= self._next - 5e-7:
            self._states.append(world.data.qpos.copy())
            self._next += 1.0 / self.fps

    def write(
        self,
        path: str | Path,
        posture: Posture,
        config: WorldConfig,
        camera: str = "front",
        width: int = 640,
        height: int = 480,
    ) -> None:
        """Draw and encode the film; the file is whole or not there.

        Args:
            path: Where to; its suffix says the format, one of `FORMATS`.
            posture: The arm of the episode.
            config: The world of the episode.
            camera: One of `dressing_sim.pictures.CAMERAS`.
            width: Of a picture [pixels].
            height: Of a picture [pixels].

        Raises:
            DressingSimError: No OpenGL works here.
            InvalidInputError: No film of this format and size can be made, or the robot never
                moved.
        """
        check_format(path, width, height)
        if not self._states:
            raise InvalidInputError(f"video {path}: the robot never moved, so there is no film")
        with OffscreenRenderer(posture, config, width, height) as renderer:
            pictures = (renderer.draw(state, camera) for state in self._states)
            if _is_gif(path):
                write_file(path, _gif(pictures, self.fps))
                return
            # The encoder does not say why it cannot write; whoever writes its film does.
            with replacing(path) as target, TemporaryDirectory() as folder:
                film = Path(folder) / "film.mp4"
                _write_mp4(film, pictures, self.fps, width, height)
                fill(target, film.read_bytes())


def _gif(pictures: Iterable[NDArray[np.uint8]], fps: int) -> bytes:
    content = BytesIO()
    writer: Any = imageio.get_writer(content, format="gif", duration=1000 / fps, loop=0)
    with writer:
        for picture in pictures:
            writer.append_data(picture)
    return content.getvalue()


def _write_mp4(
    path: Path, pictures: Iterable[NDArray[np.uint8]], fps: int, width: int, height: int
) -> None:
    """Encode with ffmpeg, whose end is checked: imageio takes a film that was cut off for whole."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", "-f", "rawvideo"]
    command += ["-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps), "-i", "-", "-an"]
    command += ["-pix_fmt", "yuv420p", "-f", "mp4", str(path.absolute())]
    pipe = subprocess.PIPE
    # Signals stay as they are here: a file that gets too large is an error, not the end.
    with subprocess.Popen(command, stdin=pipe, stderr=pipe, restore_signals=False) as encoder:
        assert encoder.stdin is not None
        try:
            with suppress(BrokenPipeError):  # it gave up, and says why
                for picture in pictures:
                    encoder.stdin.write(np.ascontiguousarray(picture).data)
            _, told = encoder.communicate()
        except BaseException:
            encoder.kill()
            with suppress(OSError):
                encoder.stdin.close()
            raise
    if encoder.returncode:
        lines = told.decode(errors="replace").split("\n")
        why = next((line.rpartition(": ")[2] for line in reversed(lines) if line.strip()), "")
        raise OSError(one_line(why) or f"ffmpeg ended with {encoder.returncode}")


def check_format(path: str | Path, width: int, height: int) -> None:
    """Raise InvalidInputError unless a film of this size can be written to a file of this name."""
    if Path(path).suffix.lower() not in FORMATS:
        raise InvalidInputError(
            f"video {path}: unknown format {Path(path).suffix!r}, valid is {', '.join(FORMATS)}"
        )
    check_size(width, height)
    if not _is_gif(path) and (width % 2 or height % 2):
        raise InvalidInputError(
            f"video {path}: {width} x {height} pixels, valid for MP4 are even numbers"
        )


def _is_gif(path: str | Path) -> bool:
    return Path(path).suffix.lower() == ".gif"
