"""Pinocchio kinematics of the Panda, and the inverse kinematics that follows a path."""

from dressing_sim.control.kinematics import PandaKinematics
from dressing_sim.control.tracking import (
    JointTrajectory,
    Tracker,
    TrackingConfig,
    configuration_at,
    track_path,
)

__all__ = [
    "JointTrajectory",
    "PandaKinematics",
    "Tracker",
    "TrackingConfig",
    "configuration_at",
    "track_path",
]
