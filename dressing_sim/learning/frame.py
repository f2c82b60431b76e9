"""Task parameters: coordinate frames, and the situations that are tuples of them."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.errors import InvalidInputError

FloatArray: TypeAlias = NDArray[np.float64]

LARGEST_CONDITION = 1e8  # beyond it, half of the digits of a local coordinate are noise


@dataclass(frozen=True, eq=False)
class Frame:
    """A task parameter (A, b): ``world = A local + b``.

    Attributes:
        A: (p, p) basis, its columns in world coordinates; any invertible matrix (a rotation, a
            scaled rotation, a reflection, a shear).
        b: (p,) origin in world coordinates, in the unit of the positions (metres for the robot).

    Raises:
        InvalidInputError: shapes that do not match, values that are not finite, or a singular A.

    Source: Zhu, Gienger and Kober (2022), section III-A; Calinon (2016).
    """

    A: FloatArray
    b: FloatArray

    def __post_init__(self) -> None:
        basis = np.array(self.A, dtype=np.float64)
        origin = np.array(self.b, dtype=np.float64)
        if origin.ndim != 1 or basis.shape != (origin.size, origin.size):
            raise InvalidInputError(
                f"a frame needs A of shape (p, p) and b of shape (p,), "
                f"not {basis.shape} and {origin.shape}"
            )
        if not (np.isfinite(basis).all() and np.isfinite(origin).all()):
            raise InvalidInputError("a frame's A and b must be finite")
        if not np.linalg.cond(basis) < LARGEST_CONDITION:
            raise InvalidInputError(f"a frame's A must be invertible, not {basis.tolist()}")
        basis.flags.writeable = False
        origin.flags.writeable = False
        object.__setattr__(self, "A", basis)
        object.__setattr__(self, "b", origin)

    @property
    def dimension(self) -> int:
        """Number of coordinates p."""
        return self.b.size

    def to_world(self, points: ArrayLike) -> FloatArray:
        """Points (..., p) in this frame -> the same points in world coordinates."""
        return self._checked(points) @ self.A.T + self.b

    def to_local(self, points: ArrayLike) -> FloatArray:
        """Points (..., p) in world coordinates -> the same points in this frame."""
        return self.displacements_to_local(self._checked(points) - self.b)

    def displacements_to_world(self, displacements: ArrayLike) -> FloatArray:
        """Differences of points (..., p) in this frame -> world; the origin has no part in it."""
        return self._checked(displacements) @ self.A.T

    def displacements_to_local(self, displacements: ArrayLike) -> FloatArray:
        """Differences of points (..., p) in world coordinates -> this frame."""
        values = self._checked(displacements)
        flat = np.linalg.solve(self.A, values.reshape(-1, self.dimension).T).T
        return np.asarray(flat, dtype=np.float64).reshape(values.shape)

    def _checked(self, values: ArrayLike) -> FloatArray:
        """Values (..., p) as an array."""
        array = np.asarray(values, dtype=np.float64)
        if array.shape[-1:] != (self.dimension,):
            raise InvalidInputError(
                f"an array has the shape {array.shape}, valid is (..., {self.dimension})"
            )
        return array

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Frame):
            return NotImplemented
        return np.array_equal(self.A, other.A) and np.array_equal(self.b, other.b)

    def __hash__(self) -> int:
        # Equal frames, equal bytes: adding zero makes 0.0 of -0.0.
        return hash(((self.A + 0.0).tobytes(), (self.b + 0.0).tobytes()))


Situation: TypeAlias = tuple[Frame, ...]


def stack_frames(frames: Sequence[Frame]) -> tuple[FloatArray, FloatArray]:
    """Bases (P, p, p) and origins (P, p) of a situation of P frames.

    Raises:
        InvalidInputError: no frame, or frames of different dimension.
    """
    if not frames:
        raise InvalidInputError("a situation needs at least one frame")
    if len({frame.dimension for frame in frames}) > 1:
        raise InvalidInputError("the frames of a situation must have the same dimension")
    return np.stack([frame.A for frame in frames]), np.stack([frame.b for frame in frames])
