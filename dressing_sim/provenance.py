"""Where numbers come from: what every file that we write says of the code and the machine."""

from __future__ import annotations

import hashlib
import inspect
import json
import platform
import sys
from collections.abc import Callable, Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution, version
from pathlib import Path
from typing import Any

import dressing_sim
from dressing_sim.numerics import numerics

#: Packages whose version can change the bits of a simulation.
VERSIONED = (
    "dressing-sim",
    "mujoco",
    "pin",
    "daqp",
    "numpy",
    "scipy",
    "example-robot-data",
)

#: Told as well: what the learning library's loops are compiled with.
_COMPILER = ("numba",)


def versions() -> dict[str, str]:
    """Installed versions of everything that a result depends on."""
    return dict(_versions())


@cache  # every episode's line holds them, and reading them takes a hundredth of one
def _versions() -> Mapping[str, str]:
    return {package: version(package) for package in VERSIONED}


def provenance(sources: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """What a file says of its origin, as plain values.

    Args:
        sources: Where other people's code that took part is from, by name: the hash of its source
            (see `source_hash`) and its version.

    Returns:
        ``{"version", "commit", "python", "versions", "numerics"}``, and ``"sources"`` if there are
        any; ``commit`` is None where it is not known, ``numerics`` as in `numerics.numerics`.
    """
    packages = [*VERSIONED, *_COMPILER]
    told: dict[str, Any] = {
        "version": dressing_sim.__version__,
        "commit": commit(),
        "python": platform.python_version(),
        "versions": {name: _version(name) for name in packages},
        "numerics": dict(numerics()),
    }
    return told | ({"sources": dict(sources)} if sources else {})


def _version(package: str) -> str | None:
    """Of an installed package; the learning library runs without most of them."""
    try:
        return version(package)
    except PackageNotFoundError:
        return None


@cache
def commit() -> str | None:
    """The git commit of this package: of its source checkout, or that pip installed it from."""
    root = Path(dressing_sim.__file__).parents[1]
    if (root / "pyproject.toml").is_file():
        return _checked_out(root / ".git")
    try:
        text = distribution("dressing-sim").read_text("direct_url.json")
    except PackageNotFoundError:
        return None
    found = json.loads(text).get("vcs_info", {}).get("commit_id") if text else None
    return str(found) if found else None


def _checked_out(git: Path) -> str | None:
    """What ``HEAD`` stands for, read without git; None if that is no repository."""
    try:
        if git.is_file():  # a further work tree names its own folder, and that the common one
            git = git.parent / git.read_text(encoding="utf-8").partition("gitdir:")[2].strip()
        head = (git / "HEAD").read_text(encoding="utf-8").strip()
        if not head.startswith("ref:"):
            return head
        name = head.removeprefix("ref:").strip()
        common = git / "commondir"
        if common.is_file():
            git = git / common.read_text(encoding="utf-8").strip()
        if (git / name).is_file():
            return (git / name).read_text(encoding="utf-8").strip()
        packed = (git / "packed-refs").read_text(encoding="utf-8").splitlines()
    except OSError:
        return None
    return next((line.split()[0] for line in packed if line.endswith(f" {name}")), None)


def source_hash(thing: Callable[..., object]) -> str | None:
    """A hash of the source that a class or function is from, None where there is none.

    Args:
        thing: Of a module: that file alone; of a package: all ``.py`` files of the outermost one,
            in the order of their names.

    Returns:
        SHA-256 of names and contents; where the package is installed does not matter.
    """
    module = inspect.getmodule(thing)
    file = getattr(module, "__file__", None)
    if module is None or file is None:
        return None
    outermost = sys.modules.get(module.__name__.partition(".")[0], module)
    folder = Path(getattr(outermost, "__file__", None) or file).parent
    packaged = hasattr(outermost, "__path__")
    files = folder.rglob("*.py") if packaged else [Path(file)]
    named = {path.relative_to(folder).as_posix() if packaged else path.name: path for path in files}
    digest = hashlib.sha256()
    for name, path in sorted(named.items()):
        digest.update(f"{name}\n".encode() + hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()
