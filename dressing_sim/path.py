"""Paths that policies return, checked: a policy may be anybody's."""

from __future__ import annotations

from collections.abc import Sequence
from numbers import Real

import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, Policy


def checked_path(path: object, name: str) -> NDArray[np.float64]:
    """A policy's path as an array, once it is one.

    Raises:
        InvalidInputError: It is not of shape (T, 3), T of 2 or more, or not finite.
    """
    try:
        array = np.asarray(path, dtype=float)
    except (TypeError, ValueError) as error:
        raise InvalidInputError(
            f"{name}: returned {path!r:.60}, valid is an array (T, 3)"
        ) from error
    if array.ndim != 2 or array.shape[1] != 3 or len(array) < 2:
        raise InvalidInputError(
            f"{name}: returned an array of shape {array.shape}, valid is (T, 3) with T of 2 or more"
        )
    if not np.isfinite(array).all():
        raise InvalidInputError(
            f"{name}: returned values that are not finite (NaN or infinite), valid are metres"
        )
    return array


def policy_path(
    policy: Policy,
    frames: Sequence[Frame],
    start: NDArray[np.float64],
    default_dt: float,
    longest_dt: float,
) -> tuple[NDArray[np.float64], float]:
    """A policy's path for a situation.

    Args:
        policy: Fitted; its attribute ``dt``, if it has one, is the time between its points.
        frames: The situation.
        start: Where the gripper is, (3,), in the robot's base frame [m].
        default_dt: Time between the points of a policy that does not say [s].
        longest_dt: Largest time between two points [s].

    Returns:
        Positions, shape (T, 3), in the robot's base frame [m], and the time between two [s].

    Raises:
        InvalidInputError: It is no policy, or its path or time step is not valid.
    """
    if isinstance(policy, type) or not callable(getattr(policy, "generate", None)):
        raise InvalidInputError(
            f"cannot dress with {policy!r:.60}; valid is a policy, an Operator or a path, an array "
            "(T, 3) of numpy"
        )
    name = f"policy {type(policy).__name__}"
    dt = getattr(policy, "dt", None)
    # A bool is a number to Python; a NaN is not between anything.
    is_number = isinstance(dt, Real) and not isinstance(dt, bool)
    if dt is not None and not (is_number and 0.0 < float(dt) <= longest_dt):
        raise InvalidInputError(
            f"{name}: its attribute dt is {dt!r}, valid is seconds above zero, up to the episode's "
            f"time limit of {longest_dt:g} s"
        )
    path = checked_path(policy.generate(frames, start), name)
    return path, default_dt if dt is None else float(dt)
