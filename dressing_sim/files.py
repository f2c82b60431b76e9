"""Files: those that come with the package, and new ones that are either whole or not there."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dressing_sim.errors import InvalidInputError


def assets() -> Path:
    """The assets folder: inside the installed package, or at the top of a source checkout."""
    package = Path(__file__).resolve().parent
    installed = package / "assets"
    return installed if installed.is_dir() else package.parent / "assets"


@contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """A temporary file in the same folder that becomes `path` if the block ends without an error.

    Missing folders are made. A reader sees the old file or the whole new one.

    Raises:
        InvalidInputError: The file or its folder cannot be written to.
    """
    target = Path(path)
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        descriptor, name = tempfile.mkstemp(
            dir=target.parent, prefix=f".{target.stem}.", suffix=target.suffix
        )
        os.close(descriptor)
    except OSError as error:
        raise unwritable(target, error) from error
    temporary = Path(name)
    try:
        yield temporary
        # mkstemp makes the file private; a result gets what any new file would get.
        mask = os.umask(0)
        os.umask(mask)
        temporary.chmod(0o666 & ~mask)
        try:
            temporary.replace(target)
        except OSError as error:
            raise unwritable(target, error) from error
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def unwritable(target: Path, error: OSError) -> InvalidInputError:
    """The error that says that a file cannot be written, and why."""
    return InvalidInputError(f"{target}: cannot be written ({error.strerror or error})")


def is_file(path: str | Path) -> bool:
    """Whether this is a file that can be looked at; no name, however odd, is an error."""
    try:
        return Path(path).is_file()
    except OSError:  # a name too long for a file, for instance, or a folder that is closed to us
        return False


def check_writable(path: str | Path) -> None:
    """Find out before long work whether its result can be written; nothing is left behind.

    Raises:
        InvalidInputError: `path` is a folder, or is in a place that cannot be written to.
    """
    target = Path(path)
    try:
        if target.is_dir():
            raise InvalidInputError(f"{target}: cannot be written (it is a folder)")
        existing = next(parent for parent in target.absolute().parents if parent.exists())
    except OSError as error:
        raise unwritable(target, error) from error
    if not (existing.is_dir() and os.access(existing, os.W_OK)):
        raise InvalidInputError(
            f"{target}: cannot be written ({existing} is not a folder of yours)"
        )


def write_text(path: str | Path, text: str) -> None:
    """Write a text file, all or nothing.

    Raises:
        InvalidInputError: The file cannot be written, or the disk is full.
    """
    with replacing(path) as temporary:
        try:
            temporary.write_text(text, encoding="utf-8")
        except OSError as error:
            raise unwritable(Path(path), error) from error
