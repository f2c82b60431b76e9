"""Rows kept as columns."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

#: For how many rows there is room at first.
_ROOM = 64


class Columns:
    """A table that grows by rows, each column of it one array.

    Args:
        columns: What is in it at first, by name, of the same length.
    """

    def __init__(self, columns: Mapping[str, NDArray[Any]] | None = None) -> None:
        # They may be read-only, and the table goes on in arrays of its own.
        self._arrays = {name: np.array(column) for name, column in (columns or {}).items()}
        self._n_rows = self._room = len(next(iter(self._arrays.values()), ()))

    def __len__(self) -> int:
        return self._n_rows

    def append(self, row: Mapping[str, Any]) -> None:
        """Add a row: a number, a truth value or an array of each column that there is."""
        if self._n_rows == self._room:
            self._make_room(row)
        for name, value in row.items():
            self._arrays[name][self._n_rows] = value
        self._n_rows += 1

    def _make_room(self, row: Mapping[str, Any]) -> None:
        room = max(_ROOM, 2 * self._room)
        for name, value in row.items():
            one = np.asarray(value)
            column = np.empty((room, *one.shape), one.dtype)
            column[: self._n_rows] = self._arrays.get(name, column[:0])
            self._arrays[name] = column
        self._room = room

    def value(self, name: str, row: int) -> NDArray[Any]:
        """What a column holds in a row, from 0."""
        return np.array(self._arrays[name][: self._n_rows][row])

    def copies(self) -> dict[str, NDArray[Any]]:
        """Every column, of all rows."""
        return {name: column[: self._n_rows].copy() for name, column in self._arrays.items()}
