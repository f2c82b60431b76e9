"""Loops over `Dressing` that carry out one episode: along a path, of joint commands, or closed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import real_vector
from dressing_sim.control import JointTrajectory, track_path
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.observation import Force, Observation
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rules import UNREACHABLE
from dressing_sim.inputs import asked_with, inputs_of
from dressing_sim.path import policy_at_fault, policy_name, policy_seed, reset_policy
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
    beyond = float(np.linalg.norm(path, axis=1).max()) - FARTHEST
    if beyond > 0.0:
        told = f"the path leads {beyond:.3g} m beyond {FARTHEST:g} m from the robot's base"
        return _unreachable(dressing, beyond, told)
    config = dressing.config.tracking
    trajectory = track_path(
        path,
        path_dt,
        dressing.start_configuration,
        dressing.kinematics,
        config,
        # One step more, which says that the path was longer.
        max_duration=dressing.config.time_limit + 2.0 * config.dt,
    )
    error = max(dressing.start_error, trajectory.max_error)
    if error > config.max_error:
        return _unreachable(dressing, error, f"the robot stays {error:.3g} m from the path")
    return play(dressing, trajectory, observer)


def _unreachable(dressing: Dressing, error: float, detail: str) -> Recording:
    """A path that nobody tries to follow."""
    outcome = Outcome(False, (UNREACHABLE.before_moving(detail),), {"tracking_error": error})
    left = dressing.config.tracking.max_error - error
    return Recording(outcome, None, None, dressing.start[None], reach_left=left)


def play(
    dressing: Dressing, trajectory: JointTrajectory, observer: Observer | None = None
) -> Recording:
    """Play joint commands, hold the last one, and judge what happens."""
    n_hold = round(dressing.config.hold / trajectory.dt)
    n_limit = round(dressing.config.time_limit / trajectory.dt)
    n_left = n_limit + 1 - len(trajectory.positions) - n_hold
    commands = np.pad(trajectory.positions, ((0, n_hold), (0, 0)), mode="edge")
    targets = np.pad(trajectory.targets, ((0, n_hold), (0, 0)), mode="edge")
    dressing.reset(commands[0], targets[0])
    positions = [dressing.start]
    for command, target in zip(commands[1:], targets[1:], strict=True):
        if dressing.done:
            break
        _keep(dressing, dressing.step_joints(command, target), positions, observer)
    time_left = n_left * trajectory.dt - trajectory.left_out
    return _recording(dressing, trajectory, positions, time_left)


def close_the_loop(
    dressing: Dressing, policy: Any, seed: int, observer: Observer | None = None
) -> Recording:
    """Ask a policy for a target in every step until it returns None, then hold the last one.

    Args:
        dressing: It begins anew.
        policy: It has ``act``, and may have ``reset``.
        seed: Of the policy's own randomness.
        observer: Called after every control step.
    """
    name = policy_name(policy)
    frames, forces = asked_with(policy, dressing.posture), inputs_of(policy) == "frames+force"
    reset_policy(policy, policy_seed(policy, seed))
    row = dressing.reset()
    target, dt = dressing.start, dressing.config.tracking.dt
    commands, targets, errors, positions = [row.joint_position], [target], [0.0], [row.tcp]
    n_hold, held = round(dressing.config.hold / dt), 0
    while not dressing.done and held < n_hold:
        wanted = None
        if held == 0:
            force = Force(row.grip_force, row.link_force) if forces else None
            wanted = policy.act(Observation(row.time, dt, row.tcp, target, frames, force))
        if wanted is None:
            held += 1
        else:
            with policy_at_fault():
                target = real_vector(wanted, 3, f"{name}: act returned a target of", "m")
        row = dressing.step(target)
        if not _keep(dressing, row, positions, observer):
            break
        commands.append(dressing.command)
        targets.append(dressing.target)
        errors.append(dressing.target_error)
        if errors[-1] > dressing.config.tracking.max_error:
            break
    trajectory = JointTrajectory(np.array(commands), dt, np.array(targets), np.array(errors))
    n_left = round(dressing.config.time_limit / dt) + 1 - len(positions) if held >= n_hold else -1
    recording = _recording(dressing, trajectory, positions, n_left * dt)
    if recording.reach_left >= 0.0 or recording.broke is not None:
        return recording
    told = f"the robot stays {errors[-1]:.3g} m from the target"
    failure = Failure(UNREACHABLE.name, told, row.time, row.armscye_s)
    return replace(recording, outcome=Outcome(False, (failure,), recording.outcome.metrics))


def _keep(
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


def _recording(
    dressing: Dressing,
    trajectory: JointTrajectory,
    positions: Sequence[NDArray[np.float64]],
    time_left: float,
) -> Recording:
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
