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
from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.dtw import dtw
from dressing_sim.learning.frame import FloatArray, Frame, stack_frames
from dressing_sim.learning.transport import Transport

#: How far the tips of the axes that are landmarks are from their frame's origin, and over which
#: displacements of landmarks are alike, as fractions of a path's length; how far a landmark may be
#: missed, as a fraction of how far landmarks are displaced. Of situations of which nothing is known
#: but their frames; demonstrations are only compared in such a situation, so little depends on it.
_TIP, ALIKE, MISSED = 0.25, 0.5, 0.05


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


def moving_part(positions: FloatArray, dt: float, still: float) -> tuple[FloatArray, FloatArray]:
    """A path without standing still at its start and end, cut where it crosses the distance.

    It is cut between samples, so that the sampling rate does not matter as it does for `moving`.

    Args:
        positions: The path (T, p).
        dt: Time between two of its rows [s].
        still: See `moving`.

    Returns:
        Positions (N, p), and their times (N,) on the path's own clock [s].
    """
    times: FloatArray = np.arange(len(positions), dtype=np.float64) * float(dt)
    if still == 0.0:
        return positions, times
    rows = moving(positions, still)
    reach = still * path_length(positions)
    first = _crossing(positions[rows.start : rows.start + 2], positions[0], reach)
    last = _crossing(positions[rows.stop - 2 : rows.stop][::-1], positions[-1], reach)
    begin = times[rows.start] + first * dt
    end = times[rows.stop - 1] - last * dt
    inner = times[(times > begin) & (times < end)]
    if len(inner) < 1:
        return positions, times
    kept = np.concatenate([[begin], inner, [end]])
    return at_times(positions, times, kept), kept


def _crossing(step: FloatArray, centre: FloatArray, reach: float) -> float:
    """Which fraction of a step (2, p) is within a distance of a point; it begins within."""
    offset, way = step[0] - centre, step[1] - step[0]
    a, b, c = way @ way, offset @ way, offset @ offset - reach**2
    if not (a > 0.0 and c < 0.0):
        return 0.0
    return float(np.clip((np.sqrt(b * b - a * c) - b) / a, 0.0, 1.0))


def path_length(path: FloatArray) -> float:
    """Length of a path (T, p), in the unit of the positions."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def at_times(positions: FloatArray, times: FloatArray, wanted: FloatArray) -> FloatArray:
    """A path (T, p) passed at times (T,), at other times (N,): (N, p), by interpolation."""
    return np.column_stack([np.interp(wanted, times, column) for column in positions.T])


def by_length(
    positions: FloatArray, dt: float | FloatArray, cuts: Sequence[int], rows: int
) -> Phased:
    """A path cut at rows of its own, each piece resampled evenly along its length.

    Args:
        positions: (T, p).
        dt: Time between two of its rows, or when each is passed (T,) [s].
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
    passed = dt if isinstance(dt, np.ndarray) else np.arange(len(positions)) * dt
    times = np.interp(places, length, passed)
    points = np.column_stack([np.interp(places, length, column) for column in positions.T])
    inner = tuple(int(cut) for cut in (rows - 1) * np.arange(1, len(edges) - 1))
    return Phased(points, times, inner)


def by_phase(demonstration: DemonstrationLike, still: float, rows: int) -> Phased:
    """The moving part of a demonstration, evenly along its length; its times begin with zero.

    Args:
        demonstration: The demonstration.
        still: See `moving`.
        rows: Of the result.
    """
    positions, times = moving_part(np.asarray(demonstration.positions), demonstration.dt, still)
    return by_length(positions, times - times[0], [], rows)


def landmarks_of(frames: Sequence[Frame], scale: float) -> FloatArray:
    """The `corners` of frames, with axes as long as suits a path of a length, the scale: (K, p)."""
    return corners(frames, _TIP * scale)


def corners(frames: Sequence[Frame], reach: float) -> FloatArray:
    """Origins of frames and tips of their axes, whatever the scale of a frame's own: (K, p).

    Args:
        frames: P frames of dimension p; K = P (1 + p).
        reach: Length of the axes, in the unit of the positions.
    """
    bases, origins = stack_frames(frames)
    p = origins.shape[1]
    size = np.abs(np.linalg.det(bases)) ** (1.0 / p)
    tips = reach * (bases / size[:, None, None]).transpose(0, 2, 1)
    points = np.concatenate([origins[:, None], origins[:, None] + tips], axis=1)
    return points.reshape(-1, p)


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
