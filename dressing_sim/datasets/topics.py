"""Names of a ROS 2 bag's topics; light, since the command line reads it whatever is asked for."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Topics:
    """Which topic has what. Lengths in a bag are metres, forces newtons (ROS REP 103)."""

    gripper: str = "/gripper"
    """Of the gripper: PoseStamped or PointStamped."""
    force: str = "/force"
    """Of the force on it: WrenchStamped; need not be there."""
    shoulder: str = "/shoulder"
    """PoseStamped or PointStamped."""
    elbow: str = "/elbow"
    """The same; without it the x axes of the poses of shoulder and wrist point at the elbow."""
    wrist: str = "/wrist"
    """PoseStamped or PointStamped."""
