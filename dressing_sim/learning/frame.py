"""Task parameters: coordinate frames, and the situations that are tuples of them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NoReturn, Self, SupportsIndex, TypeAlias, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.checks import listed, of_kind, real_array, shown
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
        basis = np.array(real_array(self.A, None, "a frame's A has"))
        origin = np.array(real_array(self.b, None, "a frame's b has"))
        if origin.ndim != 1 or basis.shape != (origin.size, origin.size) or origin.size == 0:
            raise InvalidInputError(
                f"a frame needs A of shape (p, p) and b of shape (p,), "
                f"not {basis.shape} and {origin.shape}"
            )
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
        return real_array(values, ("...", self.dimension), "points have")

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Frame):
            return NotImplemented
        return np.array_equal(self.A, other.A) and np.array_equal(self.b, other.b)

    def __hash__(self) -> int:
        # Equal frames, equal bytes: adding zero makes 0.0 of -0.0.
        return hash(((self.A + 0.0).tobytes(), (self.b + 0.0).tobytes()))


class Situation(tuple[Frame, ...]):
    """The frames that a policy is asked for, by place and, if they have names, by name.

    ``Situation(shoulder=a, wrist=b)`` has ``frames.shoulder``, ``frames["shoulder"]`` and
    ``frames[0]``; ``Situation(a, b)`` has no names. It is a tuple: it equals every tuple of the
    same frames, whatever their names.

    Args:
        frames: Frames without names.
        named: Frames by name, in their order; a situation has either names or none.

    Attributes:
        names: One a frame, or none.

    Raises:
        InvalidInputError: Some frames with and some without a name, something that is no frame, or
            a name that hides an attribute of tuples.
    """

    names: tuple[str, ...]

    def __new__(cls, *frames: Frame, **named: Frame) -> Self:
        """Check and keep the frames."""
        if frames and named:
            raise InvalidInputError("a situation has names for all of its frames or for none")
        taken = [name for name in named if hasattr(cls, name) or name in cls.__annotations__]
        if taken:
            raise InvalidInputError(f"a frame cannot be called {taken[0]!r}, valid is another name")
        self = super().__new__(cls, frames or named.values())
        others = [frame for frame in self if not isinstance(frame, Frame)]
        if others:
            raise InvalidInputError(f"a situation holds frames, not {shown(others[0])}")
        vars(self).update(named, names=tuple(named))
        return self

    @classmethod
    def of(cls, frames: Iterable[Frame], names: Sequence[str] = ()) -> Self:
        """The frames as a situation: as it is if it is one, else with the names given."""
        if isinstance(frames, cls) and not names:
            return frames
        frames = listed(frames, "frames", "a sequence of frames")
        if names:
            return cls(**dict(zip(names, frames, strict=True)))
        return cls(*frames)

    def __getattr__(self, name: str) -> Frame:
        # Reached for names that the situation has not; the others are in its dictionary.
        raise AttributeError(f"no frame {name!r}; valid is {self._valid()}")

    @overload
    def __getitem__(self, key: SupportsIndex | str) -> Frame: ...
    @overload
    def __getitem__(self, key: slice) -> tuple[Frame, ...]: ...
    def __getitem__(self, key: SupportsIndex | str | slice) -> Frame | tuple[Frame, ...]:
        """A frame by place or name, or a plain tuple of some of them."""
        if not isinstance(key, str):
            return super().__getitem__(key)
        if key not in self.names:
            raise KeyError(f"no frame {key!r}; valid is {self._valid()}")
        return self[self.names.index(key)]

    def _valid(self) -> str:
        return ", ".join(vars(self).get("names", ())) or "a number: the frames have no names"

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError("a situation cannot be changed")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError("a situation cannot be changed")

    def __reduce__(self) -> tuple[object, ...]:
        return type(self).of, (tuple(self), self.names)

    def __repr__(self) -> str:
        named = zip(self.names, self, strict=True)
        inside = [f"{name}={frame!r}" for name, frame in named] if self.names else map(repr, self)
        return f"Situation({', '.join(inside)})"


def situation(frames: Sequence[Frame]) -> tuple[Frame, ...]:
    """Frames as a tuple, once they are frames.

    Raises:
        InvalidInputError: Something else is among them.
    """
    found = listed(frames, "a situation", "a sequence of frames")
    for frame in found:
        of_kind(frame, Frame, "a frame of a situation", "a Frame")
    return found


def stack_frames(frames: Sequence[Frame]) -> tuple[FloatArray, FloatArray]:
    """Bases (P, p, p) and origins (P, p) of a situation of P frames.

    Raises:
        InvalidInputError: no frame, or frames of different dimension.
    """
    frames = situation(frames)
    if not frames:
        raise InvalidInputError("a situation needs at least one frame")
    if len({frame.dimension for frame in frames}) > 1:
        raise InvalidInputError("the frames of a situation must have the same dimension")
    return np.stack([frame.A for frame in frames]), np.stack([frame.b for frame in frames])
