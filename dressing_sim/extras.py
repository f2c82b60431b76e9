"""Packages that not everybody has."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from dressing_sim.errors import InvalidInputError


def needed(module: str, extra: str) -> Any:
    """A module of a package that an extra installs.

    Raises:
        InvalidInputError: It is not there, or cannot be loaded.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise InvalidInputError(
            f"{package} is not installed, or incomplete ({error}): "
            f"pip install 'dressing-sim[{extra}]'"
        ) from error
