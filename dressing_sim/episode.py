"""One dressing, from a path to an outcome."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.control import (
    JointTrajectory,
    PandaKinematics,
    TrackingConfig,
    configuration_at,
    track_path,
)
from dressing_sim.demonstration import Demonstration
from dressing_sim.errors import InvalidInputError
from dressing_sim.judge import Failure, Outcome, ProtectiveStop, Thresholds, judge
from dressing_sim.learning import Policy
from dressing_sim.meter import Meter
from dressing_sim.operator import Operator
from dressing_sim.paths import checked_path, policy_path
from dressing_sim.settings import check_numbers, from_plain, to_plain
from dressing_sim.trace import Trace
from dressing_sim.world.scene import WorldConfig, grip_start
from dressing_sim.world.simulation import World

#: Called after every control step with the running world; for videos and views.
Observer = Callable[[World], None]

#: No part of the robot gets this far from its base's origin; farther points are not tried [m].
FARTHEST = 1.5

#: A cloth whose vertices are all slower than this hangs still [m/s].
_SETTLED_SPEED = 0.05


@dataclass(frozen=True, slots=True)
class EpisodeConfig:
    """Everything that an episode's outcome depends on, but posture and path."""

    world: WorldConfig = field(default_factory=WorldConfig)
    tracking: TrackingConfig = field(default_factory=TrackingConfig)
    thresholds: Thresholds = field(default_factory=Thresholds)
    hold: float = 1.0
    """The robot stays at its path's end for so long before the verdict [s]."""
    time_limit: float = 30.0
    """The robot stops when it has moved for so long [s]."""
    protective_stop: bool = True
    """The simulation ends with the robot's protective stop. Without, it goes on, so that its
    trace can be judged with other thresholds; the outcome is the same."""

    def __post_init__(self) -> None:
        ratio = self.tracking.dt / self.world.solver.timestep
        if ratio < 1.0 or abs(ratio - round(ratio)) > 1e-9:
            raise InvalidInputError(
                f"the control step of {self.tracking.dt} s is not a multiple of the physics step "
                f"of {self.world.solver.timestep} s"
            )
        check_numbers(self, "episode", (), ("hold",))
        if not self.tracking.dt <= self.time_limit < np.inf:
            raise InvalidInputError(
                f"episode: time_limit is {self.time_limit} s, valid is at least the control step "
                f"of {self.tracking.dt} s"
            )


# Many policies dress the same arm in turn; the world that they all begin with is made once.
@lru_cache(maxsize=1)
def _settled(
    posture: Posture, config: WorldConfig, tracking: TrackingConfig
) -> tuple[World, float]:
    """The world before the robot moves, to be copied, and the start's error.

    The cloth falls until it hangs still, for at most three times the settling time.
    """
    q, error = configuration_at(grip_start(posture, config.sleeve), PandaKinematics(), tracking)
    world = World(posture, config, q)
    while world.time < 3.0 * config.settle_time and world.void_reason is None:
        world.step()
        if world.time >= config.settle_time and world.cloth_speed < _SETTLED_SPEED:
            break
    return world, error


@dataclass(frozen=True, slots=True)
class Recording:
    """An episode as it happened.

    Attributes:
        outcome: The verdict.
        trace: The measurements, or None if the robot never moved.
        trajectory: The joint commands, or None if there were none.
        positions: The gripper at the start and after each command, shape (n, 3) [m].
        finished: Whether the commands end before the time limit.
        broke: Why the simulation could not be trusted beyond the trace's last row, or None; then
            the outcome is void, unless the robot had stopped before.
    """

    outcome: Outcome
    trace: Trace | None
    trajectory: JointTrajectory | None
    positions: NDArray[np.float64]
    finished: bool = False
    broke: str | None = None


class Episode:
    """A settled world, waiting for the robot to move; good for one dressing.

    Args:
        posture: The arm to dress.
        config: World, robot and rules.

    Attributes:
        posture: As given.
        config: As given.
        kinematics: The robot's kinematics.
        world: The simulation.
        start_error: How far the gripper's first position is from where the sleeve is held [m].
    """

    def __init__(self, posture: Posture, config: EpisodeConfig | None = None) -> None:
        self.posture = posture
        self.config = config or EpisodeConfig()
        self.kinematics = PandaKinematics()
        settled, self.start_error = _settled(posture, self.config.world, self.config.tracking)
        self.world = settled.copy()
        self._substeps = round(self.config.tracking.dt / self.config.world.solver.timestep)

    @property
    def start(self) -> NDArray[np.float64]:
        """Where the gripper is now, (3,), in the robot's base frame [m]."""
        return self.world.tcp_position

    def follow(
        self,
        path: NDArray[np.float64],
        path_dt: float,
        observer: Observer | None = None,
    ) -> Recording:
        """Lead the gripper along a path and judge what happens.

        Args:
            path: Positions of the gripper, shape (n, 3), in the robot's base frame [m].
            path_dt: Time between two rows [s].
            observer: Called after every control step.
        """
        if self.world.void_reason is not None:
            return self.void(self.world.void_reason)
        beyond = float(np.linalg.norm(path, axis=1).max()) - FARTHEST
        if beyond > 0.0:
            told = f"the path leads {beyond:.3g} m beyond {FARTHEST:g} m from the robot's base"
            return self._unreachable(beyond, told)
        config = self.config.tracking
        trajectory = track_path(
            path,
            path_dt,
            self.world.arm_configuration,
            self.kinematics,
            config,
            # One step more, which says that the path was longer.
            max_duration=self.config.time_limit + 2.0 * config.dt,
        )
        error = max(self.start_error, trajectory.max_error)
        if error > config.max_error:
            return self._unreachable(error, f"the robot stays {error:.3g} m from the path")
        return self.play(trajectory, observer)

    def void(self, reason: str) -> Recording:
        """What is recorded if the world broke down before the robot moved."""
        outcome = Outcome(False, void=reason)
        return Recording(outcome, None, None, self.start[None], broke=reason)

    def _unreachable(self, error: float, detail: str) -> Recording:
        failure = Failure("ik_unreachable", detail)
        outcome = Outcome(False, (failure,), {"tracking_error": error})
        return Recording(outcome, None, None, self.start[None])

    def play(self, trajectory: JointTrajectory, observer: Observer | None = None) -> Recording:
        """Play joint commands, hold the last one, and judge what happens."""
        config, dt = self.config, trajectory.dt
        n_hold, n_limit = round(config.hold / dt), round(config.time_limit / dt)
        commands = np.pad(trajectory.positions, ((0, n_hold), (0, 0)), mode="edge")[: n_limit + 1]
        velocities = np.diff(commands, axis=0, prepend=commands[:1]) / dt
        references = np.stack([commands, velocities], axis=1)
        finished = len(trajectory.positions) + n_hold <= n_limit + 1
        # The world tells where the gripper was one physics step ago.
        held = np.pad(trajectory.targets, ((0, n_hold), (0, 0)), mode="edge")[: len(commands)]
        targets = held - np.diff(held, axis=0, prepend=held[:1]) / self._substeps
        meter = Meter(self.world, config.thresholds.strain_percentile)
        watch, stopped, void = ProtectiveStop(config.thresholds, dt), False, None
        positions = [self.start]
        for row in range(1, len(references)):
            before, after = references[row - 1 : row + 1]
            for step in range(1, self._substeps + 1):
                self.world.command(*(before + step / self._substeps * (after - before)))
                self.world.step()
                meter.feel()
            void = self.world.void_reason
            if void is not None:
                break
            stopped = bool(watch.see(meter.read(targets[row]))) or stopped
            positions.append(self.world.tcp_position)
            if observer is not None:
                observer(self.world)
            if stopped and config.protective_stop:
                break
        if void is not None and not stopped:
            trace, outcome = None, Outcome(False, void=void)
        else:
            trace = meter.trace(dt)
            outcome = judge(trace, self.posture.shoulder, finished, config.thresholds)
        return Recording(outcome, trace, trajectory, np.array(positions), finished, void)


#: Seconds between the points of a path whose maker does not say.
DEFAULT_PATH_DT = 0.05

PathSource = Policy | Operator | NDArray[np.float64]


def record(
    source: PathSource,
    posture: Posture,
    seed: int = 0,
    config: EpisodeConfig | None = None,
    observer: Observer | None = None,
) -> Recording:
    """Dress an arm once and keep the measurements.

    Args:
        source: A fitted policy, which sees the frames and the gripper's position only; the
            scripted operator, which sees the posture; or a path, shape (T, 3), in the robot's base
            frame [m], with ``DEFAULT_PATH_DT`` between its points.
        posture: The arm to dress.
        seed: Seed of the operator's variability.
        config: World, robot and rules.
        observer: Called after every control step.

    Raises:
        InvalidInputError: The path has the wrong shape or is not finite.
    """
    episode = Episode(posture, config)
    broke = episode.world.void_reason
    if broke is not None:
        return episode.void(broke)  # nobody is asked for a path from a place that makes no sense
    if isinstance(source, Operator):
        path = source.path(posture, episode.start, np.random.default_rng(seed))
        return episode.follow(path, source.config.dt, observer)
    if isinstance(source, np.ndarray):
        return episode.follow(checked_path(source, "the path"), DEFAULT_PATH_DT, observer)
    path, dt = policy_path(
        source, posture.frames(), episode.start, DEFAULT_PATH_DT, episode.config.time_limit
    )
    return episode.follow(path, dt, observer)


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
) -> tuple[Demonstration | None, Outcome]:
    """Record a demonstration of the scripted operator.

    Returns:
        What the gripper did from its first to its last command, without the final hold, or None
        if the robot could not move; and the outcome, which says whether it is worth learning from.
    """
    operator = operator or Operator()
    config = config or EpisodeConfig()
    recording = record(operator, posture, seed, config, observer)
    if recording.trace is None or recording.trajectory is None:
        return None, recording.outcome
    commands = recording.trajectory.positions
    demonstration = Demonstration(
        positions=recording.positions[: len(commands)],
        dt=recording.trajectory.dt,
        posture=posture,
        seed=seed,
        commands=commands[: len(recording.positions)],
        settings={"episode": to_plain(config), "operator": to_plain(operator.config)},
    )
    return demonstration, recording.outcome


def replay(demonstration: Demonstration, observer: Observer | None = None) -> Recording:
    """Play a demonstration's commands again in the world it was recorded in.

    With the versions that it was recorded with, the gripper's positions are the same to the bit.

    Raises:
        InvalidInputError: It does not say which world it was recorded in.
    """
    if "episode" not in demonstration.settings:
        raise InvalidInputError(
            f"the demonstration on {demonstration.posture.name!r} has no settings of its episode; "
            "valid is one that was recorded in the simulator"
        )
    config = from_plain(EpisodeConfig, demonstration.settings["episode"])
    episode = Episode(demonstration.posture, config)
    commands = demonstration.commands
    targets = np.array([episode.kinematics.tcp_pose(q)[0] for q in commands])
    return episode.play(
        JointTrajectory(commands, demonstration.dt, targets, np.zeros(len(commands))), observer
    )
