"""What an agent sees and does: choices of an environment, and the ranges that follow from them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import SITUATION
from dressing_sim.checks import (
    listed,
    of_kind,
    one_of,
    real_vector,
    shown,
    truth_value,
    whole_number,
)
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.pictures import CAMERAS, LARGEST_SIDE
from dressing_sim.suites.suites import find_posture
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.scene import resting_sleeve

#: What can be observed besides what always is.
EXTRAS = ("arm_coordinate", "link_force", "cloth", "image")

#: Nothing that is observed is farther away [m], pulls harder [N], or is farther along the arm.
FARTHEST, STRONGEST, BEYOND = 10.0, 1e4, 100.0

#: The hand turns by up to this much about each axis from pointing down [rad].
LARGEST_TURN = 1.0


class Range(NamedTuple):
    """Shape, kind and bounds of one array of numbers."""

    shape: tuple[int, ...]
    low: NDArray[np.float64] | float
    high: NDArray[np.float64] | float
    dtype: type = np.float64


@dataclass(frozen=True, slots=True)
class EnvConfig:
    """What an agent sees, does and is rewarded for."""

    control: str = "displacement"
    """``displacement`` of the gripper's target from the last one, or the ``target`` itself."""
    rotation: bool = False
    """Whether the agent turns the hand, too; else it points down and turns freely about that."""
    finish: str = "agent"
    """Who says that the robot has finished: the ``agent``, by one more number of its action, or
    ``arrival`` of gripper and sleeve where they should be."""
    observe: tuple[str, ...] = ()
    """Some of `EXTRAS`."""
    reward: str = "dense"
    """``dense`` or ``sparse``."""
    camera: str = "front"
    """One of `dressing_sim.pictures.CAMERAS`."""
    width: int = 640
    """Of a picture [pixels]."""
    height: int = 480
    """Of a picture [pixels]."""
    episode: EpisodeConfig = field(default_factory=EpisodeConfig)
    """World, robot and thresholds."""

    def __post_init__(self) -> None:
        one_of(self.control, "environment: control", ("displacement", "target"))
        one_of(self.finish, "environment: finish", ("agent", "arrival"))
        one_of(self.reward, "environment: reward", ("dense", "sparse"))
        one_of(self.camera, "environment: camera", CAMERAS)
        truth_value(self.rotation, "environment: rotation")
        for side in ("width", "height"):
            whole_number(getattr(self, side), f"environment: {side}", 1, LARGEST_SIDE)
        of_kind(self.episode, EpisodeConfig, "environment: episode", "an EpisodeConfig")
        observed = listed(self.observe, "environment: observe", f"some of {', '.join(EXTRAS)}")
        for name in observed:
            one_of(name, "environment: observe", EXTRAS)
        object.__setattr__(self, "observe", observed)

    @property
    def action_range(self) -> Range:
        """Displacement or target (3,) [m]; rotation vector (3,) [rad]; whether it has finished."""
        tracking = self.episode.tracking
        most = [tracking.max_speed * tracking.dt if self.control == "displacement" else 1.0] * 3
        most += [LARGEST_TURN] * 3 if self.rotation else []
        least = [-number for number in most]
        if self.finish == "agent":
            least, most = [*least, 0.0], [*most, 1.0]
        return Range((len(most),), np.array(least), np.array(most))

    @property
    def observation_ranges(self) -> dict[str, Range]:
        """What is observed, by name; see `dressing_sim.envs.gym.DressArm` for what it is."""
        place = Range((3,), -FARTHEST, FARTHEST)
        ranges = {"gripper": place, "target": place, "grip_force": Range((1,), 0.0, STRONGEST)}
        for name in SITUATION:
            ranges |= {f"{name}_position": place, f"{name}_axes": Range((3, 3), -1.0, 1.0)}
        for name in self.observe:
            ranges[name] = self._extra(name)
        return ranges

    def _extra(self, name: str) -> Range:
        if name == "arm_coordinate":
            return Range((2,), -BEYOND, BEYOND)
        if name == "link_force":
            return Range((len(LINKS), 3), -STRONGEST, STRONGEST)
        if name == "image":
            return Range((self.height, self.width, 3), 0, 255, np.uint8)
        # Every arm has the same garment.
        sleeve = resting_sleeve(find_posture("bent40"), self.episode.world.sleeve)
        return Range((len(sleeve.vertices), 3), -FARTHEST, FARTHEST)


def checked_action(action: object, size: int) -> NDArray[np.float64]:
    """An action (size,) of finite numbers. Its bounds are left to the robot's own limits.

    Raises:
        InvalidInputError: It is of another shape or not finite.
    """
    try:
        return real_vector(action, size, "action has")
    except InvalidInputError as error:
        raise InvalidInputError(
            f"action: {shown(action)}, valid are {size} finite numbers"
        ) from error
