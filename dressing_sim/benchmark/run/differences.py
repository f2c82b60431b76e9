"""Where two nested structures of plain values differ."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

#: More differences than this are counted only.
_LISTED = 12


def differences(first: Any, second: Any, here: str, there: str) -> list[str]:
    """One line for each value that differs, and none if all are equal to the bit.

    Args:
        first: Dictionaries and lists of plain values.
        second: The like.
        here: What the first are called in the text.
        there: What the second are called.
    """
    one, other = dict(leaves(first)), dict(leaves(second))
    names = [n for n in dict.fromkeys([*one, *other]) if _text(one, n) != _text(other, n)]
    return tell(one, other, names, here, there)


def tell(
    one: Mapping[str, Any], other: Mapping[str, Any], names: Sequence[str], here: str, there: str
) -> list[str]:
    """One line for each of the names of `leaves`, and one that counts those beyond the twelfth."""
    lines = [f"{n}: {_text(one, n)} {here}, {_text(other, n)} {there}" for n in names[:_LISTED]]
    return lines + ([f"and {len(names) - _LISTED} more"] if len(names) > _LISTED else [])


def _text(values: Mapping[str, Any], name: str) -> str:
    # The shortest text that gives the same number again; unlike numbers, NaN equals itself.
    return repr(values[name]) if name in values else "nothing"


def leaves(value: Any, name: str = "") -> Iterator[tuple[str, Any]]:
    """Plain values within plain values, each with its dotted name: ``figures.strain``."""
    children: Iterable[tuple[Any, Any]]
    if isinstance(value, Mapping) and value:
        children = value.items()
    elif isinstance(value, list) and value:
        children = enumerate(value)
    else:
        yield name, value
        return
    for key, child in children:
        yield from leaves(child, f"{name}.{key}" if name else str(key))
