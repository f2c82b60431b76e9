"""What follows a slider at once: the arm, its frames, and the path that a policy would take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.control import RobotKinematics, configuration_at
from dressing_sim.episode.record import DEFAULT_PATH_DT
from dressing_sim.errors import DressingSimError
from dressing_sim.learning import Policy
from dressing_sim.path import Path, policy_path
from dressing_sim.viewer.choices import Choices
from dressing_sim.world.scene import grip_start, resting_sleeve
from dressing_sim.world.sleeve import SleeveMesh


@dataclass(frozen=True, eq=False)
class Preview:
    """What is drawn of choices before anything is simulated.

    Attributes:
        choices: Of what.
        start: Where the gripper will hold the sleeve, (3,) [m].
        sleeve: The sleeve before it falls.
        path: Where the policy would lead the gripper; None while it has not learned, or if it
            gives no answer.
        why: Why there is no path, or nothing.
    """

    choices: Choices
    start: NDArray[np.float64]
    sleeve: SleeveMesh
    path: Path | None
    why: str = ""

    @property
    def posture(self) -> Posture:
        """The arm."""
        return self.choices.posture


def preview(choices: Choices, policy: Policy | None) -> Preview:
    """What choices look like; a policy is asked for its path, and nothing is simulated.

    The gripper is where the sleeve should be held. Where the robot really begins is a millimetre
    or two beside it, so that the path that is followed later may differ by as much.
    """
    posture, config = choices.posture, choices.config()
    sleeve = config.world.sleeve
    start, mesh = grip_start(posture, sleeve), resting_sleeve(posture, sleeve)
    if policy is None:
        return Preview(choices, start, mesh, None)
    limit = config.time_limit
    try:
        path = policy_path(policy, posture, start, choices.seed, DEFAULT_PATH_DT, limit)
    except DressingSimError as error:
        return Preview(choices, start, mesh, None, f"no path: {error}")
    return Preview(choices, start, mesh, path)


def resting(shown: Preview, kinematics: RobotKinematics) -> NDArray[np.float64]:
    """Joint positions (7,) with which the robot holds the sleeve [rad]; it takes a moment."""
    return configuration_at(shown.start, kinematics, shown.choices.config().tracking)[0]
