"""Pictures of failed episodes at the moment of their failure."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO

import imageio.v3 as imageio
import numpy as np
from numpy.typing import NDArray

from dressing_sim.benchmark.analysis.episodes import EpisodeTable
from dressing_sim.benchmark.analysis.failures import hardest
from dressing_sim.benchmark.records import EpisodeResult, first_failure
from dressing_sim.benchmark.run.replay import Repeatable, replay_episode
from dressing_sim.benchmark.run.store import RunFolder
from dressing_sim.benchmark.studies.success_document import Pictures
from dressing_sim.episode.dressing import Dressing
from dressing_sim.errors import DressingSimError
from dressing_sim.pictures.rendering import OffscreenRenderer, gl_backend
from dressing_sim.world.simulation import World


def failure_pictures(
    study: Repeatable, folder: RunFolder, results: Sequence[EpisodeResult]
) -> Pictures:
    """A failed episode of each of the hardest postures; where no OpenGL works, why none."""
    found = {}
    try:
        for hard in hardest(EpisodeTable.of(results)):
            drawn = failure_picture(study, folder, hard.pictured)
            if drawn is not None:
                found[hard.pictured.index] = drawn
    except DressingSimError as error:
        return Pictures(missing=f"pictures left out: {error}")
    return Pictures(found)


def failure_picture(
    study: Repeatable,
    folder: RunFolder,
    result: EpisodeResult,
    camera: str = "front",
    width: int = 480,
    height: int = 360,
) -> bytes | None:
    """Run an episode again and draw it as it was when the first thing went wrong.

    Args:
        study: The run's.
        folder: The run.
        result: Which episode.
        camera: One of `dressing_sim.pictures.CAMERAS`.
        width: Of the picture [pixels].
        height: Of the picture [pixels].

    Returns:
        A PNG file; None if the episode does not come out as it was recorded.

    Raises:
        DressingSimError: No OpenGL works here.
    """
    gl_backend()  # without OpenGL, say so before simulating
    states: list[NDArray[np.float64]] = []

    def keep(world: World) -> None:
        states.append(world.data.qpos.copy())

    again = replay_episode(study, folder, result.index, keep)
    if again.differences:
        return None
    if not states:  # the robot never moved
        dressing = Dressing(again.posture, again.config)
        dressing.reset()
        keep(dressing.world)
    failure = first_failure(again.result.outcome)
    time = 0.0 if failure is None or failure.time is None else failure.time
    # The control step at whose end it went wrong, the last at most.
    row = min(max(round(time / again.config.tracking.dt) - 1, 0), len(states) - 1)
    with OffscreenRenderer(again.posture, again.config.world, width, height) as renderer:
        picture = renderer.draw(states[row], camera)
    file = BytesIO()
    imageio.imwrite(file, picture, extension=".png")
    return file.getvalue()
