"""Rewards from signed margins: how far one row is from what success asks for."""

from __future__ import annotations

from math import dist

import numpy as np
from numpy.typing import NDArray

from dressing_sim.episode.meter import Row
from dressing_sim.episode.thresholds import Thresholds

#: The gripper's margin at which nothing is achieved yet [m]: about an arm's length away.
FAR_FROM_SHOULDER = 0.6

#: What it costs to be at a limit of force or strain [1/s]. Own choice.
COST_AT_LIMIT = 0.5


def ramp(margin: float, width: float) -> float:
    """1 where a margin is kept, falling to 0 where it is missed by `width`.

    It is `tolerance` of ``dm_control.utils.rewards`` with a linear sigmoid and ``value_at_margin``
    0, in [0, inf); written out because that package cannot be installed on every Python of ours.
    """
    return min(max(1.0 + margin / width, 0.0), 1.0)


def progress(row: Row, on: bool, shoulder: NDArray[np.float64], thresholds: Thresholds) -> float:
    """How much of a dressing is achieved, 0 to 1: half of it the gripper's, half the sleeve's.

    Args:
        row: What was measured.
        on: Whether the armscye winds round the arm; a sleeve beside it achieves nothing.
        shoulder: Shoulder joint (3,), in the robot's base frame [m].
        thresholds: Those of success.
    """
    gripper, sleeve = arrival_margins(row, shoulder, thresholds)
    pulled = ramp(sleeve, max(thresholds.armscye_s, 1e-9)) if on else 0.0
    return 0.5 * (ramp(gripper, FAR_FROM_SHOULDER) + pulled)


def arrival_margins(
    row: Row, shoulder: NDArray[np.float64], thresholds: Thresholds
) -> tuple[float, float]:
    """By how much the gripper is above and near the shoulder [m], and the armscye past its s.

    They are the margins of the rules ``stopped_short`` and ``stuck`` in one row.
    """
    near = thresholds.gripper_distance - dist(row.tcp.tolist(), shoulder.tolist())
    above = float(row.tcp[2] - shoulder[2])
    return min(near, above), row.armscye_s - thresholds.armscye_s


def harshness(row: Row, thresholds: Thresholds) -> float:
    """0 up to half of the limits of strain and force, 1 at the first of them."""
    now = row.limited()
    used = max(
        now.strain / thresholds.strain,
        now.grip_force / thresholds.grip_force,
        now.link_force / thresholds.link_force,
    )
    return min(max(2.0 * used - 1.0, 0.0), 1.0)
