"""Configuration dataclasses to and from plain values, for files and reports."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import Field, fields, is_dataclass
from functools import cache
from math import inf
from numbers import Integral, Real
from types import MappingProxyType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

from dressing_sim.checks import listed, of_kind, shown
from dressing_sim.errors import InvalidInputError, one_line

T = TypeVar("T")


#: Metadata of a setting that came later: files have it only where it is not its default, so that
#: all others stay as they were, to the byte.
LATER: Mapping[str, bool] = MappingProxyType({"later": True})


def to_plain(config: Any) -> Any:
    """A frozen dataclass, nested ones included, as dictionaries, lists and plain values.

    A class may say in ``KEPT`` which settings of a nested one files have beside it, not within.
    """
    if is_dataclass(config):
        values = {f: getattr(config, f.name) for f in fields(config)}
        plain = {f.name: to_plain(value) for f, value in values.items() if _is_told(f, value)}
        kept: Mapping[str, str] = getattr(config, "KEPT", {})
        return plain | {name: plain[within].pop(name) for name, within in kept.items()}
    return list(config) if isinstance(config, tuple) else config


def _is_told(setting: Field[Any], value: Any) -> bool:
    return not setting.metadata.get("later") or value != setting.default


def from_plain(kind: type[T], values: Mapping[str, Any]) -> T:
    """The inverse of `to_plain`; a class may say in ``MOVED`` which settings of older files are
    within another one now.

    Raises:
        InvalidInputError: A key that the dataclass has not, or a value that a setting cannot have.
    """
    hints = get_type_hints(kind)
    if not isinstance(values, Mapping):
        raise InvalidInputError(
            f"{kind.__name__}: got {shown(values, 40)}, valid is an object with the settings "
            f"{', '.join(hints)}"
        )
    values = _as_now(kind, values)
    unknown = set(values) - set(hints)
    if unknown:
        raise InvalidInputError(
            f"{kind.__name__}: unknown setting {one_line(', '.join(sorted(map(str, unknown))))}; "
            f"valid are {', '.join(hints)}"
        )
    return kind(
        **{
            name: _convert(hints[name], value, f"{kind.__name__}: {name}")
            for name, value in values.items()
        }
    )


def _as_now(kind: type[Any], values: Mapping[str, Any]) -> Mapping[str, Any]:
    """Values of a file, with each setting where it is in a configuration: within another one."""
    now = dict(values)
    for name, into in {**getattr(kind, "MOVED", {}), **getattr(kind, "KEPT", {})}.items():
        inside = now.get(into, {})
        if name in now and isinstance(inside, Mapping):
            now[into] = {**inside, name: now.pop(name)}
    return now


#: The largest whole number of a setting, so that it is a number of other kinds too.
MOST = 1e300

#: What a value from a file must be for settings of these types, and what that is called.
_PLAIN: Mapping[Any, tuple[type, str]] = {
    bool: (bool, "true or false"),
    int: (Integral, "a whole number"),
    float: (Real, "a number"),
    str: (str, "a text"),
}


def _convert(hint: Any, value: Any, name: str) -> Any:
    if is_dataclass(hint) and isinstance(hint, type):
        return from_plain(hint, value)
    if hint in _PLAIN:
        kind, called = _PLAIN[hint]
        # A bool is an integer in Python, but nobody means 1 by true.
        if not isinstance(value, kind) or isinstance(value, bool) != (hint is bool):
            raise InvalidInputError(f"{name} is {shown(value, 40)}, valid is {called}")
        if isinstance(value, Integral) and not -MOST <= int(value) <= MOST:
            raise InvalidInputError(f"{name} is {shown(value, 40)}, valid is {called} to {MOST:g}")
    if get_origin(hint) is tuple:
        if not isinstance(value, list | tuple):
            raise InvalidInputError(f"{name} is {shown(value, 40)}, valid is a list")
        inside = get_args(hint)[0]
        return tuple(_convert(inside, one, name) if inside in _PLAIN else one for one in value)
    return tuple(value) if isinstance(value, list) else value


@cache
def _hints(kind: Any) -> Mapping[str, Any]:
    return get_type_hints(kind)


def check_kinds(config: Any, kind: str) -> None:
    """Refuse a configuration with a setting of another kind than it is declared.

    Args:
        config: The configuration.
        kind: What it is called in the message.

    Raises:
        InvalidInputError: A number, text, truth value or configuration is none.
    """
    kinds: Any = type(config)
    for name, hint in _hints(kinds).items():
        value = getattr(config, name)
        if is_dataclass(hint) and isinstance(hint, type):
            of_kind(value, hint, f"{kind}: {name}", f"a {hint.__name__}")
        elif hint in _PLAIN:
            _convert(hint, value, f"{kind}: {name}")
        elif get_origin(hint) is tuple:
            inside = get_args(hint)[0]
            for one in listed(value, f"{kind}: {name}", "a list"):
                if inside in _PLAIN:
                    _convert(inside, one, f"{kind}: {name}")


def check_numbers(
    config: Any, kind: str, positive: Sequence[str] = (), not_negative: Sequence[str] = ()
) -> None:
    """Refuse a configuration whose numbers cannot be meant.

    Args:
        config: The configuration.
        kind: What it is called in the message.
        positive: Names of settings that must be finite and above zero.
        not_negative: Names of settings that must be finite, and zero or more.

    Raises:
        InvalidInputError: One is not, or a setting is of another kind, see `check_kinds`.
    """
    check_kinds(config, kind)
    for name in (*positive, *not_negative):
        value = getattr(config, name)
        lowest = "> 0" if name in positive else ">= 0"
        if not 0.0 <= value < inf or (value == 0.0 and name in positive):  # NaN fails too
            raise InvalidInputError(f"{kind}: {name} is {value}, valid is {lowest}")
