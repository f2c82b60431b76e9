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
from pink.tasks import FrameTask, PostureTask

from dressing_sim.config import check_numbers
from dressing_sim.control.kinematics import PandaKinematics
from dressing_sim.control.limits import MAX_ACCELERATION, JointLimitConstraint
from dressing_sim.control.retiming import retime, smooth
from dressing_sim.world.panda import HOME, TCP_BODY

#: The hand pointing down, fingers opening along the base's y axis.
_HAND_DOWN = np.diag([1.0, -1.0, -1.0])


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
        self._limits = JointLimitConstraint(model, acceleration)
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
