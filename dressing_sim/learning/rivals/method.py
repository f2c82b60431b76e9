"""What all methods share: demonstrations in phase, hyper-parameters, and a skill once learned."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Any, ClassVar, Literal, Self, get_args, get_type_hints

import numpy as np

from dressing_sim.checks import one_of
from dressing_sim.config import check_numbers
from dressing_sim.errors import InvalidInputError
from dressing_sim.extras import needed
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    SyntheticDemonstration,
    check_demonstrations,
)
from dressing_sim.learning.endpoint import Endpoint
from dressing_sim.learning.frame import FloatArray, Frame, situation
from dressing_sim.learning.motion import minimum_jerk
from dressing_sim.learning.policy import Inputs
from dressing_sim.learning.registration import at_times, moving

#: A path stands still while it is within this fraction of its length of an end.
_STILL = 2e-3

#: Over this share of a path the offset of its start fades away.
_BLEND = 0.25

#: What moves a method's answer along when the whole scene is moved: turns about the vertical and
#: shifts, shifts alone, or nothing.
Equivariance = Literal["turns and shifts", "shifts", "nothing"]

#: What was learned: the path (N, p) for a situation and a start (p,), in world coordinates.
Skill = Callable[[Sequence[Frame], FloatArray], FloatArray]


@dataclass(frozen=True, eq=False)
class Shown:
    """Demonstrations in phase: row n of each is at the fraction n / (N - 1) of its duration.

    Attributes:
        points: (M, N, p) in world coordinates.
        situations: Of each demonstration, P frames.
        duration: Their mean duration [s].
    """

    points: FloatArray
    situations: tuple[tuple[Frame, ...], ...]
    duration: float

    @classmethod
    def of(cls, demonstrations: Sequence[DemonstrationLike], samples: int) -> Self:
        """Demonstrations trimmed of standing still, each sampled evenly in its own time.

        Raises:
            InvalidInputError: Demonstrations that cannot be learned from.
        """
        checked = check_demonstrations(demonstrations)
        paths = [np.asarray(one.positions)[moving(one.positions, _STILL)] for one in checked]
        durations = [(len(p) - 1) * one.dt for p, one in zip(paths, checked, strict=True)]
        points = np.stack([resampled(path, samples) for path in paths])
        frames = tuple(situation(one.frames) for one in checked)
        return cls(points, frames, float(np.mean(durations)))

    @property
    def phase(self) -> FloatArray:
        """(N,), from 0 to 1."""
        return np.linspace(0.0, 1.0, self.points.shape[1])

    @property
    def scale(self) -> float:
        """How far points are from their path's mean, the unit in which methods count lengths."""
        return float(np.sqrt(self.points.var(axis=1).sum(axis=-1).mean()))

    @property
    def local(self) -> FloatArray:
        """The points seen from each frame, (M, P, N, p)."""
        return np.stack(
            [
                [frame.to_local(path) for frame in frames]
                for path, frames in zip(self.points, self.situations, strict=True)
            ]
        )

    def only(self, chosen: Sequence[int]) -> Shown:
        """Some of the demonstrations."""
        kept = [*chosen]
        frames = tuple(self.situations[one] for one in kept)
        return Shown(self.points[kept], frames, self.duration)

    def demonstrations(self, rows: int | None = None) -> list[SyntheticDemonstration]:
        """The same as demonstrations over phase, perhaps their first rows alone."""
        step = 1.0 / (self.points.shape[1] - 1)
        pairs = zip(self.points, self.situations, strict=True)
        return [SyntheticDemonstration(path[:rows], step, frames) for path, frames in pairs]

    def place(self, row: int) -> Endpoint:
        """Where demonstrations are at a row, as a function of the situation."""
        if row == 0:
            return Endpoint.of(self.demonstrations(), 0)
        rows = row % self.points.shape[1] + 1
        return Endpoint.of(self.demonstrations(max(rows, 3)), -1)


@dataclass(frozen=True, slots=True)
class Method(ABC):
    """Hyper-parameters of a method, and how it learns. Lengths are fractions of `Shown.scale`.

    Raises:
        InvalidInputError: A value that no method can have.
    """

    inputs: ClassVar[Inputs] = "frames"
    equivariance: ClassVar[Equivariance] = "turns and shifts"
    package: ClassVar[str | None] = None
    """Of the extra ``rivals``, that it needs."""
    may_be_zero: ClassVar[frozenset[str]] = frozenset()

    samples: int = 100
    """Points N of a path."""

    def __post_init__(self) -> None:
        hints = get_type_hints(type(self))
        numbers = [one.name for one in fields(self) if hints[one.name] in (int, float)]
        positive = [name for name in numbers if name not in self.may_be_zero]
        check_numbers(self, "policy", positive, [*self.may_be_zero])
        for one in fields(self):
            if valid := get_args(hints[one.name]):
                one_of(getattr(self, one.name), one.name, valid)
        if not 10 <= self.samples <= 1000:
            raise InvalidInputError(f"samples is {self.samples}, valid is 10 to 1000")

    @abstractmethod
    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The skill that demonstrations show."""


def library(name: str) -> Any:
    """A module of the extra ``rivals``.

    Raises:
        InvalidInputError: It is not installed.
    """
    return needed(name, "rivals")


def begun_at(start: FloatArray, path: FloatArray, phase: FloatArray) -> FloatArray:
    """A path (N, p) over phase (N,) bent to begin at a start (p,).

    What it misses fades by a minimum-jerk blend over the first quarter, as in ``TimeTPGMM``.
    """
    fade = 1.0 - minimum_jerk(phase / _BLEND)
    bent = path + fade[:, None] * (start - path[0])
    bent[0] = start
    return bent


def resampled(path: FloatArray, samples: int) -> FloatArray:
    """A path (T, p) at evenly spaced rows, (samples, p), by linear interpolation."""
    rows = np.linspace(0.0, len(path) - 1.0, samples)
    return at_times(path, np.arange(len(path), dtype=np.float64), rows)
