"""What LeRobot calls things: one name in data sets and environments, so that policies fit both."""

from __future__ import annotations

#: The gripper's place, and the frames: all numbers of a row.
STATE, FRAMES = "observation.state", "observation.environment_state"

#: What a camera's pictures begin with; its name follows after a dot.
PICTURES = "observation.images"

#: What the robot is told that it does.
TASK = "Put the sleeve over the arm, up to the shoulder."
