"""Recordings as tables: CSV with a line of names, and NPZ. Each name ends with its unit."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from dressing_sim.archives import check_size, read_npz, unreadable
from dressing_sim.checks import real_array, shown
from dressing_sim.datasets.recording import QUANTITIES, LabRecording, of_columns
from dressing_sim.errors import InvalidInputError, one_line

Array = NDArray[np.float64]

#: Largest CSV file [bytes], and its longest line in columns.
MOST_CSV_BYTES = 64 * 2**20
MOST_COLUMNS = 1000

_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}

#: Units that the name of a quantity may end with, in SI units; quaternions have none.
UNITS: Mapping[str, Mapping[str, float]] = {
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "gripper": _LENGTHS,
    "force": {"n": 1.0},
    "shoulder": _LENGTHS,
    "elbow": _LENGTHS,
    "wrist": _LENGTHS,
}

#: Names of a quantity's columns in CSV.
_AXES = {3: ("x", "y", "z"), 4: ("x", "y", "z", "w")}


def read_table(path: str | Path) -> LabRecording:
    """A recording in a CSV or NPZ file; columns that are none of ours are left alone.

    CSV: ``time_s``, ``gripper_x_mm``, ``gripper_y_mm``, ``gripper_z_mm``, ``quaternion_x`` ...,
    ``force_x_n`` ..., ``shoulder_x_mm`` ..., ``elbow_x_mm`` ..., ``wrist_x_mm`` .... NPZ: arrays
    ``time_s`` (T,), ``gripper_mm`` (T, 3), ``quaternion`` (T, 4) and so on; those of the arm may be
    (3,). Times count from whenever.

    Raises:
        InvalidInputError: It cannot be read, or is no recording; see `LabRecording`.
    """
    path = Path(path)
    given = read_npz(path) if path.suffix == ".npz" else _csv_columns(path)
    try:
        if path.suffix != ".npz":
            given = _whole(given)
        columns = {}
        for name, values in given.items():
            quantity, factor = _named(name)
            if quantity is None:
                continue
            if quantity in columns:
                raise InvalidInputError(f"{quantity} is there twice; valid is one unit of it")
            if quantity == "time" and values.dtype.kind in "iu" and values.ndim == 1:
                # Nanoseconds since 1970 have more digits than float64: count from the first.
                values = values.astype(np.int64) - values[:1].astype(np.int64)
            columns[quantity] = factor * real_array(values, None, f"{name} has")
        return of_columns(path.stem, columns)
    except InvalidInputError as error:
        raise InvalidInputError(f"{path}: {error}") from error


def _named(name: str) -> tuple[str | None, float]:
    """The quantity that a name is of, or None, and its unit."""
    if name in QUANTITIES and name not in UNITS:
        return name, 1.0
    stem, _, unit = name.rpartition("_")
    bare = name if name in UNITS else stem if stem in UNITS else None
    if bare is None:
        return None, 1.0
    units = UNITS[bare]
    if bare == name or unit not in units:
        valid = ", ".join(f"{bare}_{one}" for one in units)
        raise InvalidInputError(f"{shown(name)} names no unit that is known; valid is {valid}")
    return bare, units[unit]


def _whole(columns: Mapping[str, Array]) -> dict[str, Array]:
    """Columns of one axis each, put together: ``gripper_x_mm`` and two more are ``gripper_mm``."""
    whole: dict[str, Array] = {}
    for name in columns:
        for quantity, count in QUANTITIES.items():
            axes = _AXES[count]
            rest = name.removeprefix(f"{quantity}_x")
            if rest == name or (rest and not rest.startswith("_")):
                continue
            parts = [f"{quantity}_{axis}{rest}" for axis in axes]
            missing = [part for part in parts if part not in columns]
            if missing:
                raise InvalidInputError(f"no column {missing[0]}; valid is {', '.join(parts)}")
            whole[f"{quantity}{rest}"] = np.column_stack([columns[part] for part in parts])
    return whole | {name: columns[name] for name in columns if name.startswith("time")}


def _csv_columns(path: Path) -> dict[str, Array]:
    """The columns of a CSV file that are ours, by the names in its first line."""
    check_size(path, MOST_CSV_BYTES)
    try:
        with path.open(encoding="utf-8-sig", newline="") as file:
            reader = csv.reader(line for line in file if line.strip() and line[0] != "#")
            heading = [name.strip() for name in next(reader, [])]
            if len(set(heading)) < len(heading) or len(heading) > MOST_COLUMNS:
                raise InvalidInputError(
                    f"{path}: its first line is {shown(heading)}, valid is one line with another "
                    "name for each column"
                )
            ours = [
                (place, name)
                for place, name in enumerate(heading)
                if name.startswith(("time", *QUANTITIES))
            ]
            rows: list[list[int | float]] = []
            for row in reader:
                rows.append([_number(row, place, name, path, len(rows)) for place, name in ours])
    except OSError as error:
        raise unreadable(path, error) from error
    except (csv.Error, UnicodeDecodeError) as error:
        raise InvalidInputError(f"{path}: not CSV ({one_line(str(error))})") from error
    if not rows:
        raise InvalidInputError(f"{path}: no rows; valid is a line of names and lines of numbers")
    table = zip(*rows, strict=True)
    return {name: np.array(column) for (_, name), column in zip(ours, table, strict=False)}


def _number(row: list[str], place: int, name: str, path: Path, number: int) -> int | float:
    text = row[place].strip() if place < len(row) else ""
    try:
        if name.startswith("time") and text.isascii() and text.isdigit() and len(text) < 19:
            return int(text)
        return float(text)
    except ValueError as error:
        raise InvalidInputError(
            f"{path}: {shown(name)} in row {number} is {shown(text)}, valid is a number"
        ) from error
