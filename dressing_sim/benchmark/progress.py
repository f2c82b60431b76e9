"""A progress bar with the success rate so far."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, TaskID, TextColumn, TimeElapsedColumn
from rich.progress import Progress as Bar

from dressing_sim.benchmark.runner import EpisodeResult, Progress


@contextmanager
def progress_bar(console: Console) -> Iterator[Progress]:
    """A bar a stage on a console; what it yields is told about progress by `run_protocol`."""
    columns = (
        TextColumn("{task.description:>14}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[success]}"),
    )
    bar = Bar(*columns, console=console)
    tasks: dict[str, TaskID] = {}

    def tell(stage: str, done: int, total: int, results: Sequence[EpisodeResult]) -> None:
        if stage not in tasks:
            bar.start()  # not before there is something to show: an early error stays one line
            tasks[stage] = bar.add_task(stage, total=total, success="")
        bar.update(tasks[stage], completed=done, success=_success(results))

    try:
        yield tell
    finally:
        if tasks:
            bar.stop()


def _success(results: Sequence[EpisodeResult]) -> str:
    valid = [result.outcome for result in results if result.outcome.void is None]
    if not valid:
        return ""
    dressed = sum(outcome.success for outcome in valid)
    return f"{dressed} of {len(valid)} dressed ({100 * dressed / len(valid):.0f} %)"
