"""Files: those that come with the package, and new ones that are either whole or not there."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import BinaryIO

from dressing_sim.errors import InvalidInputError
from dressing_sim.system import lock_file


def assets() -> Path:
    """The assets folder: inside the installed package, or at the top of a source checkout."""
    package = Path(__file__).resolve().parent
    installed = package / "assets"
    return installed if installed.is_dir() else package.parent / "assets"


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary file in the same folder that becomes `path` if the block ends without an error.

    Missing folders are made. A reader sees the old file or the whole new one, which is on the disk
    when the block has ended. What a killed process left of the same file is removed.

    Raises:
        InvalidInputError: The file or its folder cannot be written to.
    """
    target = plain_path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        remove_leftovers(target.parent, lambda name: name == target.name)
        held, temporary = _new_temporary(target)
    except OSError as error:
        raise unwritable(target, error) from error
    try:
        yield temporary
        _to_disk(temporary)
        # mkstemp makes the file private; a result gets what any new file would get.
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        if not _LOCKS:
            held.close()  # an open file cannot be moved there
        temporary.replace(target)
        _to_disk(target.parent)
    except OSError as error:
        raise unwritable(target, error) from error
    finally:
        with suppress(OSError):
            temporary.unlink()  # gone if it was moved
        held.close()


def plain_path(path: str | Path) -> Path:
    """A path that something may be written to, as it is.

    Raises:
        InvalidInputError: It names no file: it is empty, has a null character, or leads out of a
            folder that is not there, so that it would lead elsewhere once that is made.
    """
    target = Path(path)
    if not target.name or "\0" in str(target):
        raise InvalidInputError(f"{str(path)!r:.60}: cannot be written (it names no file)")
    above = Path()
    for part in target.parts:
        if part == ".." and not os.path.exists(above):
            raise InvalidInputError(f"{target}: cannot be written (there is no {above})")
        above /= part
    return target


def write_file(path: str | Path, content: str | bytes) -> None:
    """Write a file, all or nothing.

    Raises:
        InvalidInputError: The file cannot be written, or the disk is full.
    """
    write_files({Path(path): content})


def write_files(contents: Mapping[Path, str | bytes]) -> None:
    """Write files; none is replaced before all are on the disk, then each in its turn.

    Raises:
        InvalidInputError: A file cannot be written, or the disk is full.
    """
    with ExitStack() as stack:
        for path, content in list(contents.items())[::-1]:  # a stack ends with what came first
            temporary = stack.enter_context(replacing(path))
            try:
                fill(temporary, content)
            except OSError as error:
                raise unwritable(path, error) from error


@contextmanager
def new_folder(path: str | Path) -> Iterator[Path]:
    """An absolute name for a folder that becomes `path` if the block ends without an error.

    The folder itself is for the block to make. Missing folders above it are made.

    Raises:
        InvalidInputError: There is something at `path` already, or it cannot be written to.
    """
    target = plain_path(path)
    if os.path.lexists(target):
        raise InvalidInputError(f"{target}: is there already; choose another name")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        # Absolute: not everybody who writes into it can do with less.
        parent = target.parent.absolute()
        with tempfile.TemporaryDirectory(dir=parent, prefix=f".{target.name}.") as made:
            inside = Path(made) / target.name
            yield inside
            inside.rename(target)
    except OSError as error:
        raise unwritable(target, error) from error


def fill(path: Path, content: str | bytes) -> None:
    """Write a file on the disk, whatever becomes of it if there is an OSError."""
    with path.open("wb") as file:
        file.write(content.encode() if isinstance(content, str) else content)
        file.flush()
        os.fsync(file.fileno())


def remove_leftovers(folder: Path, written: Callable[[str], bool]) -> None:
    """Remove temporary files that killed processes left in a folder.

    Args:
        folder: Where; nothing happens if there is none.
        written: Whether a file of this name would have been written.
    """
    if not _LOCKS:
        return
    found: list[Path] = []
    with suppress(OSError):  # a folder may be closed to readers, or not be there
        found = [file for file in folder.iterdir() if is_leftover(file.name, written)]
    for file in found:
        # Whoever writes it holds it, and goes on.
        with suppress(OSError), file.open("rb") as held:
            lock_file(held)
            file.unlink()


def is_leftover(name: str, written: Callable[[str], bool]) -> bool:
    """Whether a name is that of a temporary file of one that would have been written."""
    found = _TEMPORARY.fullmatch(name)
    return found is not None and written(found["stem"] + found["suffix"])


#: Temporary files are held while they are written, so that others leave them alone.
_LOCKS = os.name == "posix"

_TEMPORARY = re.compile(r"\.(?P<stem>.+)\.[a-z0-9_]{8}\.part(?P<suffix>(\.[^.]*)?)", re.DOTALL)


def _new_temporary(target: Path) -> tuple[BinaryIO, Path]:
    """An empty file next to another, open and held."""
    while True:
        descriptor, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}.", suffix=f".part{target.suffix}"
        )
        file = open(descriptor, "rb")  # noqa: SIM115 (`replacing` closes it)
        if _LOCKS:
            with suppress(OSError):  # files cannot be locked on every disk
                lock_file(file)
        if os.path.exists(name):  # else somebody took it for a leftover
            return file, Path(name)
        file.close()


def _to_disk(path: Path) -> None:
    """Wait until a file, or what a folder says about its files, is on the disk."""
    if path.is_dir():
        with suppress(OSError):  # not every system lets a folder be opened
            descriptor = os.open(path, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
        return
    with path.open("r+b") as file:
        os.fsync(file.fileno())


def unwritable(target: Path, error: OSError) -> InvalidInputError:
    """The error that says that a file cannot be written, and why."""
    return InvalidInputError(f"{target}: cannot be written ({error.strerror or error})")


def is_file(path: str | Path) -> bool:
    """Whether this is a file that can be looked at; no name, however odd, is an error."""
    try:
        return Path(path).is_file()
    # A name too long for a file, for instance, a folder that is closed to us, or no name.
    except (OSError, TypeError, ValueError):
        return False


def check_writable(path: str | Path) -> None:
    """Find out before long work whether its result can be written; nothing is left behind.

    Raises:
        InvalidInputError: `path` is a folder, or is in a place that cannot be written to.
    """
    target = plain_path(path)
    try:
        if target.is_dir():
            raise InvalidInputError(f"{target}: cannot be written (it is a folder)")
        existing = next(parent for parent in target.absolute().parents if parent.exists())
    except OSError as error:
        raise unwritable(target, error) from error
    if not (existing.is_dir() and os.access(existing, os.W_OK)):
        raise InvalidInputError(
            f"{target}: cannot be written ({existing} is not a folder that can be written to)"
        )


def check_output(path: str | Path, force: bool, inputs: Iterable[str | Path | None] = ()) -> None:
    """Find out whether a result may be written to a file: nothing of anybody's is lost.

    Args:
        path: The file.
        force: Whether one that is there may be replaced.
        inputs: Names of what the result is made from, files or not; these are never replaced.

    Raises:
        InvalidInputError: The file cannot be written to, is an input, or is there already.
    """
    check_writable(path)
    for source in inputs:
        if source is not None and same_file(path, source):
            raise InvalidInputError(f"{path}: is read as well ({source}); choose another output")
    if not force and os.path.lexists(path):
        raise InvalidInputError(f"{path}: is there already; choose another name, or use --force")


def same_file(one: str | Path, other: str | Path) -> bool:
    """Whether two paths lead to the same file, by whatever links and spellings."""
    try:
        return os.path.samefile(one, other)
    except (OSError, ValueError):  # one is not there, or is no name of a file
        return False
