"""Numbers and verdict, written into a picture."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path

import matplotlib
import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from dressing_sim.arm import Posture
from dressing_sim.episode.trace import region
from dressing_sim.pictures.story import Moment, Story
from dressing_sim.pictures.strain_colours import StrainScale
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.sleeve import SleeveMesh
from dressing_sim.world.strain import StrainGauge

#: What is drawn is not all simulated; said in every film.
DRAWN = "cloth, person and room are drawn finer than simulated; numbers are the simulation's"

_WHITE, _GREY = (250, 250, 250), (190, 194, 200)
_GOOD, _BAD = (120, 220, 140), (255, 128, 110)


class Caption:
    """Writes captions for one episode.

    Args:
        posture: The arm.
        mesh: The sleeve at rest.
        story: Of the episode.
        end: Time of the film's last moment [s].
        heat: The scale of strain, if the cloth is drawn in its colours.
    """

    def __init__(
        self,
        posture: Posture,
        mesh: SleeveMesh,
        story: Story,
        end: float,
        heat: StrainScale | None = None,
    ) -> None:
        self._posture, self._gauge, self._mesh = posture, StrainGauge(mesh), mesh
        self._story, self._end, self._heat = story, end, heat

    def numbers(self, moment: Moment) -> str:
        """Time, arm coordinate, force and strain in a line."""
        ring = self._mesh.rings(moment.cloth)[0].mean(axis=0)
        s = float(ArmAxis.of(moment.arm(self._posture)).coordinate(ring[None])[0])
        percent = self._story.thresholds.strain_percentile
        strain = self._gauge.percentile(self._gauge.principal(moment.cloth), percent)
        return (
            f"{moment.time:4.1f} s    s {s:5.2f} {region(s)}    "
            f"pull {moment.grip_force:4.1f} N    strain {100.0 * strain:3.0f} %"
        )

    def write(self, picture: NDArray[np.uint8], moment: Moment) -> None:
        """Write into the lower part of a picture (height, width, 3), which changes."""
        height, width, _ = picture.shape
        size = max(8, round(min(width / 46.0, height / 24.0)))
        band = picture[max(0, height - round(3.9 * size)) :]
        image = Image.fromarray(band // 4)
        draw = ImageDraw.Draw(image)
        margin, line = 0.6 * size, 1.25 * size
        verdict = self._story.verdict(moment.time, self._end)
        colour = _GOOD if verdict == "success" else _BAD
        draw.text((margin, 0.3 * size), self._story.title, _WHITE, _font(size))
        draw.text((width - margin, 0.3 * size), verdict, colour, _font(size), anchor="ra")
        draw.text((margin, 0.3 * size + line), self.numbers(moment), _WHITE, _font(size))
        draw.text(
            (margin, 0.4 * size + 2.0 * line), DRAWN, _GREY, _font(max(7, round(0.68 * size)))
        )
        if self._heat is not None:
            self._scale(image, draw, width, size, margin + line)
        band[:] = np.asarray(image)

    def _scale(
        self, image: Image.Image, draw: ImageDraw.ImageDraw, width: int, size: int, top: float
    ) -> None:
        assert self._heat is not None
        bar = Image.fromarray(self._heat.picture()).resize((9 * size, round(0.7 * size)))
        left = width - round(13.0 * size)
        image.paste(bar, (left, round(top)))
        told = f"{100.0 * self._heat.top:.0f} %"
        draw.text((width - 0.6 * size, top), told, _GREY, _font(max(7, round(0.68 * size))), "ra")


@lru_cache(maxsize=8)
def _font(size: int) -> ImageFont.FreeTypeFont:
    return ImageFont.truetype(Path(matplotlib.get_data_path()) / "fonts/ttf/DejaVuSans.ttf", size)
