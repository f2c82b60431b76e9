"""Where two nested structures of plain values differ."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

#: More differences than this are counted only.
_SHOWN = 12


def differences(first: Any, second: Any, here: str, there: str) -> list[str]:
    """One line for each value that differs, and none if all are equal to the bit.

    Args:
        first: Dictionaries and lists of plain values.
        second: The like.
        here: What the first are called in the text.
        there: What the second are called.
    """
    one, other = dict(_leaves(first)), dict(_leaves(second))
    names = [n for n in dict.fromkeys([*one, *other]) if _shown(one, n) != _shown(other, n)]
    lines = [f"{n}: {_shown(one, n)} {here}, {_shown(other, n)} {there}" for n in names[:_SHOWN]]
    return lines + ([f"and {len(names) - _SHOWN} more"] if len(names) > _SHOWN else [])


def _shown(values: Mapping[str, Any], name: str) -> str:
    # The shortest text that gives the same number again; unlike numbers, NaN equals itself.
    return repr(values[name]) if name in values else "nothing"


def _leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Plain values within plain values, each with its dotted name."""
    children: Iterable[tuple[Any, Any]]
    if isinstance(value, Mapping) and value:
        children = value.items()
    elif isinstance(value, list) and value:
        children = enumerate(value)
    else:
        yield name, value
        return
    for key, child in children:
        yield from _leaves(child, f"{name}.{key}" if name else str(key))
