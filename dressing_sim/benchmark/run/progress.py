"""How far a run is: a bar on a terminal, else a line now and then."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import timedelta

from rich import progress as rich_progress
from rich.console import Console
from rich.progress import TextColumn

#: Told about progress: the stage, how much of it is done, of how much, and how it goes in words.
Progress = Callable[[str, int, int, str], None]

#: Time between two lines where there is no terminal [s].
INTERVAL = 30.0

#: The time left is estimated from what was done in this time [s].
_ESTIMATED_FROM = 600.0


@contextmanager
def show_progress(
    console: Console, clock: Callable[[], float] = time.monotonic
) -> Iterator[Progress]:
    """Show each stage on a console; what it yields a run tells about its progress.

    The clock gives seconds since whenever, for the lines without a terminal.
    """
    if not console.is_terminal:
        yield _lines(console, clock)
        return
    bar = rich_progress.Progress(
        TextColumn("{task.description:>14}"),
        rich_progress.BarColumn(),
        rich_progress.MofNCompleteColumn(),
        rich_progress.TimeElapsedColumn(),
        TextColumn("left"),
        rich_progress.TimeRemainingColumn(),
        TextColumn("{task.fields[note]}"),
        console=console,
        speed_estimate_period=_ESTIMATED_FROM,
    )
    tasks: dict[str, rich_progress.TaskID] = {}

    def tell(stage: str, done: int, total: int, note: str) -> None:
        if stage not in tasks:
            bar.start()  # not before there is something to show: an early error stays one line
            tasks[stage] = bar.add_task(stage, total=total, completed=done, note="")
        bar.update(tasks[stage], completed=done, note=note)

    try:
        yield tell
    finally:
        if tasks:
            bar.stop()


def _lines(console: Console, clock: Callable[[], float]) -> Progress:
    """A line at the start and the end of each stage, and every `INTERVAL` seconds between."""
    begun: dict[str, tuple[float, int]] = {}
    last = -INTERVAL

    def tell(stage: str, done: int, total: int, note: str) -> None:
        nonlocal last
        now, first = clock(), stage not in begun
        start, done_before = begun.setdefault(stage, (now, done))
        if first or done == total or now - last >= INTERVAL:
            last = now
            left = ""
            if done_before < done < total:
                seconds = (now - start) / (done - done_before) * (total - done)
                left = f"{timedelta(seconds=round(seconds))} left"
            text = ", ".join(filter(None, [f"{done} of {total}", note, left]))
            console.print(f"{stage}: {text}", soft_wrap=True, highlight=False)

    return tell


def silent(stage: str, done: int, total: int, note: str) -> None:
    """No progress is shown."""
