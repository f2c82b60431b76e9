"""A policy for dressing_sim: the mean demonstration, seen from the wrist and from the shoulder.

Near its beginning a dressing belongs to the wrist, near its end to the shoulder. The mean of the
demonstrations is kept in the coordinates of both frames, and a new path goes over from one to the
other: ``p(t) = (1 - t) (A_w l_w(t) + b_w) + t (A_s l_s(t) + b_s)``, t from 0 to 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from dressing_sim.learning import DemonstrationLike, Frame, Situation

__all__ = ["BlendedFrames"]


class BlendedFrames:
    """The mean demonstration in two frames, blended.

    Args:
        samples: Points of a path.
    """

    #: It is asked with the frames of shoulder and wrist, and never gets more.
    inputs = "frames"

    def __init__(self, samples: int = 200) -> None:
        self.samples = samples

    def fit(self, demonstrations: Sequence[DemonstrationLike]) -> Self:
        """Keep the mean of the demonstrations, (samples, 3) [m] in each frame, and how long."""
        durations = [(len(one.positions) - 1) * one.dt for one in demonstrations]
        self.dt = float(np.mean(durations)) / (self.samples - 1)
        pairs = [(resampled(one.positions, self.samples), one.frames) for one in demonstrations]
        # Frames stand in the paper's order: shoulder, wrist.
        self.from_shoulder = np.mean([local(path, f[0]) for path, f in pairs], axis=0)
        self.from_wrist = np.mean([local(path, f[1]) for path, f in pairs], axis=0)
        return self

    def generate(self, frames: Situation, start: ArrayLike) -> NDArray[np.float64]:
        """A path (samples, 3), in the robot's base frame [m], from the gripper's position (3,)."""
        late = np.linspace(0.0, 1.0, self.samples)[:, None]
        path = (1.0 - late) * world(self.from_wrist, frames.wrist)
        path += late * world(self.from_shoulder, frames.shoulder)
        # What the gripper is off at the start fades over the first quarter.
        return path + np.clip(1.0 - 4.0 * late, 0.0, 1.0) * (np.asarray(start) - path[0])


def resampled(path: NDArray[np.float64], n: int) -> NDArray[np.float64]:
    """A path (T, 3) at n evenly spaced times, (n, 3) [m]."""
    old, new = np.linspace(0.0, 1.0, len(path)), np.linspace(0.0, 1.0, n)
    return np.column_stack([np.interp(new, old, column) for column in np.asarray(path).T])


def local(path: NDArray[np.float64], frame: Frame) -> NDArray[np.float64]:
    """Positions (T, 3) [m] as seen from a frame: ``world = A local + b`` solved for local."""
    return (path - frame.b) @ frame.A


def world(path: NDArray[np.float64], frame: Frame) -> NDArray[np.float64]:
    """Positions (T, 3) [m] in a frame as seen from the robot's base."""
    return path @ frame.A.T + frame.b
