"""The folder of a run: its config, demonstrations, and one line a job as soon as it is done."""

from __future__ import annotations

import hashlib
import io
import json
import os
import re
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from dressing_sim.archives import check_size
from dressing_sim.arm import Posture
from dressing_sim.benchmark.records import Json
from dressing_sim.benchmark.run.folder import (
    DEMONSTRATIONS,
    EPISODES,
    POLICY_LOG,
    REPLACED,
    begin,
    check_own,
    earlier_config,
    locked,
    read_config,
    remove_own_leftovers,
    write_config,
)
from dressing_sim.benchmark.run.origin import Accept, Origin, check_resumable
from dressing_sim.benchmark.run.plan import Plan
from dressing_sim.episode.demonstration import (
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import plain_path, unwritable, write_file
from dressing_sim.numerics import numerics as this_numerics

#: Largest file of episodes that is read; one of a million episodes is smaller [bytes].
MOST_EPISODES = 4 * 2**30


class RunFolder:
    """A run on disk, to be read; `load_run` and `open_run` make one.

    Attributes:
        path: The folder.
        plan: What is run.
        origin: Where its episodes come from.
    """

    def __init__(self, path: Path, config: Mapping[str, Any], episodes: bytes) -> None:
        self.path = path
        self.plan = Plan.from_dict(config)
        self.origin = Origin.of(config)
        self._lines = dict(_indexed(episodes, path / EPISODES))

    @property
    def finished(self) -> frozenset[int]:
        """Indices of the jobs whose results are on disk."""
        return frozenset(self._lines)

    @property
    def lines(self) -> list[dict[str, Any]]:
        """The lines on disk, in the order of their indices."""
        return [self.line(index) for index in sorted(self._lines)]

    def line(self, index: int) -> dict[str, Any]:
        """The line of a job, such as an episode.

        Raises:
            InvalidInputError: This episode is not there.
        """
        if index not in self._lines:
            raise InvalidInputError(
                f"{self.path}: no episode {index}; valid is an index of {EPISODES}"
                + (f", 0 to {max(self._lines)}" if self._lines else ", which is empty")
            )
        values: dict[str, Any] = json.loads(self._lines[index])
        return values

    @property
    def policy_log(self) -> Path:
        """Where what other people's policies print goes."""
        return self.path.absolute() / POLICY_LOG

    def demonstration_file(self, posture: Posture, demonstration_set: int, style: str = "") -> Path:
        """Where the demonstration on a posture is kept, of an operator of that style."""
        readable = re.sub(r"[^A-Za-z0-9_.]", "_", posture.name)[:40]
        content = f"{json.dumps(posture.to_dict())}{style}".encode()
        digest = hashlib.sha256(content).hexdigest()[:8]
        return self.path / DEMONSTRATIONS / f"set{demonstration_set}-{readable}-{digest}.h5"

    def own_file(self, name: str) -> Path:
        """Where the run keeps demonstrations of the user's."""
        return self.path / DEMONSTRATIONS / f"own-{self.plan.own[name][:8]}.h5"

    def load_demonstration(
        self, posture: Posture, demonstration_set: int, style: str = ""
    ) -> Demonstration:
        """The demonstration on a posture.

        Raises:
            InvalidInputError: It is missing, damaged, or on another posture.
        """
        path = self.demonstration_file(posture, demonstration_set, style)
        loaded = load_demonstrations(path)
        if len(loaded) != 1 or loaded[0].posture != posture:
            raise InvalidInputError(
                f"{path}: not this run's demonstration on {posture.name!r}; delete it and use "
                "--resume"
            )
        return loaded[0]


class OpenRun(RunFolder):
    """A run on disk that goes on, in this process alone; made by `open_run`."""

    def __init__(self, path: Path, config: Mapping[str, Any], file: io.FileIO) -> None:
        file.seek(0)
        episodes = _whole_lines(file.read())
        file.truncate(len(episodes))
        super().__init__(path, config, episodes)
        self._file = file

    def append(self, values: Mapping[str, Json]) -> dict[str, Any]:
        """Put a job's line, its ``index`` first, on disk; it is there when this returns.

        Returns:
            The values as they will be read from the file.
        """
        line = json.dumps(values)
        index, _ = next(_indexed(line.encode(), self.path / EPISODES))
        self._check_there()
        size = os.fstat(self._file.fileno()).st_size
        rest = line.encode() + b"\n"
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
            os.fsync(self._file.fileno())
        except OSError as error:
            with suppress(OSError):  # else the next process drops the torn line
                self._file.truncate(size)
            raise unwritable(self.path / EPISODES, error) from error
        self._lines[index] = line
        return self.line(index)

    def sort(self) -> None:
        """Order the file by index, which is the same for every number of workers."""
        self._check_there()
        text = "".join(self._lines[index] + "\n" for index in sorted(self._lines))
        write_file(self.path / EPISODES, text)

    def _check_there(self) -> None:
        """Raise InvalidInputError if what is written would be nowhere."""
        path = self.path / EPISODES
        try:
            there = os.path.samestat(os.fstat(self._file.fileno()), path.stat())
        except OSError as error:
            raise unwritable(path, error) from error
        if not there:
            raise InvalidInputError(f"{path}: cannot be written (somebody has replaced it)")


def load_run(path: Path) -> RunFolder:
    """The run that is in a folder.

    Raises:
        InvalidInputError: The folder holds no run, or a file in it is damaged.
    """
    config = read_config(path)
    if config is None:
        raise InvalidInputError(
            f"{path}: no run here; valid is what 'dressing-sim evaluate' or 'thresholds' left"
        )
    episodes = path / EPISODES
    content = b""
    if episodes.is_file():
        check_size(episodes, MOST_EPISODES)
        content = episodes.read_bytes()
    return RunFolder(path, config, _whole_lines(content))


@contextmanager
def open_run(
    path: Path,
    plan: Plan,
    resume: bool = False,
    numerics: Callable[[], Mapping[str, str]] = this_numerics,
    accept: Accept | None = None,
    force: bool = False,
) -> Iterator[OpenRun]:
    """Begin a run in a folder, or continue the one that is there.

    Args:
        path: The folder; a finished run in it is replaced unless `resume` is set.
        plan: What is run.
        resume: Continue, if the folder holds a run.
        numerics: Tells those of the workers (see `Workers.numerics`), or of this process.
        accept: With what else the run may go on; the folder then names both.
        force: Begin anew whatever the folder holds; of it only files of a run's names are replaced.

    Raises:
        InvalidInputError: The folder holds an unfinished run and neither `resume` nor `force` is
            set, or files that no run wrote and `force` is not, or a run with another config or
            other numerics, or of another study, or another process is writing to it, or it cannot
            be written to.
    """
    if resume and force:
        raise InvalidInputError("--resume and --force exclude each other")
    for own in plan.own_files.values():
        if path.resolve() in own.resolve().parents:  # a new run removes what is in its folder
            raise InvalidInputError(f"{own}: is read, and in {path}; choose another --out")
    wanted = json.loads(json.dumps(plan.to_dict()))
    plain_path(path / EPISODES)
    if not force:
        check_own(path)  # before a lock is put there
    with locked(path):
        earlier = earlier_config(path, plan, wanted, resume, force)
        remove_own_leftovers(path)
        origin = Origin.here(plan, numerics())
        config = origin.into(wanted)
        if resume and earlier is not None:
            check_resumable(path, earlier, wanted, origin, accept or Accept())
            config = earlier
        if config is not earlier:
            begin(path, config, plan.protocol.study, earlier is not None)
        try:
            (path / REPLACED).unlink(missing_ok=True)
            file = io.FileIO(path / EPISODES, "a+")
        except OSError as error:
            raise unwritable(path / EPISODES, error) from error
        with file:
            run = OpenRun(path, config, file)
            joined = run.origin.joined(origin, len(run.finished))
            if joined != run.origin:  # it goes on with other numerics, or other code, than it had
                write_config(path, joined.into(config))
                run.origin = joined
            for name, own in plan.own_files.items():
                if not run.own_file(name).exists():
                    save_demonstrations(run.own_file(name), load_demonstrations(own))
            yield run


def _whole_lines(content: bytes) -> bytes:
    """All up to the last newline: what follows was being written when all ended."""
    return content[: content.rfind(b"\n") + 1]


def _indexed(content: bytes, path: Path) -> Iterator[tuple[int, str]]:
    """Lines with the index that each begins with."""
    for number, line in enumerate(content.decode(errors="replace").splitlines(), start=1):
        try:
            yield int(json.loads(line)["index"]), line
        except (KeyError, TypeError, ValueError, RecursionError) as error:
            raise InvalidInputError(
                f"{path}: line {number} is damaged ({line:.40}); delete it and use --resume"
            ) from error
