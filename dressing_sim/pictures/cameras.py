"""A camera that keeps the sleeve in view."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.pictures.story import Moment
from dressing_sim.pictures.studio import FIELD_OF_VIEW_DEG

#: Directions of the camera as seen from the sleeve, azimuth from the robot's x axis and height
#: [deg], the most natural first.
_DIRECTIONS = tuple((a, e) for e in (22.0, 40.0) for a in (95.0, 75.0, 115.0, 50.0, 25.0, 0.0))

#: The camera follows the mean over so long [s], so that it never jerks.
_SMOOTH = 2.0

#: Share of the picture, from its centre, that the sleeve stays within.
_WITHIN = 0.72

#: Moments and vertices that are looked at to choose the direction.
_MOMENTS, _VERTICES = 6, 16

#: Which of points (n, 3) are hidden by the robot from an eye (3,), in a state: (n,).
Hidden = Callable[
    [NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]
]


@dataclass(frozen=True, slots=True, eq=False)
class View:
    """A camera: where it is, and what it looks at, each (3,) [m]."""

    eye: NDArray[np.float64]
    target: NDArray[np.float64]

    def camera(self) -> mujoco.MjvCamera:
        """The same for MuJoCo."""
        towards = self.target - self.eye
        distance = float(np.linalg.norm(towards))
        camera = mujoco.MjvCamera()
        camera.type = mujoco.mjtCamera.mjCAMERA_FREE
        camera.lookat[:], camera.distance = self.target, distance
        camera.azimuth = np.rad2deg(np.arctan2(towards[1], towards[0]))
        camera.elevation = np.rad2deg(np.arcsin(towards[2] / distance))
        return camera


def following(
    moments: Sequence[Moment], shoulder: NDArray[np.float64], shape: float, hidden: Hidden
) -> list[View]:
    """A view for each moment, from one direction: that from which the robot hides least.

    Args:
        moments: Of the film, evenly spaced in time.
        shoulder: Where the sleeve goes, (3,) [m].
        shape: Width of the picture divided by its height.
        hidden: What the robot is in front of.
    """
    centres = np.array([0.7 * m.cloth.mean(axis=0) + 0.3 * shoulder for m in moments])
    step = moments[1].time - moments[0].time if len(moments) > 1 else 1.0
    half = round(0.5 * _SMOOTH / max(step, 1e-3))
    padded = np.pad(centres, ((half, half), (0, 0)), mode="edge")
    sums = np.cumsum(np.concatenate([np.zeros((1, 3)), padded]), axis=0)
    targets = (sums[2 * half + 1 :] - sums[: -2 * half - 1]) / (2 * half + 1)
    reach = max(
        float(np.linalg.norm(m.cloth - target, axis=1).max())
        for m, target in zip(moments, targets, strict=True)
    )
    opening = np.tan(np.deg2rad(0.5 * FIELD_OF_VIEW_DEG)) * min(1.0, shape) * _WITHIN
    # A ball of this radius seems larger by a bit than its equator.
    distance = reach * np.sqrt(1.0 + 1.0 / opening**2)
    rows = np.unique(np.linspace(0, len(moments) - 1, _MOMENTS).round().astype(int))

    def unseen(direction: NDArray[np.float64]) -> float:
        shares = []
        for row in rows:
            moment = moments[row]
            points = moment.cloth[:: max(1, len(moment.cloth) // _VERTICES)]
            eye = targets[row] + distance * direction
            shares.append(hidden(moment.qpos, eye, points).mean())
        return float(np.mean(shares))

    directions = [_direction(*angles) for angles in _DIRECTIONS]
    best = directions[int(np.argmin([round(unseen(d), 2) for d in directions]))]
    return [View(target + distance * best, target) for target in targets]


def _direction(azimuth_deg: float, height_deg: float) -> NDArray[np.float64]:
    a, e = np.deg2rad([azimuth_deg, height_deg])
    return np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
