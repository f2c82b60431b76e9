"""Demonstrations brought into phase: the same row is the same moment of the task in all of them.

Each is trimmed of standing still, cut at events of its own motion (the same ones in all), and each
piece resampled evenly along its length; what is left is aligned by dynamic time warping with a
reference, on coordinates in which demonstrations can be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.dtw import dtw
from dressing_sim.learning.frame import FloatArray


@dataclass(frozen=True, eq=False)
class Phased:
    """A path by phase instead of time.

    Attributes:
        points: Positions (N, p) at N phases.
        times: When they were passed, (N,), from zero, never falling [s].
    """

    points: FloatArray
    times: FloatArray

    def at(self, rows: FloatArray) -> Phased:
        """The path at other phases, (n,) fractions of rows, by linear interpolation."""
        own = np.arange(len(self.points), dtype=np.float64)
        points = np.column_stack([np.interp(rows, own, column) for column in self.points.T])
        return Phased(points, np.interp(rows, own, self.times))


def moving(positions: FloatArray, still: float) -> slice:
    """The rows between standing still at the start and at the end of a path (T, p).

    Args:
        positions: The path.
        still: It stands still while it is within this fraction of its length of an end.
    """
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    reach = still * float(steps.sum())
    left = np.linalg.norm(positions - positions[0], axis=1) > reach
    right = np.linalg.norm(positions - positions[-1], axis=1) > reach
    first = max(int(np.argmax(left)) - 1, 0)
    last = len(positions) - max(int(np.argmax(right[::-1])) - 1, 0)
    return slice(first, last) if last - first > 1 else slice(0, len(positions))


def by_length(positions: FloatArray, dt: float, cuts: Sequence[int], rows: int) -> Phased:
    """A path cut at rows of its own, each piece resampled evenly along its length.

    Args:
        positions: (T, p).
        dt: Time between two of its rows [s].
        cuts: Rows at which it is cut, rising, neither the first nor the last.
        rows: Of each piece; neighbours share one.
    """
    edges = [0, *cuts, len(positions) - 1]
    if any(b <= a for a, b in zip(edges, edges[1:], strict=False)):
        raise InvalidInputError(f"cuts at {[*cuts]} of {len(positions)} rows; valid are rising ones")
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    # A trace of time keeps the length rising where the path rests.
    steps = steps + 1e-9 * (steps.sum() + 1.0)
    length = np.concatenate([[0.0], np.cumsum(steps)])
    pieces = [
        np.linspace(length[a], length[b], rows)[(0 if a == 0 else 1) :]
        for a, b in zip(edges, edges[1:], strict=False)
    ]
    wanted = np.concatenate(pieces)
    points = np.column_stack([np.interp(wanted, length, column) for column in positions.T])
    return Phased(points, np.interp(wanted, length, np.arange(len(positions)) * dt))


def warped_rows(
    path: FloatArray, reference: FloatArray, smooth: float
) -> FloatArray:
    """Where in a path (N, p) each row of a reference (N, p) is, (N,), rising.

    The alignment is the one of `dtw`, smoothed: it has steps where the paths are not alike.

    Args:
        path: In coordinates in which it can be compared with the reference.
        reference: The like.
        smooth: Width of the smoothing as a fraction of the rows.
    """
    pairs = dtw(reference, path).path
    count = np.bincount(pairs[:, 0], minlength=len(reference))
    rows: NDArray[np.float64] = np.bincount(pairs[:, 0], pairs[:, 1]) / count
    own = np.arange(len(reference), dtype=np.float64)
    slack = rows - own * (len(path) - 1) / (len(reference) - 1)
    width = smooth * len(reference)
    kernel = np.exp(-0.5 * ((own[:, None] - own[None]) / width) ** 2)
    # Pinned at both ends, where the paths meet.
    fade = np.minimum(1.0, np.minimum(own, own[::-1]) / (2.0 * width))
    smoothed = fade * (kernel @ slack) / kernel.sum(axis=1)
    found = own * (len(path) - 1) / (len(reference) - 1) + smoothed
    return np.clip(np.maximum.accumulate(found), 0.0, len(path) - 1.0)
