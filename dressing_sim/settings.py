"""Configuration dataclasses to and from plain values, for files and reports."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar, get_type_hints

from dressing_sim.errors import InvalidInputError

T = TypeVar("T")


def to_plain(config: Any) -> Any:
    """A frozen dataclass, nested ones included, as dictionaries, lists and plain values."""
    if is_dataclass(config):
        return {f.name: to_plain(getattr(config, f.name)) for f in fields(config)}
    return list(config) if isinstance(config, tuple) else config


def from_plain(kind: type[T], values: Mapping[str, Any]) -> T:
    """The inverse of `to_plain`.

    Raises:
        InvalidInputError: A key that the dataclass has not.
    """
    hints = get_type_hints(kind)
    if not isinstance(values, Mapping):
        raise InvalidInputError(
            f"{kind.__name__}: got {values!r:.40}, valid is an object with the settings "
            f"{', '.join(hints)}"
        )
    unknown = set(values) - set(hints)
    if unknown:
        raise InvalidInputError(
            f"{kind.__name__}: unknown setting {', '.join(sorted(unknown))}; "
            f"valid are {', '.join(hints)}"
        )
    return kind(**{name: _convert(hints[name], value) for name, value in values.items()})


def _convert(hint: Any, value: Any) -> Any:
    if is_dataclass(hint) and isinstance(hint, type):
        return from_plain(hint, value)
    return tuple(value) if isinstance(value, list) else value
