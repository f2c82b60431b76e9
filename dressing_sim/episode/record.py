"""Whole episodes: a path, a policy or the operator dresses one arm. Loops over `Dressing`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.config import from_plain, to_plain
from dressing_sim.control import JointTrajectory, track_path
from dressing_sim.control.tracking import finite
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.observation import Force, Observation
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rules import RULES, UNREACHABLE, Rule
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.inputs import asked_with, inputs_of
from dressing_sim.learning import Policy
from dressing_sim.path import Path, policy_path, policy_seed, takes_seed
from dressing_sim.world.simulation import World

#: Called after every control step with the running world; for films and views.
Observer = Callable[[World], None]

#: Seconds between the points of a path whose maker does not say.
DEFAULT_PATH_DT = 0.05

#: No part of the robot gets this far from its base's origin; farther points are not tried [m].
FARTHEST = 1.5

PathSource = Policy | Path | NDArray[np.float64]


class DemonstrationFailed(DressingSimError):
    """There is nothing to learn from: the robot never moved.

    Attributes:
        outcome: What became of the episode.
    """

    def __init__(self, message: str, outcome: Outcome) -> None:
        super().__init__(message)
        self.outcome = outcome


def record(
    source: PathSource,
    posture: Posture,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
    rules: Sequence[Rule] = RULES,
) -> Recording:
    """Dress an arm once and keep the measurements.

    Args:
        source: A fitted policy, which is asked with what its class of inputs stands for; or a path,
            a `Path` or an array (T, 3) in the robot's base frame [m], with ``DEFAULT_PATH_DT``
            between its points. A policy with ``act`` is asked for a target in every control step
            instead of for a path.
        posture: The arm to dress.
        seed: Of the policy's own randomness, such as the operator's variability.
        config: World, robot and thresholds.
        observer: Called after every control step.
        rules: What is judged.

    Raises:
        InvalidInputError: The path, or a target, has the wrong shape or is not finite.
    """
    dressing = Dressing(posture, config, rules)
    if dressing.invalid is not None:
        # Nobody is asked for a path from a place that makes no sense.
        outcome = Outcome(False, invalid=dressing.invalid)
        return Recording(outcome, None, None, dressing.start[None], broke=dressing.invalid)
    if callable(getattr(source, "act", None)):
        return _close_the_loop(dressing, source, seed, observer)
    longest = dressing.config.time_limit
    path = policy_path(source, posture, dressing.start, seed, DEFAULT_PATH_DT, longest)
    return follow(dressing, path.positions, path.dt or DEFAULT_PATH_DT, observer)


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
    failure = UNREACHABLE.before_moving(detail)
    outcome = Outcome(False, (failure,), {"tracking_error": error})
    return Recording(outcome, None, None, dressing.start[None])


def play(
    dressing: Dressing, trajectory: JointTrajectory, observer: Observer | None = None
) -> Recording:
    """Play joint commands, hold the last one, and judge what happens."""
    n_hold = round(dressing.config.hold / trajectory.dt)
    n_limit = round(dressing.config.time_limit / trajectory.dt)
    finished = len(trajectory.positions) + n_hold <= n_limit + 1
    commands = np.pad(trajectory.positions, ((0, n_hold), (0, 0)), mode="edge")
    targets = np.pad(trajectory.targets, ((0, n_hold), (0, 0)), mode="edge")
    dressing.reset(commands[0], targets[0])
    positions = [dressing.start]
    for command, target in zip(commands[1:], targets[1:], strict=True):
        if dressing.done:
            break
        row = dressing.step_joints(command, target)
        if dressing.invalid is None:
            positions.append(row.tcp)
            if observer is not None:
                observer(dressing.world)
    return _recording(dressing, trajectory, positions, finished)


def _recording(
    dressing: Dressing,
    trajectory: JointTrajectory,
    positions: Sequence[NDArray[np.float64]],
    finished: bool,
) -> Recording:
    broke = dressing.invalid
    trace = None if broke is not None and not dressing.stopped else dressing.trace()
    outcome = dressing.outcome(finished)
    return Recording(outcome, trace, trajectory, np.array(positions), finished, broke)


def _close_the_loop(
    dressing: Dressing, policy: Any, seed: int, observer: Observer | None = None
) -> Recording:
    """Ask a policy for a target in every step until it returns None, then hold the last one."""
    name = f"policy {type(policy).__name__}"
    frames, forces = asked_with(policy, dressing.posture), inputs_of(policy) == "frames+force"
    reset = getattr(policy, "reset", None)
    if callable(reset):
        reset(**({"seed": policy_seed(policy, seed)} if takes_seed(reset) else {}))
    row = dressing.reset()
    target, dt = dressing.start, dressing.config.tracking.dt
    commands, targets, errors, positions = [row.joint_position], [target], [0.0], [row.tcp]
    n_hold, held = round(dressing.config.hold / dt), 0
    while not dressing.done and held < n_hold:
        force = Force(row.grip_force, row.link_force) if forces else None
        wanted = None
        if held == 0:
            wanted = policy.act(Observation(row.time, dt, row.tcp, target, frames, force))
        if wanted is None:
            held += 1
        else:
            target = finite(f"{name}: act returned a target", wanted, 3, "m")
        row = dressing.step(target)
        if dressing.invalid is not None:
            break
        commands.append(dressing.command)
        targets.append(dressing.target)
        errors.append(dressing.target_error)
        positions.append(row.tcp)
        if observer is not None:
            observer(dressing.world)
        if errors[-1] > dressing.config.tracking.max_error:
            break
    trajectory = JointTrajectory(np.array(commands), dt, np.array(targets), np.array(errors))
    recording = _recording(dressing, trajectory, positions, held >= n_hold)
    if trajectory.max_error <= dressing.config.tracking.max_error or recording.broke is not None:
        return recording
    told = f"the robot stays {errors[-1]:.3g} m from the target"
    failure = Failure(UNREACHABLE.name, told, row.time, row.armscye_s)
    outcome = Outcome(False, (failure,), recording.outcome.metrics)
    return Recording(outcome, recording.trace, trajectory, recording.positions)


def dress(
    path_or_policy: PathSource,
    posture: Posture,
    seed: int = 0,
    config: EpisodeConfig | None = None,
) -> Outcome:
    """Dress an arm once: the outcome of `record`."""
    return record(path_or_policy, posture, seed, config).outcome


def demonstrate(
    posture: Posture,
    seed: int,
    operator: Operator | None = None,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
) -> Demonstration:
    """Record a demonstration of the scripted operator.

    Returns:
        What the gripper did from its first to its last command, without the final hold. Its
        ``outcome`` says whether it is worth learning from.

    Raises:
        DemonstrationFailed: The robot could not move; the error has the outcome.
    """
    operator = operator or Operator()
    config = config or EpisodeConfig()
    recording = record(operator, posture, seed, config, observer)
    outcome = recording.outcome
    if recording.trace is None or recording.trajectory is None:
        why = outcome.invalid or ", ".join(failure.detail for failure in outcome.failures)
        raise DemonstrationFailed(f"no demonstration on posture {posture.name!r}: {why}", outcome)
    commands = recording.trajectory.positions
    return Demonstration(
        positions=recording.positions[: len(commands)],
        dt=recording.trajectory.dt,
        posture=posture,
        seed=seed,
        commands=commands[: len(recording.positions)],
        settings={"episode": to_plain(config), "operator": to_plain(operator.config)},
        outcome=outcome,
    )


def replay(demonstration: Demonstration, observer: Observer | None = None) -> Recording:
    """Play a demonstration's commands again in the world it was recorded in.

    With the versions that it was recorded with, and on the same kind of processor, the gripper's
    positions are the same to the bit.

    Raises:
        InvalidInputError: It does not say which world it was recorded in.
    """
    if "episode" not in demonstration.settings:
        raise InvalidInputError(
            f"the demonstration on {demonstration.posture.name!r} has no settings of its episode; "
            "valid is one that was recorded in the simulator"
        )
    config = from_plain(EpisodeConfig, demonstration.settings["episode"])
    dressing = Dressing(demonstration.posture, config)
    commands = demonstration.commands
    targets = np.array([dressing.kinematics.tcp_pose(q)[0] for q in commands])
    trajectory = JointTrajectory(commands, demonstration.dt, targets, np.zeros(len(commands)))
    return play(dressing, trajectory, observer)
