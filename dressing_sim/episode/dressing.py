"""One dressing, from a path to an outcome."""

from __future__ import annotations

from collections.abc import Callable
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
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.meter import Meter
from dressing_sim.episode.recording import Recording
from dressing_sim.episode.rules import Failure, Outcome, ProtectiveStop, judge
from dressing_sim.world.scene import WorldConfig, grip_start
from dressing_sim.world.simulation import World

#: Called after every control step with the running world; for videos and views.
Observer = Callable[[World], None]

#: No part of the robot gets this far from its base's origin; farther points are not tried [m].
FARTHEST = 1.5

#: A cloth whose vertices are all slower than this hangs still [m/s].
_SETTLED_SPEED = 0.05


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
    while world.time < 3.0 * config.settle_time and world.invalid_reason is None:
        world.step()
        if world.time >= config.settle_time and world.cloth_speed < _SETTLED_SPEED:
            break
    return world, error


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
        if self.world.invalid_reason is not None:
            return self.void(self.world.invalid_reason)
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
        outcome = Outcome(False, invalid=reason)
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
            void = self.world.invalid_reason
            if void is not None:
                break
            stopped = bool(watch.see(meter.read(targets[row]))) or stopped
            positions.append(self.world.tcp_position)
            if observer is not None:
                observer(self.world)
            if stopped and config.protective_stop:
                break
        if void is not None and not stopped:
            trace, outcome = None, Outcome(False, invalid=void)
        else:
            trace = meter.trace(dt)
            outcome = judge(trace, self.posture.shoulder, finished, config.thresholds)
        return Recording(outcome, trace, trajectory, np.array(positions), finished, void)
