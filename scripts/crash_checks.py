"""What a killed command may leave, and what must be there in the end."""

from __future__ import annotations

import contextlib
import os
import re
from dataclasses import dataclass
from pathlib import Path

from dressing_sim.files import is_leftover

#: Commands whose result is a run, which goes on.
STUDIES = ("evaluate", "thresholds", "validate")
#: How long an episode took, which no two runs share.
TIMES = re.compile(rb'"(?:seconds|cost_ratio)": (?:\[[^]]*\]|[-+.\de]+)')


@dataclass(frozen=True)
class Whole:
    """A command's result if nobody disturbs it, how long that takes, and an earlier result."""

    files: dict[str, bytes]
    seconds: float
    earlier: Path


def contents(folder: Path) -> dict[str, bytes]:
    """The files of a folder but their times; a report says what was typed, which differs."""
    files = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*")}
    return {
        name: b"" if path.name.startswith("report.") else TIMES.sub(b"", path.read_bytes())
        for name, path in files.items()
        if path.is_file()
    }


def stamps(folder: Path) -> dict[str, tuple[int, int]]:
    """What changes when anything is written in a folder."""
    found = {}
    for root, _, names in os.walk(folder):
        for path in (root, *(os.path.join(root, name) for name in names)):
            with contextlib.suppress(OSError):
                status = os.stat(path)
                found[path] = status.st_mtime_ns, status.st_size
    return found


def lines(files: dict[str, bytes]) -> list[bytes]:
    """The whole lines of a run."""
    return files.get("episodes.jsonl", b"").split(b"\n")[:-1]


def check_killed(
    name: str, before: dict[str, bytes], after: dict[str, bytes], whole: Whole, resumed: bool
) -> None:
    """Every file is the old one or the new one; lines are those of one run, none of them twice."""
    earlier = contents(whole.earlier)
    assert len(set(lines(after))) == len(lines(after)), "a line is there twice"
    for run in (whole.files, earlier):
        if set(lines(after)) <= set(lines(run)):
            break
    else:
        raise AssertionError("a line is of no run, or of another than the rest")
    if resumed:
        assert set(lines(before)) <= set(lines(after)), "a line is gone"
    if name not in STUDIES:
        for file, content in before.items():
            if not is_leftover(Path(file).name, lambda _: True):
                new = whole.files.get(file)
                assert after.get(file) in (content, new), f"{file} is damaged or gone"
    assert ("notes.txt" in before) == ("notes.txt" in after), "somebody's file is gone"


def check_end(end: dict[str, bytes], wanted: dict[str, bytes]) -> None:
    """The result is the undisturbed one, and nothing else is there."""
    assert set(end) == set(wanted), f"files differ: {sorted(set(end) ^ set(wanted))}"
    for file, content in wanted.items():
        assert end[file] == content, f"{file} has other bits"
