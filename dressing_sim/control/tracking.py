"""From a path of the gripper to joint commands: differential inverse kinematics with limits.

Each control step solves one quadratic program (pink on Pinocchio, solver DAQP) well within the
joint position and velocity limits of the URDF, and with accelerations that the servos can follow.
The gripper's position has priority by weight; the hand points down and may turn about the vertical,
since the paper's policies say positions only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pink
import pinocchio as pin
from numpy.typing import NDArray
from pink.limits.limit import Limit
from pink.tasks import FrameTask, PostureTask

from dressing_sim.control.kinematics import PandaKinematics
from dressing_sim.settings import check_numbers
from dressing_sim.world.panda import HOME, TCP_BODY

#: The hand pointing down, fingers opening along the base's y axis.
_HAND_DOWN = np.diag([1.0, -1.0, -1.0])

#: Largest joint accelerations of a command [rad/s^2]: half of what the Panda's control interface
#: accepts. A servo that is asked for more than its torque saturates, falls behind and overshoots.
MAX_ACCELERATION = (7.5, 3.75, 5.0, 6.25, 7.5, 10.0, 10.0)

#: Share of the joints' speed limits that commands use: next to a person half is plenty, and the
#: servos overshoot by a few per cent.
SPEED_SHARE = 0.5

#: Commands stay this far within the joints' position limits, for the same reason [rad].
POSITION_MARGIN = 0.01


@dataclass(frozen=True, slots=True)
class TrackingConfig:
    """How a path is followed."""

    dt: float = 0.02
    """Time between two joint commands [s]."""
    max_speed: float = 0.25
    """The gripper never goes faster [m/s]: usual for a robot next to a person."""
    smoothing: float = 0.3
    """Corners of the path are rounded over this time, so that accelerations stay finite [s]."""
    position_cost: float = 1.0
    """Weight of the gripper's position error [1/m]."""
    tilt_cost: float = 0.1
    """Weight of the hand's deviation from pointing down [1/rad]."""
    posture_cost: float = 2e-3
    """Weight of the joints' deviation from the robot's resting posture [1/rad]."""
    max_error: float = 0.02
    """A path is unreachable if the commanded gripper is ever further from it than this [m]."""

    def __post_init__(self) -> None:
        check_numbers(
            self,
            "tracking",
            ("dt", "max_speed", "position_cost", "max_error"),
            ("smoothing", "tilt_cost", "posture_cost"),
        )


@dataclass(frozen=True, slots=True)
class JointTrajectory:
    """Joint commands, one each `dt` seconds.

    Attributes:
        positions: Joint positions, shape (n_steps, 7) [rad].
        dt: Time between two rows [s].
        targets: Where the gripper should be, shape (n_steps, 3), in the robot's base frame [m].
        errors: Distance between the commanded gripper and its target, shape (n_steps,) [m].
    """

    positions: NDArray[np.float64]
    dt: float
    targets: NDArray[np.float64]
    errors: NDArray[np.float64]

    @property
    def max_error(self) -> float:
        """Largest distance between the commanded gripper and its target [m]."""
        return float(self.errors.max())


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
    durations = np.linalg.norm(np.diff(path, axis=0), axis=1) / max_speed
    times = np.concatenate([[0.0], np.cumsum(np.maximum(durations, path_dt))])
    end = min(times[-1], max_duration)
    samples = np.append(np.arange(0.0, end, dt), end)
    return np.column_stack([np.interp(samples, times, column) for column in path.T])


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


class _JointLimits(Limit):
    """Bounds on the joints' next move, which all are bounds on each joint alone.

    Its speed stays below its limit, changes by no more than the largest acceleration a, and is so
    low that the joint can still come to rest within the distance d to its end of travel:
    ``v dt + v^2 / 2 a <= d`` (a step at v, then braking). Whoever keeps this keeps it one step
    later by braking, so there always is a solution.

    Args:
        model: The robot.
        acceleration: Largest acceleration of each joint, shape (n,) [rad/s^2]; may be infinite.
    """

    def __init__(self, model: pin.Model, acceleration: NDArray[np.float64]) -> None:
        self.lower = model.lowerPositionLimit + POSITION_MARGIN
        self.upper = model.upperPositionLimit - POSITION_MARGIN
        self._speed = SPEED_SHARE * model.velocityLimit
        self._acceleration = acceleration
        self._sides = np.vstack([np.eye(model.nv), -np.eye(model.nv)])
        self.velocity = np.zeros(model.nv)
        """What the joints last moved with [rad/s]."""

    def _fastest(
        self, room: NDArray[np.float64], now: NDArray[np.float64], dt: float
    ) -> NDArray[np.float64]:
        """Largest speed towards one side, from the room and the speed now in its direction."""
        a = self._acceleration
        if np.isinf(a).any():
            return np.minimum(self._speed, room / dt)
        stopping = np.sqrt((a * dt) ** 2 + 2.0 * a * np.maximum(room, 0.0)) - a * dt
        return np.maximum(np.minimum(np.minimum(self._speed, stopping), now + a * dt), now - a * dt)

    def compute_qp_inequalities(
        self, configuration: pink.Configuration, dt: float
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Matrix G and vector h of ``G move <= h``."""
        up = self._fastest(self.upper - configuration.q, self.velocity, dt)
        down = self._fastest(configuration.q - self.lower, -self.velocity, dt)
        return self._sides, dt * np.concatenate([up, down])


class _InverseKinematics:
    """The quadratic program of one control step, and the configuration it moves."""

    def __init__(
        self,
        kinematics: PandaKinematics,
        config: TrackingConfig,
        q: NDArray[np.float64],
        acceleration: NDArray[np.float64],
    ) -> None:
        model = kinematics.model
        self._dt = config.dt
        self._limits = _JointLimits(model, acceleration)
        start = np.clip(q, self._limits.lower, self._limits.upper)
        self.configuration = pink.Configuration(model, model.createData(), start)
        # The third rotation, about the hand's own axis, costs nothing.
        self._hand = FrameTask(
            TCP_BODY,
            position_cost=config.position_cost,
            orientation_cost=[config.tilt_cost, config.tilt_cost, 0.0],
        )
        posture = PostureTask(cost=config.posture_cost)
        posture.set_target(np.array(HOME))
        self._tasks = [self._hand, posture]

    def step(self, target: NDArray[np.float64]) -> float:
        """Move towards a target (3,) for one control step; returns the distance left [m]."""
        self._hand.set_target(pin.SE3(_HAND_DOWN, target))
        velocity = pink.solve_ik(
            self.configuration,
            self._tasks,
            self._dt,
            solver="daqp",
            damping=1e-9,
            limits=[self._limits],
            safety_break=False,
        )
        q = self.configuration.integrate(velocity, self._dt)
        # The solver keeps the limits up to its tolerance; the robot gets them exactly.
        q = np.clip(q, self._limits.lower, self._limits.upper)
        self._limits.velocity = (q - self.configuration.q) / self._dt
        self.configuration.update(q)
        reached = self.configuration.get_transform_frame_to_world(TCP_BODY).translation
        return float(np.linalg.norm(reached - target))


def configuration_at(
    position: NDArray[np.float64],
    kinematics: PandaKinematics,
    config: TrackingConfig | None = None,
    max_steps: int = 500,
) -> tuple[NDArray[np.float64], float]:
    """A configuration whose gripper is at a position, found from the robot's resting posture.

    Args:
        position: Where the gripper should be, (3,), in the robot's base frame [m].
        kinematics: The robot.
        config: Weights and limits.
        max_steps: Control steps after which the search ends.

    Returns:
        Joint positions (7,) [rad], and the distance left [m].
    """
    at_once = np.full(len(HOME), np.inf)
    ik = _InverseKinematics(kinematics, config or TrackingConfig(), np.array(HOME), at_once)
    previous = ik.configuration.q
    error = np.inf
    for _ in range(max_steps):
        error = ik.step(position)
        if np.abs(ik.configuration.q - previous).max() < 1e-7:
            break
        previous = ik.configuration.q
    return ik.configuration.q.copy(), error


def track_path(
    path: NDArray[np.float64],
    path_dt: float,
    start: NDArray[np.float64],
    kinematics: PandaKinematics,
    config: TrackingConfig | None = None,
    max_duration: float = np.inf,
) -> JointTrajectory:
    """Joint commands that lead the gripper along a path.

    Args:
        path: Positions of the gripper, shape (n, 3), in the robot's base frame [m].
        path_dt: Time between two rows [s].
        start: Joint positions (7,) to start from [rad].
        kinematics: The robot.
        config: Weights, speed and limits.
        max_duration: What comes later is left out [s].

    Returns:
        The trajectory from `start`: first straight to the path's first point, then along it.
    """
    config = config or TrackingConfig()
    start = np.array(start, dtype=float)
    ik = _InverseKinematics(kinematics, config, start, np.array(MAX_ACCELERATION))
    here = kinematics.tcp_pose(start)[0]
    targets = retime(np.vstack([here, path]), path_dt, config.dt, config.max_speed, max_duration)
    targets = smooth(targets, config.dt, config.smoothing)
    errors = np.empty(len(targets))
    positions = np.empty((len(targets), len(HOME)))
    for i, target in enumerate(targets):
        errors[i] = ik.step(target)
        positions[i] = ik.configuration.q
    return JointTrajectory(positions, config.dt, targets, errors)
