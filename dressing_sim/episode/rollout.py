"""Loops over `Dressing` that carry out one episode: along a path, or of joint commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from dressing_sim.control import JointTrajectory, track_path
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.outcome import Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rules import UNREACHABLE
from dressing_sim.world.simulation import World

#: Called after every control step with the running world; for films and views.
Observer = Callable[[World], None]

#: No part of the robot gets this far from its base's origin; farther points are not tried [m].
FARTHEST = 1.5


def follow(
    dressing: Dressing,
    path: NDArray[np.float64],
    path_dt: float,
    observer: Observer | None = None,
) -> Recording:
    """Lead the gripper along a path, hold its end, and judge what happens.

    Args:
        dressing: It begins anew.
        path: Positions of the gripper, shape (n, 3), in the robot's base frame [m].
        path_dt: Time between two rows [s].
        observer: Called after every control step.
    """
    planned = plan(dressing, path, path_dt)
    return planned if isinstance(planned, Recording) else play(dressing, planned, observer)


def plan(
    dressing: Dressing, path: NDArray[np.float64], path_dt: float
) -> JointTrajectory | Recording:
    """Joint commands for a path, or at once the recording of one that nobody tries to follow.

    Args:
        dressing: It stays as it is.
        path: Positions of the gripper, shape (n, 3), in the robot's base frame [m].
        path_dt: Time between two rows [s].
    """
    beyond = float(np.linalg.norm(path, axis=1).max()) - FARTHEST
    if beyond > 0.0:
        told = f"the path leads {beyond:.3g} m beyond {FARTHEST:g} m from the robot's base"
        return _unreachable(dressing, beyond, told)
    trajectory = tracked(dressing, path, path_dt)
    error = max(dressing.start_error, trajectory.max_error)
    if error > dressing.config.tracking.max_error:
        return _unreachable(dressing, error, f"the robot stays {error:.3g} m from the path")
    return trajectory


def tracked(
    dressing: Dressing, path: NDArray[np.float64], path_dt: float, longest: float | None = None
) -> JointTrajectory:
    """Joint commands that lead the gripper along a path from where the dressing starts.

    Args:
        dressing: It stays as it is.
        path: Positions of the gripper, shape (n, 3), in the robot's base frame [m].
        path_dt: Time between two rows [s].
        longest: What comes later is left out [s]; the time limit if not given.
    """
    config = dressing.config
    return track_path(
        path,
        path_dt,
        dressing.start_configuration,
        dressing.kinematics,
        config.tracking,
        # One step more, which says that the path was longer.
        config.time_limit + 2.0 * config.tracking.dt if longest is None else longest,
    )


def begin(dressing: Dressing) -> Row:
    """Begin anew with the first command of any path, which stays where the gripper is.

    Who then steps along the targets of `tracked`, and holds, gets the bits of `follow`.
    """
    here = dressing.kinematics.tcp_pose(dressing.start_configuration)[0]
    first = tracked(dressing, here[None], dressing.config.tracking.dt, longest=0.0)
    return dressing.reset(first.positions[0], first.targets[0])


def _unreachable(dressing: Dressing, error: float, detail: str) -> Recording:
    """A path that nobody tries to follow."""
    outcome = Outcome(False, (UNREACHABLE.before_moving(detail),), {"tracking_error": error})
    left = dressing.config.tracking.max_error - error
    return Recording(outcome, None, None, dressing.start[None], reach_left=left)


def play(
    dressing: Dressing, trajectory: JointTrajectory, observer: Observer | None = None
) -> Recording:
    """Play joint commands, hold the last one, and judge what happens."""
    commands, targets, time_left = with_hold(dressing, trajectory)
    dressing.reset(commands[0], targets[0])
    positions = [dressing.start]
    for command, target in zip(commands[1:], targets[1:], strict=True):
        if dressing.done:
            break
        keep(dressing, dressing.step_joints(command, target), positions, observer)
    return recorded(dressing, trajectory, positions, time_left)


def with_hold(
    dressing: Dressing, trajectory: JointTrajectory
) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """All that is played of a trajectory, the final hold included.

    Returns:
        Joint commands (n, 7) [rad], targets (n, 3) [m], and what of the time will be left then [s].
    """
    n_hold = round(dressing.config.hold / trajectory.dt)
    n_limit = round(dressing.config.time_limit / trajectory.dt)
    n_left = n_limit + 1 - len(trajectory.positions) - n_hold
    commands = np.pad(trajectory.positions, ((0, n_hold), (0, 0)), mode="edge")
    targets = np.pad(trajectory.targets, ((0, n_hold), (0, 0)), mode="edge")
    return commands, targets, n_left * trajectory.dt - trajectory.left_out


def keep(
    dressing: Dressing,
    row: Row,
    positions: list[NDArray[np.float64]],
    observer: Observer | None,
) -> bool:
    """Keep where the gripper came to, unless the simulation broke down in this step."""
    if dressing.invalid is not None:
        return False
    positions.append(row.tcp)
    if observer is not None:
        observer(dressing.world)
    return True


def recorded(
    dressing: Dressing,
    trajectory: JointTrajectory,
    positions: Sequence[NDArray[np.float64]],
    time_left: float,
) -> Recording:
    """The episode that a dressing has just been, judged."""
    broke = dressing.invalid
    return Recording(
        dressing.outcome(time_left >= 0.0),
        None if broke is not None and not dressing.stopped else dressing.trace(),
        trajectory,
        np.array(positions),
        time_left,
        dressing.config.tracking.max_error - max(dressing.start_error, trajectory.max_error),
        broke,
    )
