"""Pinocchio kinematics of the robot, and the inverse kinematics that follows a path."""

from dressing_sim.control.kinematics import RobotKinematics
from dressing_sim.control.tracking import (
    HAND_DOWN,
    JointTrajectory,
    Tracker,
    TrackingConfig,
    configuration_at,
    track_path,
)

__all__ = [
    "HAND_DOWN",
    "JointTrajectory",
    "RobotKinematics",
    "Tracker",
    "TrackingConfig",
    "configuration_at",
    "track_path",
]
