"""Demonstrations that were recorded before, by everything that they depend on."""

from __future__ import annotations

import hashlib
import json
import logging
import os
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import platformdirs

import dressing_sim
from dressing_sim.episode.demonstration import (
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.numerics import numerics
from dressing_sim.provenance import source_hash, versions

#: A folder for the cache; if it is empty, nothing is kept.
VARIABLE = "DRESSING_SIM_CACHE"

#: So many are kept; a demonstration has some 50 kB.
MOST = 2000

_LOG = logging.getLogger("dressing_sim")


def cache_folder() -> Path | None:
    """Where demonstrations are kept: the folder of `VARIABLE`, or the user's for caches."""
    chosen = os.environ.get(VARIABLE)
    if chosen is not None:
        return Path(chosen) / "demonstrations" if chosen else None
    return Path(platformdirs.user_cache_dir("dressing_sim", appauthor=False)) / "demonstrations"


def cached_demonstration(depends_on: Any, make: Callable[[], Demonstration]) -> Demonstration:
    """A demonstration as it was made before from the same, or a new one, which is then kept.

    Args:
        depends_on: Plain values that decide about it, besides this package's code, the versions of
            others, and the numerics.
        make: Makes a new one.

    Returns:
        The same bits in both cases. A cache that cannot be used is no error.
    """
    folder = cache_folder()
    if folder is None:
        return make()
    key = json.dumps([depends_on, _code(), versions(), dict(numerics())], sort_keys=True)
    file = folder / f"{hashlib.sha256(key.encode()).hexdigest()[:32]}.h5"
    try:
        return load_demonstrations(file)[0]
    except (InvalidInputError, IndexError, OSError):  # it is not there, or it is damaged
        made = make()
    try:
        save_demonstrations(file, [made])
        _forget(folder, file)
    except (InvalidInputError, OSError):
        _warn(folder)
    return made


@cache
def _code() -> str | None:
    return source_hash(dressing_sim.errors.DressingSimError)


def _forget(folder: Path, kept: Path) -> None:
    """Remove files beyond `MOST`, but not the one that has just been written.

    Which of the others go is chance, drawn anew with each file: those of code that is no more used
    do not stay for ever.
    """
    others = [file for file in folder.glob("*.h5") if file != kept]
    if len(others) >= MOST:
        drawn = {f: hashlib.sha256(f"{kept.stem}{f.stem}".encode()).digest() for f in others}
        for file in sorted(others, key=drawn.__getitem__)[MOST - 1 :]:
            file.unlink(missing_ok=True)


@cache
def _warn(folder: Path) -> None:
    _LOG.warning("%s: cannot be written, so demonstrations are not kept for the next run", folder)
