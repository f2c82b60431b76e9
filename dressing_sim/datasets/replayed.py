"""Pictures of a demonstration: it is played again, and drawn row by row."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import listed, one_of, whole_number
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.record import recorded_in
from dressing_sim.errors import InvalidInputError
from dressing_sim.pictures import CAMERAS, LARGEST_SIDE
from dressing_sim.pictures.rendering import OffscreenRenderer

#: Played again the gripper is where it was within this [m]: another kind of processor rounds
#: otherwise, another version of a package does not get near.
_SAME = 1e-4


@dataclass(frozen=True, slots=True)
class Cameras:
    """Whose pictures are wanted."""

    names: tuple[str, ...]
    """Some of `dressing_sim.pictures.CAMERAS`."""
    width: int = 640
    """Of a picture [pixels]."""
    height: int = 480
    """Of a picture [pixels]."""

    def __post_init__(self) -> None:
        chosen = listed(self.names, "cameras", f"some of {', '.join(CAMERAS)}")
        for name in chosen:
            one_of(name, "cameras", CAMERAS)
        if len({*chosen}) != len(chosen) or not chosen:
            raise InvalidInputError(
                f"cameras are {', '.join(chosen) or 'none'}; valid is one or more, each once"
            )
        for side in ("width", "height"):
            whole_number(getattr(self, side), f"cameras: {side}", 1, LARGEST_SIDE)
        object.__setattr__(self, "names", chosen)


def pictures(
    demonstration: Demonstration, cameras: Cameras
) -> Iterator[dict[str, NDArray[np.uint8]]]:
    """Play a demonstration again and draw each of its T rows, as the environments draw it.

    Yields:
        By camera, a picture (height, width, 3).

    Raises:
        InvalidInputError: It does not say which world it was recorded in, or goes elsewhere now.
        DressingSimError: No OpenGL works here.
    """
    dressing, commands = recorded_in(demonstration)
    posture, world = demonstration.posture, dressing.config.world
    place = dressing.reset(commands[0]).tcp
    with OffscreenRenderer(posture, world, cameras.width, cameras.height) as renderer:
        for row, position in enumerate(demonstration.positions):
            if row:
                place = dressing.step_joints(commands[row]).tcp
            off = float(np.linalg.norm(place - position))
            if off > _SAME:
                raise InvalidInputError(
                    f"the demonstration on {posture.name!r}, played again, is {off:.3g} m off in "
                    f"row {row}; valid is one recorded with the packages installed here"
                )
            qpos = dressing.world.data.qpos
            yield {camera: renderer.draw(qpos, camera) for camera in cameras.names}
