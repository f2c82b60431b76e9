"""How demonstrations of the planar task vary: what the generator is calibrated with.

Times are fractions of a demonstration's duration, speeds multiples of its mean speed, lengths in
world units. Deviations are between demonstrations, with n - 1.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from dressing_sim.learning.demonstrations import DemonstrationLike
from dressing_sim.learning.frame import FloatArray
from dressing_sim.planar.box import MOUTH

_LEVELS = np.linspace(0.0, 1.0, 101)

#: Speeds at an end are means over so much of the duration.
_END = 0.05

#: Of the peak speed: sd of the smoothing, samples.
_SMOOTH = 3.0


@dataclass(frozen=True, slots=True)
class Measures:
    """Statistics of several demonstrations.

    Attributes:
        n: how many.
        timing_sd: deviation of the times at which a share of the way is done, root mean square over
            the shares.
        end_speed: mean speed in the first and last twentieth of the duration.
        roughness: root mean square of third differences of the positions, mean.
        acceleration: the same of second differences.
        leaving, leaving_sd: time at which the path leaves the start box.
        entering, entering_sd: time at which it enters the goal box.
        peak_speed: highest speed, smoothed, mean.
        lateral_sd: deviation across the channel, at both ends and both mouths, in local units.
        length: mean length.
    """

    n: int
    timing_sd: float
    end_speed: float
    roughness: float
    acceleration: float
    leaving: float
    leaving_sd: float
    entering: float
    entering_sd: float
    peak_speed: float
    lateral_sd: float
    length: float


def measures(demonstrations: Sequence[DemonstrationLike]) -> Measures:
    """Statistics of two demonstrations or more of the planar task, start frame first."""
    from scipy.ndimage import gaussian_filter1d

    arrivals, ends, peaks, lengths = [], [], [], []
    for one in demonstrations:
        steps = np.linalg.norm(np.diff(one.positions, axis=0), axis=1)
        lengths.append(float(steps.sum()))
        share = np.concatenate([[0.0], np.cumsum(steps)]) / steps.sum()
        arrivals.append(np.interp(_LEVELS, share, np.linspace(0.0, 1.0, len(share))))
        speed = steps / steps.mean()
        count = max(round(_END * len(speed)), 1)
        ends += [speed[:count].mean(), speed[-count:].mean()]
        peaks.append(gaussian_filter1d(speed, _SMOOTH).max())
    crossings = np.array([_crossings(one) for one in demonstrations])  # (M, box, time and x, x end)
    times, across = crossings[..., 0], crossings[..., 1:]
    return Measures(
        n=len(demonstrations),
        timing_sd=float(np.sqrt(np.var(arrivals, axis=0, ddof=1).mean())),
        end_speed=float(np.mean(ends)),
        roughness=float(np.mean([rms_difference(one.positions, 3) for one in demonstrations])),
        acceleration=float(np.mean([rms_difference(one.positions, 2) for one in demonstrations])),
        leaving=float(times[:, 0].mean()),
        leaving_sd=float(times[:, 0].std(ddof=1)),
        entering=float(times[:, 1].mean()),
        entering_sd=float(times[:, 1].std(ddof=1)),
        peak_speed=float(np.mean(peaks)),
        lateral_sd=float(np.sqrt(across.var(axis=0, ddof=1).mean())),
        length=float(np.mean(lengths)),
    )


def rms_difference(path: FloatArray, order: int) -> float:
    """Root mean square of a path's (T, p) differences of an order: 2 for bends, 3 for tremor."""
    return float(np.sqrt(np.mean(np.diff(path, order, axis=0) ** 2)))


def _crossings(demonstration: DemonstrationLike) -> FloatArray:
    """For start and goal box: when the mouth is passed, and x there and at the bottom, (2, 3)."""
    found = []
    last = len(demonstration.positions) - 1
    for index, frame in enumerate(demonstration.frames[:2]):
        local = frame.to_local(np.asarray(demonstration.positions))
        outside = np.flatnonzero(local[:, 1] > MOUTH[1])
        row = (outside[0], outside[-1])[index] if len(outside) else (last, 0)[index]
        found.append([row / last, local[row, 0], local[(0, -1)[index], 0]])
    return np.array(found)
