"""Everything that an episode's outcome depends on, but posture and path."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from dressing_sim.config import check_kinds, check_numbers
from dressing_sim.control import TrackingConfig
from dressing_sim.episode.capture import CaptureConfig
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.scene import WorldConfig


@dataclass(frozen=True, slots=True)
class EpisodeConfig:
    """Everything that an episode's outcome depends on, but posture and path."""

    world: WorldConfig = field(default_factory=WorldConfig)
    tracking: TrackingConfig = field(default_factory=TrackingConfig)
    thresholds: Thresholds = field(default_factory=Thresholds)
    capture: CaptureConfig = field(default_factory=CaptureConfig)
    """What policies are told of an arm that moves, or of any if it says so."""
    hold: float = 1.0
    """The robot stays at its path's end for so long before the verdict [s]."""
    time_limit: float = 30.0
    """The robot stops when it has moved for so long [s]."""
    protective_stop: bool = True
    """The simulation ends with the robot's protective stop. Without, it goes on, so that its
    trace can be judged with other thresholds; the outcome is the same."""

    def __post_init__(self) -> None:
        check_kinds(self, "episode")
        ratio = self.tracking.dt / self.world.solver.timestep
        if ratio < 1.0 or abs(ratio - round(ratio)) > 1e-9:
            raise InvalidInputError(
                f"the control step of {self.tracking.dt} s is not a multiple of the physics step "
                f"of {self.world.solver.timestep} s"
            )
        check_numbers(self, "episode", (), ("hold",))
        if not self.tracking.dt <= self.time_limit < np.inf:
            raise InvalidInputError(
                f"episode: time_limit is {self.time_limit} s, valid is at least the control step "
                f"of {self.tracking.dt} s"
            )
