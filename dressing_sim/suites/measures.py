"""TOML files of measurements: every key names its unit, and has a range that it must be in."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from dressing_sim.archives import read_toml
from dressing_sim.checks import clean_name, of_kind, one_of, real_number, shown
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets, is_file


@dataclass(frozen=True, slots=True)
class Measure:
    """A number that a file may have.

    Attributes:
        unit: As its key says.
        low: The least that is meant.
        high: The most.
        what: How it is measured.
    """

    unit: str
    low: float
    high: float
    what: str


@dataclass(frozen=True, slots=True)
class Choice:
    """A text that a file may have: one of some names, or any that can be printed.

    Attributes:
        what: What it says.
        names: What is valid; any name if empty.
    """

    what: str
    names: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Each:
    """Tables that a file may have by names of its own, all of the same keys.

    Attributes:
        name: What the names are of.
        schema: What each of the tables may say.
    """

    name: str
    schema: Schema


#: What a file may say, by key; a table within a file is a mapping.
Schema = Mapping[str, "Measure | Choice | Each | Schema"]

Values = dict[str, Any]

T = TypeVar("T")


def read_measures(path: str | Path, kind: str, schema: Schema) -> Values:
    """The values of a file, once all of its keys are known and all values in their ranges.

    Args:
        path: A TOML file.
        kind: What it is of, for errors.
        schema: What it may say; nothing must be there.

    Raises:
        InvalidInputError: It cannot be read, is not TOML, or says something else.
    """
    try:
        return _checked(read_toml(path), schema, "")
    except InvalidInputError as error:
        raise InvalidInputError(f"{kind} {path}: {str(error).removeprefix(f'{path}: ')}") from error


def _checked(values: Mapping[str, Any], schema: Schema, inside: str) -> Values:
    checked: Values = {}
    for key, value in values.items():
        name, wanted = f"{inside}{key}", schema.get(key)
        if wanted is None:
            raise InvalidInputError(
                f"unknown key {shown(name)}; valid are {', '.join(inside + one for one in schema)}"
            )
        if isinstance(wanted, Measure):
            bounds = wanted.low, wanted.high
            checked[key] = real_number(value, f"{name} [{wanted.unit}]", *bounds)
        elif isinstance(wanted, Choice) and wanted.names:
            one_of(value, name, wanted.names)
            checked[key] = value
        elif isinstance(wanted, Choice):
            checked[key] = clean_name(value, name)
        elif isinstance(value, Mapping) and isinstance(wanted, Each):
            tables = {clean_name(one, f"{name}: a name"): wanted.schema for one in value}
            checked[key] = _checked(value, tables, f"{name}.")
        elif isinstance(value, Mapping) and not isinstance(wanted, Each):
            checked[key] = _checked(value, wanted, f"{name}.")
        else:
            raise InvalidInputError(f"{name} is {shown(value)}, valid is a table of measures")
    return checked


def find_file(name_or_file: str, kind: str, folder: str, others: Mapping[str, object]) -> Path:
    """The file of a name that comes with the package, or a file of the user's.

    Args:
        name_or_file: Which.
        kind: What it is of, for errors.
        folder: Of ``assets``.
        others: What else is known by a name.

    Raises:
        InvalidInputError: There is none.
    """
    builtin = sorted((assets() / folder).glob("*.toml"))
    for path in builtin:
        if path.stem == name_or_file:
            return path
    if not is_file(name_or_file):
        known = ", ".join([*others, *(path.stem for path in builtin)])
        raise InvalidInputError(
            f"unknown {kind} {shown(name_or_file)}; valid is one of {known}, or a TOML file"
        )
    return Path(name_or_file)


def load_named(
    name_or_file: str,
    kind: str,
    known: Mapping[str, T],
    folder: str,
    schema: Schema,
    made: Callable[[Values], T],
) -> T:
    """What a name says, or a file of measures.

    Args:
        name_or_file: Which.
        kind: What it is, for errors.
        known: By name, without a file.
        folder: Of ``assets``, with more by name.
        schema: What a file may say.
        made: What a file's values make.

    Raises:
        InvalidInputError: There is none, or the file is not valid.
    """
    if of_kind(name_or_file, str, f"a {kind}", "a name or a TOML file") in known:
        return known[name_or_file]
    path = find_file(name_or_file, kind, folder, known)
    values = read_measures(path, kind, schema)
    try:
        return made(values)
    except InvalidInputError as error:
        raise InvalidInputError(f"{kind} {path}: {error}") from error


def schema_table(schema: Schema, inside: str = "") -> list[str]:
    """A schema as lines of a Markdown table: key, unit, range, what it is."""
    lines = []
    for key, wanted in schema.items():
        name = f"`{inside}{key}`"
        if isinstance(wanted, Measure):
            valid = f"{wanted.low:g} to {wanted.high:g}"
            lines.append(f"| {name} | {wanted.unit} | {valid} | {wanted.what} |")
        elif isinstance(wanted, Choice):
            named = ", ".join(f"`{one}`" for one in wanted.names) or "a name"
            lines.append(f"| {name} | - | {named} | {wanted.what} |")
        elif isinstance(wanted, Each):
            lines += schema_table(wanted.schema, f"{inside}{key}.{wanted.name}.")
        else:
            lines += schema_table(wanted, f"{inside}{key}.")
    return lines
