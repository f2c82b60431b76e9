"""What the library needs of a demonstration, and the demonstrations it makes itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.frame import FloatArray, Frame, Situation

FEWEST_SAMPLES = 3


@runtime_checkable
class DemonstrationLike(Protocol):
    """Anything with a path, its sampling time and its situation; no base class is needed."""

    @property
    def positions(self) -> FloatArray:
        """(T, p) positions in world coordinates."""

    @property
    def dt(self) -> float:
        """Time between two samples in [s]."""

    @property
    def frames(self) -> Sequence[Frame]:
        """The situation: the same number of frames, in the same order, in every demonstration."""


@dataclass(frozen=True, eq=False)
class SyntheticDemonstration:
    """A path made by the library (or by a test) with its situation.

    Attributes:
        positions: (T, p) positions in world coordinates.
        dt: time between two samples in [s].
        frames: the situation; any sequence of frames, kept as a `Situation`.
    """

    positions: FloatArray
    dt: float
    frames: Sequence[Frame]

    def __post_init__(self) -> None:
        positions = np.array(self.positions, dtype=np.float64)
        positions.flags.writeable = False
        object.__setattr__(self, "positions", positions)
        object.__setattr__(self, "frames", Situation.of(self.frames))


def check_demonstrations(
    demonstrations: Sequence[DemonstrationLike],
) -> tuple[DemonstrationLike, ...]:
    """The demonstrations as a tuple, once they can be learned from.

    Raises:
        InvalidInputError: naming the first demonstration that is too short, not finite, standing
            still, or whose frames do not match the first one's.
    """
    checked = tuple(demonstrations)
    if not checked:
        raise InvalidInputError("at least one demonstration is needed, got none")
    n_frames = len(checked[0].frames)
    dimension = np.asarray(checked[0].positions).shape[-1]
    for index, demonstration in enumerate(checked):
        fault = _fault(demonstration, n_frames, dimension)
        if fault:
            raise InvalidInputError(f"demonstration {index} {fault}")
    return checked


def _fault(demonstration: DemonstrationLike, n_frames: int, dimension: int) -> str | None:
    positions = np.asarray(demonstration.positions)
    if positions.ndim != 2 or positions.shape[1] != dimension:
        return f"needs positions of shape (T, {dimension}), not {positions.shape}"
    if len(positions) < FEWEST_SAMPLES:
        return f"has {len(positions)} samples; at least {FEWEST_SAMPLES} are needed"
    if not np.isfinite(positions).all():
        return "has positions that are not finite"
    if not (np.isfinite(demonstration.dt) and demonstration.dt > 0):
        return f"needs dt > 0, not {demonstration.dt}"
    if len(demonstration.frames) != n_frames or n_frames == 0:
        return f"has {len(demonstration.frames)} frames where {max(n_frames, 1)} are needed"
    if any(frame.dimension != dimension for frame in demonstration.frames):
        return f"needs frames of dimension {dimension}"
    extent = np.ptp(positions, axis=0).max()
    if not extent > 1e-9 * (1.0 + np.abs(positions).max()):
        return "stands still: there is no motion to learn from"
    return None


def duration(demonstration: DemonstrationLike) -> float:
    """Time from the first to the last sample in [s]."""
    return (len(demonstration.positions) - 1) * float(demonstration.dt)


def resample(positions: FloatArray, dt: float, new_dt: float) -> FloatArray:
    """A path (T, p) sampled at ``dt`` -> sampled at ``new_dt``, by linear interpolation.

    The last sample is kept: the path is held there for the part of a step that is left over.
    """
    if abs(dt - new_dt) <= 1e-12 * dt:
        return np.asarray(positions, dtype=np.float64)
    times = np.arange(len(positions)) * dt
    count = int(np.ceil(times[-1] / new_dt - 1e-9)) + 1
    wanted = np.arange(count) * new_dt
    return np.stack([np.interp(wanted, times, column) for column in np.asarray(positions).T], 1)


def in_frames(positions: FloatArray, frames: Sequence[Frame]) -> FloatArray:
    """A path (T, p) in world coordinates seen from each frame: (P, T, p)."""
    return np.stack([frame.to_local(positions) for frame in frames])
