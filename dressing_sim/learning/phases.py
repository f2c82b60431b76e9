"""Demonstrations on one clock before a model learns from them: an option of every model.

A model of time, or of displacements in a given time, takes two speeds for two motions, a higher
sampling rate for a larger weight, and standing still for a part of the motion. On one clock each
demonstration is trimmed of standing still, brought into phase with the first one (see
``registration``), passes each phase at the same time, and has the same number of samples:

    t(phase) = T mean_m (t_m(phase) / T_m),    T the geometric mean of the durations T_m.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

import numpy as np

from dressing_sim.checks import of_kind, real_array, real_number, whole_number
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning.demonstrations import (
    DemonstrationLike,
    SyntheticDemonstration,
    check_demonstrations,
)
from dressing_sim.learning.frame import FloatArray
from dressing_sim.learning.registration import (
    ALIKE,
    MISSED,
    Phased,
    at_times,
    by_phase,
    in_phase,
    landmarks_of,
    moving_part,
    path_length,
)
from dressing_sim.learning.remarks import incomplete


@dataclass(frozen=True, slots=True)
class Alignment:
    """How demonstrations are brought onto one clock.

    Attributes:
        still: a demonstration stands still while it is within this fraction of its length of its
            start, and of its end; 0 trims nothing.
        samples: of a demonstration on the common clock.
        width: over which fraction of a path the alignment is smoothed.
        least_share: a demonstration that ends, or begins, where the others are this far from done
            was cut short: an error, see ``remarks``. 0 takes any.

    Raises:
        InvalidInputError: a value out of range.
    """

    still: float = 2e-3
    samples: int = 200
    width: float = 0.05
    least_share: float = 0.8

    def __post_init__(self) -> None:
        real_number(self.still, "an alignment's still", 0.0, 0.5)
        whole_number(self.samples, "an alignment's samples", 10, 2000)
        real_number(self.width, "an alignment's width", 1e-6, 1.0)
        real_number(self.least_share, "an alignment's least_share", 0.0, 1.0)


@dataclass(frozen=True, eq=False)
class Clock:
    """What demonstrations are aligned with, later ones too.

    Attributes:
        alignment: how.
        points: the first demonstration by phase, (N, p).
        landmarks: of its situation, (K, p).
        times: when a phase is passed, (N,), from zero [s].
    """

    alignment: Alignment
    points: FloatArray
    landmarks: FloatArray
    times: FloatArray

    def __post_init__(self) -> None:
        of_kind(self.alignment, Alignment, "a clock's alignment", "an Alignment")
        points = real_array(self.points, ("N", "p"), "a clock's points have", fewest=2)
        real_array(self.landmarks, ("K", points.shape[1]), "a clock's landmarks have", fewest=1)
        times = real_array(self.times, (len(points),), "a clock's times have", "s")
        if not (times[-1] > 0.0 and (np.diff(times) >= 0.0).all()):
            raise InvalidInputError("a clock's times do not rise, valid are times from zero")

    @property
    def dt(self) -> float:
        """Time between two samples of a demonstration on this clock [s]."""
        return float(self.times[-1]) / (self.alignment.samples - 1)

    @classmethod
    def of(cls, demonstrations: Sequence[DemonstrationLike], alignment: Alignment) -> Self:
        """The clock of demonstrations.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from, or one that was cut
                short.
        """
        of_kind(alignment, Alignment, "alignment", "an Alignment")
        checked = check_demonstrations(demonstrations)
        for remark in incomplete(checked, alignment.still, alignment.least_share):
            raise InvalidInputError(
                f"{remark}; valid is a whole demonstration, or Alignment(least_share=0)"
            )
        paths = [by_phase(one, alignment.still, alignment.samples) for one in checked]
        scale = path_length(paths[0].points)
        landmarks = [landmarks_of(one.frames, scale) for one in checked]
        aligned = in_phase(paths, landmarks, ALIKE * scale, MISSED, alignment.width)
        durations = np.array([one.times[-1] for one in aligned])
        shares = np.mean([one.times / one.times[-1] for one in aligned], axis=0)
        times = shares * float(np.exp(np.mean(np.log(durations))))
        return cls(alignment, paths[0].points, landmarks[0], times)

    def align(
        self, demonstrations: Sequence[DemonstrationLike]
    ) -> tuple[SyntheticDemonstration, ...]:
        """Demonstrations on this clock, from the start to the end of their motion.

        Raises:
            InvalidInputError: demonstrations that cannot be learned from.
        """
        checked = check_demonstrations(demonstrations)
        scale = path_length(self.points)
        reference = Phased(self.points, self.times)
        still, rows = self.alignment.still, self.alignment.samples
        paths = [reference, *(by_phase(one, still, rows) for one in checked)]
        landmarks = [self.landmarks, *(landmarks_of(one.frames, scale) for one in checked)]
        aligned = in_phase(paths, landmarks, ALIKE * scale, MISSED, self.alignment.width)
        return tuple(
            self._sampled(one, phased) for one, phased in zip(checked, aligned[1:], strict=True)
        )

    def _sampled(self, demonstration: DemonstrationLike, phased: Phased) -> SyntheticDemonstration:
        """A demonstration evenly sampled in the clock's time; ``phased`` says when is what."""
        positions, times = moving_part(
            np.asarray(demonstration.positions), demonstration.dt, self.alignment.still
        )
        ticks = np.linspace(0.0, self.times[-1], self.alignment.samples)
        own = np.interp(ticks, self.times, phased.times) + times[0]
        return SyntheticDemonstration(
            at_times(positions, times, own), self.dt, demonstration.frames
        )


def on_clock(
    clock: Clock | None, demonstrations: Sequence[DemonstrationLike]
) -> tuple[DemonstrationLike, ...]:
    """Demonstrations on a clock; only checked where there is none."""
    if clock is None:
        return check_demonstrations(demonstrations)
    return clock.align(demonstrations)


def clock_state(clock: Clock | None) -> tuple[dict[str, Any] | None, dict[str, FloatArray]]:
    """Settings and arrays of a clock, or of none, for ``storage``."""
    if clock is None:
        return None, {}
    arrays = {
        "clock_points": clock.points,
        "clock_landmarks": clock.landmarks,
        "clock_times": clock.times,
    }
    return asdict(clock.alignment), arrays


def clock_from_state(
    settings: dict[str, Any] | None, arrays: Mapping[str, FloatArray]
) -> Clock | None:
    """The clock that ``clock_state`` came from."""
    if settings is None:
        return None
    names = ("clock_points", "clock_landmarks", "clock_times")
    return Clock(Alignment(**settings), *(arrays[name] for name in names))
