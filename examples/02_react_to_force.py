"""A policy that looks at the measured force in every control step, and goes round when it rises.

python examples/02_react_to_force.py
"""

from typing import Self

import numpy as np

from dressing_sim import Posture, dress, load_suite


class GoRound:
    """Follows the straight line to the shoulder; gives way upwards while the cloth pulls hard."""

    inputs = "frames+force"  # without this, asking for the force is an error
    SPEED, HARD, HEIGHT = 0.10, 1.5, 0.09  # [m/s], [N], [m]

    def fit(self, demonstrations: object) -> Self:
        """There is nothing to learn."""
        return self

    def reset(self) -> None:
        """An episode begins."""
        self.waited = 0.0

    def act(self, observation) -> np.ndarray | None:
        """The next target of the gripper (3,) [m], or None once it has arrived."""
        goal = observation.frames.shoulder.b + [0.0, 0.0, self.HEIGHT]
        way = goal - observation.target
        distance = np.linalg.norm(way)
        if distance < 0.002 or observation.time > 20.0:
            return None
        step = self.SPEED * observation.dt * way / distance
        if observation.force.grip > self.HARD and self.waited < 3.0:
            self.waited += observation.dt
            step = 0.3 * step + [0.0, 0.0, 0.3 * self.SPEED * observation.dt]
        return observation.target + step


posture: Posture = load_suite("paper5")[1]
outcome = dress(GoRound(), posture)
print(posture.name, "success" if outcome.success else outcome.reasons)
for name in ("armscye_s", "grip_force", "strain"):
    print(f"  {name}: {outcome.metrics[name]:.3f}")
