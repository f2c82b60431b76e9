"""What the library needs of a demonstration, and the demonstrations it makes itself."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike

from dressing_sim.checks import LARGEST, listed, real_array, real_number, real_vector, shown
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
        named = "a demonstration's positions have"
        positions = np.array(real_array(self.positions, None, named, finite=False))
        positions.flags.writeable = False
        object.__setattr__(self, "positions", positions)
        frames = listed(self.frames, "a demonstration's frames", "a sequence of frames")
        if not isinstance(self.frames, Situation):
            object.__setattr__(self, "frames", Situation.of(frames))


def check_demonstrations(
    demonstrations: Sequence[DemonstrationLike],
) -> tuple[DemonstrationLike, ...]:
    """The demonstrations as a tuple, once they can be learned from.

    Raises:
        InvalidInputError: naming the first demonstration that is too short, not finite, standing
            still, or whose frames do not match the first one's.
    """
    checked = listed(demonstrations, "demonstrations", "a sequence of demonstrations")
    if not checked:
        raise InvalidInputError("at least one demonstration is needed, got none")
    first: tuple[int, int] | None = None
    for index, demonstration in enumerate(checked):
        try:
            first = _check(demonstration, first)
        except InvalidInputError as error:
            raise InvalidInputError(f"demonstration {index} {error}") from error
    return checked


def _check(demonstration: DemonstrationLike, first: tuple[int, int] | None) -> tuple[int, int]:
    """Number of frames and of dimensions, once they are the first one's and all else is fine."""
    if not isinstance(demonstration, DemonstrationLike):
        raise InvalidInputError(
            f"is {shown(demonstration)}, valid is something with positions, dt and frames"
        )
    frames = listed(demonstration.frames, "has frames: it", "a sequence of frames")
    faulty = [frame for frame in frames if not isinstance(frame, Frame)]
    if faulty:
        raise InvalidInputError(f"has {shown(faulty[0])} among its frames, valid are frames")
    width: int | str = "p" if first is None else first[1]
    positions = real_array(demonstration.positions, ("T", width), "has positions of")
    if len(positions) < FEWEST_SAMPLES:
        raise InvalidInputError(
            f"has {len(positions)} samples; at least {FEWEST_SAMPLES} are needed"
        )
    dimension = positions.shape[1]
    try:
        real_number(demonstration.dt, "its dt", 0.0, above=True)
    except InvalidInputError as error:
        raise InvalidInputError(f"needs dt > 0: {error}") from error
    n_frames = len(frames) if first is None else first[0]
    if len(frames) != n_frames or n_frames == 0:
        raise InvalidInputError(f"has {len(frames)} frames where {max(n_frames, 1)} are needed")
    if any(frame.dimension != dimension for frame in frames):
        raise InvalidInputError(f"needs frames of dimension {dimension}")
    extent = np.ptp(positions, axis=0).max(initial=0.0)
    if not extent > 1e-9 * (1.0 + np.abs(positions).max(initial=0.0)):
        raise InvalidInputError("stands still: there is no motion to learn from")
    return n_frames, dimension


def check_weights(weights: ArrayLike, count: int) -> FloatArray:
    """Weights of demonstrations (M,), once they are above zero.

    Raises:
        InvalidInputError: another number of them, or one that is not above zero.
    """
    values = real_vector(weights, count, f"weights of {count} demonstrations have")
    for index, value in enumerate(values):
        real_number(float(value), f"the weight of demonstration {index}", 0.0, LARGEST, above=True)
    return values


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
