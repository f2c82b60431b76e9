"""From a path of the gripper to joint commands: differential inverse kinematics with limits.

Each control step solves one quadratic program (see `MoveProgram`) well within the joint position
and velocity limits of the URDF, and with accelerations that the servos can follow.
The gripper's position has priority by weight; the hand points down and may turn about the vertical,
since the paper's policies say positions only.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import sqrt

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike, NDArray

from dressing_sim.checks import real_array, real_vector
from dressing_sim.config import check_numbers
from dressing_sim.control.kinematics import RobotKinematics
from dressing_sim.control.limits import JointLimits
from dressing_sim.control.program import MoveProgram
from dressing_sim.control.retiming import retime, smooth, times_of
from dressing_sim.errors import InvalidInputError

#: The hand pointing down, fingers opening along the base's y axis.
HAND_DOWN = np.diag([1.0, -1.0, -1.0])


#: How quickly the gripper gathers speed towards a target that is far away [m/s^2]: a quarter of a
#: second to full speed, which the joints can follow without overshooting. Own choice.
GRIPPER_ACCELERATION = 1.0


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
        positions: Joint positions, shape (n_steps, n) [rad].
        dt: Time between two rows [s].
        targets: Where the gripper should be, shape (n_steps, 3), in the robot's base frame [m].
        errors: Distance between the commanded gripper and its target, shape (n_steps,) [m].
        left_out: How much longer the whole path would take [s].
    """

    positions: NDArray[np.float64]
    dt: float
    targets: NDArray[np.float64]
    errors: NDArray[np.float64]
    left_out: float = 0.0

    @property
    def max_error(self) -> float:
        """Largest distance between the commanded gripper and its target [m]."""
        return float(self.errors.max())


class Tracker:
    """Follows targets of the gripper, one control step at a time.

    Every command keeps the joints' limits of position, speed and acceleration (see
    `JointLimits`). A target that is farther than one step at ``config.max_speed`` is
    approached at this speed, gathered and lost at `GRIPPER_ACCELERATION`. What it is
    at, it remembers: commands continue each other.

    Args:
        kinematics: The robot.
        config: Weights, speed and limits.
        acceleration: Largest acceleration of each joint, shape (n,) [rad/s^2]; the robot's if
            not given.

    Attributes:
        error: Distance between the last command's gripper and the target it approached [m].
        speed: How fast the target was approached in the last step [m/s].
    """

    def __init__(
        self,
        kinematics: RobotKinematics,
        config: TrackingConfig | None = None,
        acceleration: ArrayLike | None = None,
    ) -> None:
        self.config = config or TrackingConfig()
        robot, model = kinematics.robot, kinematics.model
        self._program = MoveProgram(model, robot, self.config.posture_cost)
        most = robot.acceleration if acceleration is None else acceleration
        self._limits = JointLimits(model, np.array(most, dtype=float))
        # The third rotation, about the hand's own axis, costs nothing unless it is asked for.
        place, tilt = self.config.position_cost, self.config.tilt_cost
        self._weight = np.diag([place, place, place, tilt, tilt, 0.0])
        self._turning_weight = np.diag([place, place, place, tilt, tilt, tilt])
        self._target: NDArray[np.float64] | None = None
        self.reset(np.array(robot.home))

    @property
    def command(self) -> NDArray[np.float64]:
        """The last command: joint positions (n,) [rad]."""
        return self._program.q.copy()

    @property
    def velocity(self) -> NDArray[np.float64]:
        """What the joints moved with in the last step, (n,) [rad/s]."""
        return self._limits.velocity.copy()

    @property
    def target(self) -> NDArray[np.float64]:
        """The target (3,) that the last command approached, in the robot's base frame [m]."""
        if self._target is None:
            self._target = self._program.gripper()
        return self._target.copy()

    def reset(
        self,
        q: NDArray[np.float64],
        velocity: NDArray[np.float64] | None = None,
        target: NDArray[np.float64] | None = None,
        speed: float = 0.0,
    ) -> None:
        """Begin anew from a configuration. From beyond the limits the joints come back to them.

        Args:
            q: Joint positions (n,) [rad].
            velocity: What the joints move with, (n,) [rad/s]; zero if not given.
            target: The target (3,) before the next one [m]; the gripper's place if not given.
            speed: How fast that target was approached [m/s].

        Raises:
            InvalidInputError: A value of another shape, or one that is not finite.
        """
        n = len(self._limits.lower)
        self._program.place(real_vector(q, n, "joint positions have", "rad"))
        self._limits.velocity = np.zeros(n)
        if velocity is not None:
            self._limits.velocity = real_vector(velocity, n, "joint velocities have", "rad/s")
        self._target = None if target is None else real_vector(target, 3, "target has", "m")
        self.speed = float(speed)
        self.error = 0.0

    def step(
        self, target: NDArray[np.float64], rotation: NDArray[np.float64] | None = None
    ) -> NDArray[np.float64]:
        """Move towards a target for one control step.

        Args:
            target: Gripper (3,), in the robot's base frame [m].
            rotation: Orientation of the hand in the robot's base frame, a matrix (3, 3) or a unit
                quaternion (4,), w first; without it the hand points down and turns freely about
                the vertical.

        Returns:
            The command: joint positions (n,) [rad].

        Raises:
            InvalidInputError: A value of another shape, not finite, or no rotation.
        """
        wanted = real_vector(target, 3, "target has", "m")
        orientation = HAND_DOWN if rotation is None else checked_rotation(rotation)
        weight = self._weight if rotation is None else self._turning_weight
        program, dt = self._program, self.config.dt
        place = self._target = self._approached(wanted)
        bounds = self._limits.bounds(program.q, dt)
        move = program.move(pin.SE3(orientation, place), weight, bounds)
        program.place(self._limits.moved(program.q, move, dt))
        off = program.gripper() - place
        self.error = sqrt(off.dot(off))
        return self.command

    def _approached(self, target: NDArray[np.float64]) -> NDArray[np.float64]:
        """The target, or as far towards it as the gripper may go in one step."""
        before, dt = self.target, self.config.dt
        way = target - before
        far = sqrt(way.dot(way))
        # Paths are retimed to just the highest speed; rounding must not change them.
        if far <= self.config.max_speed * dt * (1.0 + 1e-6):
            self.speed = far / dt
            return target
        faster = self.speed + GRIPPER_ACCELERATION * dt
        braking = sqrt(2.0 * GRIPPER_ACCELERATION * far)
        self.speed = min(self.config.max_speed, faster, braking)
        return before + self.speed * dt / far * way


def checked_rotation(values: object) -> NDArray[np.float64]:
    """A rotation matrix (3, 3) from a matrix or a unit quaternion (4,), w first.

    Raises:
        InvalidInputError: It is neither, by more than 1e-6.
    """
    valid = "valid is a rotation matrix (3, 3) or a unit quaternion (4,), w first"
    array = real_array(values, None, "rotation has")
    if array.shape == (4,) and abs(np.linalg.norm(array) - 1.0) <= 1e-6:
        w, x, y, z = array
        return np.array(pin.Quaternion(w, x, y, z).normalized().toRotationMatrix())
    turns = array.shape == (3, 3) and np.allclose(array.T @ array, np.eye(3), rtol=0.0, atol=1e-6)
    if turns and np.linalg.det(array) > 0.0:
        return array
    raise InvalidInputError(f"rotation: {array.tolist()}, {valid}")


def configuration_at(
    position: NDArray[np.float64],
    kinematics: RobotKinematics,
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
        Joint positions (n,) [rad], and the distance left [m].
    """
    tracker = Tracker(kinematics, config, np.full(kinematics.robot.n_joints, np.inf))
    previous = np.array(kinematics.robot.home)
    # The place is searched for, not led to: it is the target from the start.
    tracker.reset(previous, target=position)
    for _ in range(max_steps):
        q = tracker.step(position)
        if np.abs(q - previous).max() < 1e-7:
            break
        previous = q
    return tracker.command, tracker.error


def track_path(
    path: NDArray[np.float64],
    path_dt: float,
    start: NDArray[np.float64],
    kinematics: RobotKinematics,
    config: TrackingConfig | None = None,
    max_duration: float = np.inf,
) -> JointTrajectory:
    """Joint commands that lead the gripper along a path.

    Args:
        path: Positions of the gripper, shape (n, 3), in the robot's base frame [m].
        path_dt: Time between two rows [s].
        start: Joint positions (n,) to start from [rad].
        kinematics: The robot.
        config: Weights, speed and limits.
        max_duration: What comes later is left out [s].

    Returns:
        The trajectory from `start`: first straight to the path's first point, then along it.
    """
    config = config or TrackingConfig()
    start = np.array(start, dtype=float)
    tracker = Tracker(kinematics, config)
    tracker.reset(start)
    here = kinematics.tcp_pose(start)[0]
    whole = np.vstack([here, path])
    left_out = max(0.0, times_of(whole, path_dt, config.max_speed)[-1] - max_duration)
    targets = retime(whole, path_dt, config.dt, config.max_speed, max_duration)
    targets = smooth(targets, config.dt, config.smoothing)
    errors = np.empty(len(targets))
    positions = np.empty((len(targets), kinematics.robot.n_joints))
    for i, target in enumerate(targets):
        positions[i] = tracker.step(target)
        errors[i] = tracker.error
    return JointTrajectory(positions, config.dt, targets, errors, left_out)
