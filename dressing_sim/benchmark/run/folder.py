"""The files of a run's folder: whose they are, and how a run begins among them."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from dressing_sim.archives import read_json, unreadable
from dressing_sim.benchmark.run.agreement import differences
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import (
    fill,
    is_leftover,
    remove_leftovers,
    replacing,
    unwritable,
    write_file,
)
from dressing_sim.system import lock_file

CONFIG, EPISODES, SUMMARY = "config.json", "episodes.jsonl", "summary.json"
DEMONSTRATIONS, POLICY_LOG = "demonstrations", "policies.log"

#: A file that is locked while a run goes on; the others are replaced as they are written.
LOCK = ".lock"

#: The config of an earlier run while that run is removed; what is left of it is of no use.
REPLACED = ".replaced.json"

_REPORTS = ("report.md", "report.html")

#: What every run writes.
RUN_FILES = (CONFIG, EPISODES, SUMMARY, *_REPORTS)

#: Films of a report, by the name of the study and the episode's index.
_OWN_FILM = re.compile(r"[a-z]+-episode\d+\.mp4")

#: Names that `RunFolder.demonstration_file` gives; of all demonstrations a new run removes these.
_OWN_DEMONSTRATION = re.compile(r"(set\d+-.*|own)-[0-9a-f]{8}\.h5")


def earlier_config(
    path: Path, plan: Plan, wanted: Mapping[str, Any], resume: bool, force: bool
) -> dict[str, Any] | None:
    """The config of the run that a folder holds; None if it holds none of this study.

    `wanted` is what the plan is in a file.
    """
    try:
        earlier = read_config(path)
    except InvalidInputError:
        if not force:
            raise
        return None
    if force:
        return earlier if earlier and study_of(earlier) == plan.protocol.study else None
    check_own(path)
    if earlier is not None:
        _check_replaceable(path, earlier, plan, wanted, resume)
    return earlier


def check_own(path: Path) -> None:
    """Raise InvalidInputError if a folder holds files but no run, unless one was to begin there."""
    try:
        names = set(os.listdir(path))
        begun = EPISODES in names and (path / EPISODES).stat().st_size == 0
    except (FileNotFoundError, NotADirectoryError):
        return
    except OSError as error:
        raise unwritable(path, error) from error
    config = read_config(path) if CONFIG in names else None
    if config is not None and not study_of(config):
        raise InvalidInputError(
            f"{path / CONFIG}: not the config of a run; choose another --out, or use --force"
        )
    if names & {CONFIG, REPLACED}:
        return
    names -= {LOCK, EPISODES} if begun else {LOCK}
    foreign = sorted(name for name in names if not is_leftover(name, _is_own))
    if EPISODES in foreign:
        raise InvalidInputError(
            f"{path} holds {EPISODES} without {CONFIG}; choose another --out, or begin anew with "
            "--force"
        )
    if foreign:
        raise InvalidInputError(
            f"{path} holds files that are not a run's, such as {foreign[0]!r}; choose another "
            "--out, or use --force"
        )


def _is_own(name: str) -> bool:
    """Whether a run writes a file of this name."""
    films = _OWN_FILM.fullmatch(name)
    own = films or _OWN_DEMONSTRATION.fullmatch(name)
    return name in RUN_FILES or name.endswith(".svg") or bool(own)


def remove_own_leftovers(path: Path) -> None:
    """Remove what a killed process was writing."""
    remove_leftovers(path, _is_own)
    remove_leftovers(path / DEMONSTRATIONS, _is_own)


def _check_replaceable(
    path: Path, earlier: Mapping[str, Any], plan: Plan, wanted: Mapping[str, Any], resume: bool
) -> None:
    """Raise InvalidInputError unless the run in a folder may be replaced or go on."""
    if study_of(earlier) != plan.protocol.study:
        raise InvalidInputError(
            f"{path} holds a run of another study, {study_of(earlier)!r}; choose another --out, or "
            "use --force"
        )
    if resume:
        return
    if not (path / SUMMARY).exists():
        raise InvalidInputError(
            f"{path} holds an unfinished run; continue it with --resume, or choose another --out"
        )
    others = differences({key: earlier.get(key) for key in wanted}, wanted, "there", "now")
    if others:
        more = ", and more" if len(others) > 1 else ""
        raise InvalidInputError(
            f"{path} holds a finished run with another config ({others[0]}{more}); choose another "
            "--out, or use --force"
        )


@contextmanager
def locked(path: Path) -> Iterator[None]:
    """Keep other processes from running in a folder, which is made if it is not there.

    If nothing comes of it, because the disk is full for instance, the folder is as it was before.

    Raises:
        InvalidInputError: Another process is, or the folder cannot be written to.
    """
    fresh = not path.exists()
    try:
        path.mkdir(parents=True, exist_ok=True)
        file = (path / LOCK).open("ab")
    except OSError as error:
        raise unwritable(path, error) from error
    with file:
        try:
            lock_file(file)
        except BlockingIOError as error:
            raise InvalidInputError(f"{path}: another process is running in it") from error
        except OSError as error:
            raise unwritable(path / LOCK, error) from error
        try:
            yield
        except BaseException:
            with suppress(OSError):  # where an open file cannot be removed, it stays
                if os.listdir(path) == [LOCK]:
                    (path / LOCK).unlink()
                    if fresh:
                        path.rmdir()
            raise


def write_config(path: Path, config: Mapping[str, Any]) -> None:
    """Write the config of a run."""
    write_file(path / CONFIG, _text(config))


def begin(path: Path, config: Mapping[str, Any], study: str, own: bool) -> None:
    """Put a new run in the place of whatever was there, its config last.

    Where there is a config, the other files belong to it. A disk that has no room for a new one is
    found out before anything is removed.

    Args:
        path: The folder.
        config: Of the new run.
        study: Of the new run.
        own: Whether what was there is a run of the same study.
    """
    with replacing(path / CONFIG) as new:
        fill(new, _text(config))
        with replacing(path / EPISODES):
            _clear(path, study, own)


def _text(config: Mapping[str, Any]) -> str:
    return json.dumps(config, indent=2) + "\n"


def _clear(path: Path, study: str, own: bool) -> None:
    """Remove an earlier run, its config first, which stays aside until the new one is there.

    A plot's name, and a film's, begins with the study's; where the run was not `own`, a plot's is
    only that, and films are not known to be of one.
    """
    stale = [path / name for name in (SUMMARY, POLICY_LOG, *_REPORTS, f"{study}.svg")]
    stale += [plot for plot in path.glob("*.svg") if own and plot.name.startswith(study)]
    stale += [
        film
        for film in path.glob(f"{study}-episode*.mp4")
        if own and _OWN_FILM.fullmatch(film.name)
    ]
    stale += [p for p in (path / DEMONSTRATIONS).glob("*") if _OWN_DEMONSTRATION.fullmatch(p.name)]
    for file in (path / CONFIG, path / EPISODES, *stale):
        if file.is_dir():
            raise InvalidInputError(f"{file}: cannot be replaced (it is a folder)")
    if (path / CONFIG).exists():
        (path / CONFIG).replace(path / REPLACED)
    for file in stale:
        file.unlink(missing_ok=True)


def read_config(path: Path) -> dict[str, Any] | None:
    """The config that is in a folder, if there is one."""
    file = path / CONFIG
    try:
        if not file.exists():
            return None
    except OSError as error:
        raise unreadable(file, error) from error
    values = read_json(file)
    if not isinstance(values, dict):
        raise InvalidInputError(f"{file}: not the config of a run")
    return values


def study_of(config: Mapping[str, Any]) -> str:
    """The name of a run's study; nothing where the config is damaged."""
    protocol = config.get("protocol")
    return str(protocol.get("study", "")) if isinstance(protocol, Mapping) else ""
