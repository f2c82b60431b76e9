"""Demonstrations brought into phase: the same row is the same moment of the task in all of them.

Each is trimmed of standing still, cut at events of its own motion, the same ones in all, and each
piece resampled evenly along its length. What is then left is aligned by dynamic time warping, after
all were carried to one situation: only there can they be compared.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.dtw import dtw
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.transport import Transport


@dataclass(frozen=True, eq=False)
class Phased:
    """A path by phase instead of time.

    Attributes:
        points: Positions (N, p) at N phases.
        times: When they were passed, (N,), from zero, never falling [s].
        cuts: Rows at which it was cut.
    """

    points: FloatArray
    times: FloatArray
    cuts: tuple[int, ...] = ()


def moving(positions: FloatArray, still: float) -> slice:
    """The rows between standing still at the start and at the end of a path (T, p).

    Args:
        positions: The path.
        still: It stands still while it is within this fraction of its length of an end.
    """
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    reach = still * float(steps.sum())
    begun = np.linalg.norm(positions - positions[0], axis=1) > reach
    to_go = np.linalg.norm(positions - positions[-1], axis=1) > reach
    first = max(int(np.argmax(begun)) - 1, 0)
    last = len(positions) - max(int(np.argmax(to_go[::-1])) - 1, 0)
    return slice(first, last) if last - first > 2 else slice(0, len(positions))


def by_length(positions: FloatArray, dt: float, cuts: Sequence[int], rows: int) -> Phased:
    """A path cut at rows of its own, each piece resampled evenly along its length.

    Args:
        positions: (T, p).
        dt: Time between two of its rows [s].
        cuts: Rows at which it is cut, rising, neither the first nor the last.
        rows: Of each piece; neighbours share one.

    Raises:
        InvalidInputError: Cuts that do not rise.
    """
    edges = [0, *cuts, len(positions) - 1]
    if np.any(np.diff(edges) <= 0):
        raise InvalidInputError(
            f"cuts at {[*cuts]} of {len(positions)} rows, valid are rising ones"
        )
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    # A trace of time keeps the length rising where the path rests.
    length = np.concatenate([[0.0], np.cumsum(steps + 1e-9 * steps.sum())])
    places = np.interp(
        np.arange((len(edges) - 1) * (rows - 1) + 1) / (rows - 1),
        np.arange(len(edges)),
        length[edges],
    )
    times = np.interp(places, length, np.arange(len(positions)) * dt)
    points = np.column_stack([np.interp(places, length, column) for column in positions.T])
    inner = tuple(int(cut) for cut in (rows - 1) * np.arange(1, len(edges) - 1))
    return Phased(points, times, inner)


def in_phase(
    paths: Sequence[Phased],
    landmarks: Sequence[FloatArray],
    length: float,
    noise: float,
    width: float,
) -> list[Phased]:
    """Paths with the same cuts, aligned between the cuts with the first of them.

    Args:
        paths: All with the same number of rows.
        landmarks: Of each path's situation, (K, p).
        length: See `Transport.between`.
        noise: The like.
        width: Over which fraction of a piece the alignment is smoothed.
    """
    reference = paths[0]
    aligned = [reference]
    for path, own in zip(paths[1:], landmarks[1:], strict=True):
        carried = Transport.between(own, landmarks[0], length, noise)(path.points)
        edges = [0, *path.cuts, len(carried) - 1]
        rows = [np.zeros(1)]
        for begin, end in pairwise(edges):
            piece = slice(begin, end + 1)
            found = _warped(carried[piece], reference.points[piece], width)
            rows.append(begin + found[1:])
        aligned.append(_at(path, np.concatenate(rows)))
    return aligned


def _at(path: Phased, rows: FloatArray) -> Phased:
    """A path at fractions of its rows, by linear interpolation."""
    own = np.arange(len(path.points))
    points = np.column_stack([np.interp(rows, own, column) for column in path.points.T])
    return Phased(points, np.interp(rows, own, path.times), path.cuts)


def _warped(path: FloatArray, reference: FloatArray, width: float) -> FloatArray:
    """Where in a path (N, p) each row of a reference (N, p) is: (N,), rising, its ends kept."""
    pairs = dtw(reference, path).path
    own = np.arange(len(reference), dtype=np.float64)
    matched: NDArray[np.float64] = np.bincount(pairs[:, 0], pairs[:, 1]) / np.bincount(pairs[:, 0])
    # Where paths are not alike the best alignment waits and leaps: its smooth part is kept.
    fade = np.minimum(1.0, np.minimum(own, own[::-1]) / (2.0 * width * len(own)))
    rows = own + fade * smoothed((matched - own)[:, None], width)[:, 0]
    return np.clip(np.maximum.accumulate(rows), 0.0, own[-1])


def smoothed(values: FloatArray, width: float) -> FloatArray:
    """Rows (N, p) averaged with a Gaussian whose standard deviation is a fraction of them."""
    return np.asarray(_averaging(len(values), width) @ values)


@lru_cache(maxsize=4)
def _averaging(count: int, width: float) -> FloatArray:
    """The matrix (N, N) of `smoothed`; a policy asks for the same one again and again."""
    rows = np.arange(count)
    weights = np.exp(-0.5 * ((rows[:, None] - rows) / (width * count)) ** 2)
    weights /= weights.sum(axis=1, keepdims=True)
    weights.flags.writeable = False
    return weights
