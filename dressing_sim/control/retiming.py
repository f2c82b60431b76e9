"""From a path of any speed to targets that the gripper can follow: pure functions of arrays."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def retime(
    path: NDArray[np.float64],
    path_dt: float,
    dt: float,
    max_speed: float,
    max_duration: float = np.inf,
) -> NDArray[np.float64]:
    """Sample a path every `dt` seconds, slowing it down where it is faster than allowed.

    Args:
        path: Positions, shape (n, d), one each `path_dt` seconds [m].
        path_dt: Time between two rows [s].
        dt: Time between two rows of the result [s].
        max_speed: Largest speed of the result [m/s].
        max_duration: What comes later is left out [s].

    Returns:
        Positions, shape (m, d): the path's first to its last point along the same polyline.
    """
    times = times_of(path, path_dt, max_speed)
    end = min(times[-1], max_duration)
    samples = np.append(np.arange(0.0, end, dt), end)
    return np.column_stack([np.interp(samples, times, column) for column in path.T])


def times_of(path: NDArray[np.float64], path_dt: float, max_speed: float) -> NDArray[np.float64]:
    """When each point of a path (n, d) [m] is reached, (n,) [s], if no part is too fast."""
    durations = np.linalg.norm(np.diff(path, axis=0), axis=1) / max_speed
    return np.concatenate([[0.0], np.cumsum(np.maximum(durations, path_dt))])


def smooth(points: NDArray[np.float64], dt: float, window: float) -> NDArray[np.float64]:
    """Round the corners of a sampled path; its ends stay, and it takes `window` longer.

    Args:
        points: Positions, shape (n, d), one each `dt` seconds [m].
        dt: Time between two rows [s].
        window: Length of the Hann window that the path is convolved with [s].

    Returns:
        Positions, shape (n + round(window / dt), d) [m].
    """
    half = round(0.5 * window / dt)
    if half == 0:
        return points
    weights = np.hanning(2 * half + 3)[1:-1]
    padded = np.pad(points, ((2 * half, 2 * half), (0, 0)), mode="edge")
    return np.column_stack(
        [np.convolve(column, weights / weights.sum(), mode="valid") for column in padded.T]
    )
