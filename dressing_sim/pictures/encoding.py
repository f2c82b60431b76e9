"""Pictures to files that play: MP4, GIF, PNG."""

from __future__ import annotations

import subprocess
from collections.abc import Iterable, Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.files import fill, replacing, write_file
from dressing_sim.pictures.look import check_size

FORMATS = (".mp4", ".gif")

STILL_FORMATS = (".png", ".jpg")

#: Browsers show a GIF's picture for a tenth of a second if it says that it wants less than this
#: [hundredths of a second].
_SHORTEST = 2


def write_film(
    path: str | Path,
    pictures: Iterable[NDArray[np.uint8]],
    fps: int,
    width: int,
    height: int,
) -> None:
    """Encode a film; the file is whole or not there.

    Args:
        path: Where to; its suffix says the format, one of `FORMATS`.
        pictures: Each of shape (height, width, 3).
        fps: Pictures a second.
        width: Of a picture [pixels].
        height: Of a picture [pixels].
    """
    if is_gif(path):
        write_file(path, gif(pictures, fps))
        return
    # The encoder does not say why it cannot write; whoever writes its film does.
    with replacing(path) as target, TemporaryDirectory() as folder:
        film = Path(folder) / "film.mp4"
        write_mp4(film, pictures, fps, width, height)
        fill(target, film.read_bytes())


def write_still(path: str | Path, picture: NDArray[np.uint8]) -> None:
    """Write one picture; the file is whole or not there."""
    content = BytesIO()
    kind = "png" if Path(path).suffix.lower() == ".png" else "jpeg"
    Image.fromarray(picture).save(content, kind)
    write_file(path, content.getvalue())


def gif_delays(n_pictures: int, fps: int) -> list[int]:
    """How long each picture is shown [hundredths of a second]; 0 for one that is left out.

    A GIF counts hundredths. Their sum keeps pace with the film's time; pictures that would be shown
    more shortly than browsers do are left out.
    """
    ends = [round(100.0 * (n + 1) / fps) for n in range(n_pictures)]
    delays, shown_until = [0] * n_pictures, 0
    last = 0
    for number, end in enumerate(ends):
        if end - shown_until >= _SHORTEST or number == 0:
            delays[number], last = max(end - shown_until, _SHORTEST), number
            shown_until += delays[number]
    delays[last] += ends[-1] - shown_until if ends else 0
    return delays


def gif(pictures: Iterable[NDArray[np.uint8]], fps: int) -> bytes:
    """A film as GIF, which plays in real time and again and again."""
    images = [Image.fromarray(picture) for picture in pictures]
    delays = gif_delays(len(images), fps)
    kept = [(image, 10 * delay) for image, delay in zip(images, delays, strict=True) if delay]
    first = kept[0][0].quantize(256)
    frames: Iterator[Image.Image] = (
        image.quantize(palette=first, dither=Image.Dither.NONE) for image, _ in kept
    )
    content = BytesIO()
    next(frames).save(
        content,
        "gif",
        save_all=True,
        append_images=frames,
        duration=[delay for _, delay in kept],
        loop=0,
        optimize=False,
    )
    return content.getvalue()


def write_mp4(
    path: Path, pictures: Iterable[NDArray[np.uint8]], fps: int, width: int, height: int
) -> None:
    """Encode as H.264, which browsers play.

    The end of ffmpeg is checked: imageio takes a film that was cut off for whole.
    """
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-y", "-v", "error", "-f", "rawvideo"]
    command += ["-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(fps), "-i", "-", "-an"]
    command += ["-c:v", "libx264", "-preset", "superfast", "-crf", "20", "-pix_fmt", "yuv420p"]
    # Its table of contents comes first: browsers start before they have all of it.
    command += ["-movflags", "+faststart", "-f", "mp4", str(path.absolute())]
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
    if not is_gif(path) and (width % 2 or height % 2):
        raise InvalidInputError(
            f"video {path}: {width} x {height} pixels, valid for MP4 are even numbers"
        )


def is_gif(path: str | Path) -> bool:
    """Whether a file's name says that it is a GIF."""
    return Path(path).suffix.lower() == ".gif"


def check_still(path: str | Path) -> None:
    """Raise InvalidInputError unless a still can be written to a file of this name."""
    if Path(path).suffix.lower() not in STILL_FORMATS:
        raise InvalidInputError(
            f"still {path}: unknown format {Path(path).suffix!r}, valid is "
            f"{', '.join(STILL_FORMATS)}"
        )
