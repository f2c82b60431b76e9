"""What several commands share: their options, films, and how results are printed."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_output
from dressing_sim.pictures import CAMERAS, LARGEST_FPS, LARGEST_SIDE

if TYPE_CHECKING:
    from dressing_sim.episode.outcome import Outcome
    from dressing_sim.pictures.video import Film


#: Of whatever is counted on the command line; more is a slip of the finger.
MOST = 1_000_000

#: More processes than any machine has processors.
MOST_WORKERS = 1024


def check_positive(name: str, value: int, most: int = MOST) -> None:
    """Raise InvalidInputError unless an option is 1 or more, and not absurd."""
    if not 1 <= value <= most:
        raise InvalidInputError(f"{name} is {value}, valid is 1 or more, up to {most}")


def check_seed(value: int) -> None:
    """Raise InvalidInputError unless a seed is 0 or more."""
    if not 0 <= value < 2**63:
        raise InvalidInputError(f"seed is {value}, valid is 0 or more, below 2 to the 63rd")


def names(text: str) -> list[str]:
    """The names in a list with commas."""
    return [name.strip() for name in text.split(",")]


def new_film(
    video: Path | None,
    camera: str,
    fps: int,
    width: int,
    height: int,
    force: bool = False,
    inputs: Iterable[str | Path] = (),
) -> Film | None:
    """A film to expose, or None if none is wanted, once it is known that it can be written.

    Raises:
        InvalidInputError: An option is not valid, or the file cannot be written, or is one of the
            inputs, or is there already and not to be replaced by force.
        DressingSimError: No OpenGL works here.
    """
    for option, number, most in (
        ("fps", fps, LARGEST_FPS),
        ("width", width, LARGEST_SIDE),
        ("height", height, LARGEST_SIDE),
    ):
        check_positive(option, number, most)
    if camera not in CAMERAS:
        raise InvalidInputError(f"unknown camera {camera!r:.60}; valid is {', '.join(CAMERAS)}")
    if video is None:
        return None
    from dressing_sim.pictures.rendering import gl_backend
    from dressing_sim.pictures.video import Film, check_format

    check_format(video, width, height)
    check_output(video, force, inputs)
    gl_backend()  # without OpenGL, say so before simulating
    return Film(fps)


def print_table(cells: Sequence[Sequence[str]]) -> None:
    """Print cells of text, the first row the heading."""
    heading, *body = cells
    grid = Table(*heading)
    for line in body:
        grid.add_row(*line)
    Console(width=None if sys.stdout.isatty() else 120).print(grid)


def print_outcome(name: str, outcome: Outcome) -> None:
    """Print a verdict with its reasons and metrics."""
    from dressing_sim.episode.metrics import metric_text

    print(f"{name}: {'success' if outcome.success else outcome.invalid or 'failure'}")
    for failure in outcome.failures:
        when = "" if failure.time is None else f" at {failure.time:.2f} s"
        print(f"  {failure.reason}{when}: {failure.detail}")
    for metric, value in outcome.metrics.items():
        print(f"  {metric:24} {metric_text(metric, value)}")
