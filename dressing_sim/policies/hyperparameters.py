"""Hyper-parameters after a policy's name: ``tp-gmm-rf?max_iterations=50&end_radius=0``."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from types import NoneType
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from dressing_sim.errors import InvalidInputError

T = TypeVar("T")

#: What follows the name of a policy that has the hyper-parameters that a search found for it.
TUNED = "-tuned"

#: Read as the text says; a text without an annotation stays a text.
_NUMBERS: Mapping[object, str] = {int: "a whole number", float: "a number"}


def split_name(policy: str) -> tuple[str, str | None]:
    """A policy's name, and the text of what comes after its ``?``; None if there is none."""
    name, mark, text = policy.partition("?")
    return name, text if mark else None


@dataclass(frozen=True, slots=True)
class _Parameter:
    """Something that can be chosen: its type, and what it is unless chosen."""

    hint: object
    default: object

    @property
    def nested(self) -> Any:
        """The configuration that holds further parameters, or None."""
        if is_dataclass(self.default) and not isinstance(self.default, type):
            return self.default
        kinds = [hint for hint in (self.hint, *get_args(self.hint)) if isinstance(hint, type)]
        for kind in filter(is_dataclass, kinds):
            try:
                return kind()
            except TypeError:  # it has no defaults, so it cannot be chosen in parts
                return None
        return None


def changed(config: T, text: str, fixed: frozenset[str] = frozenset()) -> T:
    """A frozen dataclass with what ``name=value&name=value`` says; the rest stays.

    Fields of configurations inside it are named without theirs.

    Args:
        config: An instance of a dataclass.
        text: What stands after the ``?``.
        fixed: Names that cannot be chosen.

    Raises:
        InvalidInputError: An unknown or repeated name, or a value of the wrong kind.
    """
    return replace(config, **_chosen(_of_config(config), text, fixed))  # type: ignore[type-var]


def keyword_arguments(factory: Callable[..., object], text: str) -> dict[str, object]:
    """The keyword arguments of a function or class that ``name=value&name=value`` says.

    Values are read by the arguments' annotations. An argument that is a dataclass is given by the
    names of its fields. The ``seed`` is not chosen here.

    Raises:
        InvalidInputError: An unknown or repeated name, or a value of the wrong kind.
    """
    try:
        described = inspect.signature(factory).parameters.values()
        plain = isinstance(factory, type) and not is_dataclass(factory)
        hints = get_type_hints(factory.__init__ if plain else factory)
    except (ValueError, TypeError, NameError) as error:
        raise InvalidInputError(f"its arguments cannot be read ({error})") from error
    named = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)
    parameters = {
        one.name: _Parameter(hints.get(one.name, _kind_of(one.default)), one.default)
        for one in described
        if one.kind in named and one.name != "seed"
    }
    return _chosen(parameters, text, frozenset())


def _kind_of(default: object) -> object:
    return type(default) if isinstance(default, bool | int | float) else str


def _of_config(config: object) -> dict[str, _Parameter]:
    hints = get_type_hints(type(config))
    return {
        field.name: _Parameter(hints[field.name], getattr(config, field.name))
        for field in fields(config)  # type: ignore[arg-type]
        if field.init
    }


def _chosen(
    parameters: Mapping[str, _Parameter], text: str, fixed: frozenset[str]
) -> dict[str, object]:
    places: dict[str, tuple[str | None, object]] = {}
    nested = {name: one.nested for name, one in parameters.items()}
    for name, parameter in parameters.items():
        if nested[name] is None:
            places[name] = None, parameter.hint
        else:
            inside = _of_config(nested[name])
            places.update({n: (name, one.hint) for n, one in inside.items() if n not in places})
    places = {name: place for name, place in places.items() if name not in fixed}
    chosen: dict[str, object] = {}
    groups: dict[str, dict[str, object]] = {}
    for name, value in _pairs(text, places):
        owner, hint = places[name]
        into = chosen if owner is None else groups.setdefault(owner, {})
        into[name] = _value(name, value, hint)
    return chosen | {owner: replace(nested[owner], **group) for owner, group in groups.items()}


def _pairs(text: str, valid: Mapping[str, object]) -> list[tuple[str, str]]:
    pairs: dict[str, str] = {}
    for part in text.split("&"):
        name, equals, value = part.partition("=")
        if not equals:
            raise InvalidInputError(
                f"{part!r} is no hyper-parameter; valid is name=value&name=value"
            )
        if name not in valid:
            known = f"one of {', '.join(valid)}" if valid else "none"
            raise InvalidInputError(f"unknown hyper-parameter {name!r}; valid is {known}")
        if name in pairs:
            raise InvalidInputError(f"hyper-parameter {name} is given twice")
        pairs[name] = value
    return list(pairs.items())


def _value(name: str, text: str, hint: object) -> object:
    """A text as a value of an annotation."""
    if get_origin(hint) is Literal:
        named = {str(value): value for value in get_args(hint)}
        if text not in named:
            raise InvalidInputError(f"{name} is {text!r}, valid is one of {', '.join(named)}")
        return named[text]
    if NoneType in get_args(hint):  # X | None
        if text == "none":
            return None
        others = [one for one in get_args(hint) if one is not NoneType]
        return _value(name, text, others[0])
    if hint is bool:
        if text not in ("true", "false"):
            raise InvalidInputError(f"{name} is {text!r}, valid is true or false")
        return text == "true"
    if hint in _NUMBERS:
        kind = int if hint is int else float
        try:
            return kind(text)
        except ValueError as error:
            raise InvalidInputError(f"{name} is {text!r}, valid is {_NUMBERS[hint]}") from error
    if hint is str or hint is object or hint is Any:
        return text
    kind_name = getattr(hint, "__name__", str(hint))
    raise InvalidInputError(f"{name} is a {kind_name}, which cannot be given after a '?'")
