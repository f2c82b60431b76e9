"""Pictures of failed episodes at the moment of their failure."""

from __future__ import annotations

from io import BytesIO

import imageio.v3 as imageio
import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.records import EpisodeResult
from dressing_sim.benchmark.report.figures import first_failure
from dressing_sim.benchmark.run.replay import Replay, replay_episode
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.episode.dressing import Dressing
from dressing_sim.pictures.rendering import OffscreenRenderer, gl_backend
from dressing_sim.world.simulation import World


class FailurePictures:
    """Runs an episode of a run again and draws it as it was when the first thing went wrong.

    Args:
        folder: The run.
        camera: One of `dressing_sim.pictures.rendering.CAMERAS`.
        width: Of a picture [pixels].
        height: Of a picture [pixels].
    """

    def __init__(
        self, folder: RunFolder, camera: str = "front", width: int = 480, height: int = 360
    ) -> None:
        self.folder = folder
        self.camera = camera
        self.width = width
        self.height = height

    def __call__(self, result: EpisodeResult) -> bytes | None:
        """The picture as a PNG file; None if the episode does not come out as it was recorded.

        Raises:
            DressingSimError: No OpenGL works here.
        """
        gl_backend()  # without OpenGL, say so before simulating
        states: list[NDArray[np.float64]] = []

        def keep(world: World) -> None:
            states.append(world.data.qpos.copy())

        again = replay_episode(self.folder, result.index, keep)
        if again.differences:
            return None
        state = states[_row(again, len(states))] if states else _settled(again)
        with OffscreenRenderer(
            again.posture, again.config.world, self.width, self.height
        ) as renderer:
            picture = renderer.draw(state, self.camera)
        file = BytesIO()
        imageio.imwrite(file, picture, extension=".png")
        return file.getvalue()


def _row(again: Replay, n_rows: int) -> int:
    """Row of the control step at whose end the first thing went wrong, the last at most."""
    failure = first_failure(again.result.outcome)
    time = 0.0 if failure is None or failure.time is None else failure.time
    return min(max(round(time / again.config.tracking.dt) - 1, 0), n_rows - 1)


def _settled(again: Replay) -> NDArray[np.float64]:
    """The world before the robot moves, for an episode in which it never did."""
    dressing = Dressing(again.posture, again.config)
    dressing.reset()
    return dressing.world.data.qpos.copy()
