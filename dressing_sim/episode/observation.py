"""What a closed-loop policy may look at, once a control step."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Situation


@dataclass(frozen=True, slots=True, eq=False)
class Force:
    """Forces as their sensors read them.

    Attributes:
        grip: Pull of the gripper on the cloth [N].
        links: Net force of the cloth on each link of the mannequin, (n_links, 3), in the robot's
            base frame [N].
    """

    grip: float
    links: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Observation:
    """One moment of a dressing, as far as the policy's class of inputs lets it see.

    Attributes:
        time: Since the robot began to move [s].
        dt: Time until the next observation [s].
        tcp: Gripper (3,), in the robot's base frame [m].
        target: The target (3,) that it last approached [m].
        frames: The frames, or the posture, of its class of inputs, as in ``generate``; of an arm
            that moves the newest that were measured.
    """

    time: float
    dt: float
    tcp: NDArray[np.float64]
    target: NDArray[np.float64]
    frames: Situation | Posture
    _force: Force | None = field(default=None, repr=False)

    @property
    def force(self) -> Force:
        """What the sensors of force read.

        Raises:
            InvalidInputError: The policy did not declare that it uses them.
        """
        if self._force is None:
            raise InvalidInputError(
                "this policy does not declare that it uses forces; valid is a class with "
                "inputs = 'frames+force'"
            )
        return self._force
