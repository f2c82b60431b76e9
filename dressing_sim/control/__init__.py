"""Pinocchio kinematics of the Panda, and the inverse kinematics that follows a path."""

from dressing_sim.control.kinematics import PandaKinematics
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
    "PandaKinematics",
    "Tracker",
    "TrackingConfig",
    "configuration_at",
    "track_path",
]
