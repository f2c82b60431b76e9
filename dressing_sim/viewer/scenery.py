"""What stands round a dressing in the browser: light, floor, and what robot and person are on."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from dressing_sim.pictures.person import FLOOR

if TYPE_CHECKING:
    import viser


#: Height of a person's shoulder about which suites draw their postures [m].
_SHOULDER = 0.24

#: Where the floor is [m].
_GROUND = _SHOULDER - FLOOR


def furnish(scene: viser.SceneApi) -> None:
    """Light, a floor, and what robot and person are on."""
    scene.configure_default_lights(enabled=False)
    scene.configure_environment_map(None)
    scene.add_light_hemisphere(
        "/light/sky", sky_color=(255, 255, 255), ground_color=(150, 150, 160), intensity=1.6
    )
    # A directional light shines from its place towards the origin.
    scene.add_light_directional("/light/sun", intensity=1.5, position=(-0.6, 1.4, 2.2))
    scene.set_background_image(_backdrop())
    scene.add_grid(
        "/floor",
        width=4.0,
        height=4.0,
        position=(0.3, 0.0, _GROUND),
        cell_size=0.25,
        cell_color=(190, 196, 203),
        section_color=(165, 172, 180),
    )
    stand = (0.32, 0.32, -_GROUND)
    scene.add_box("/table", (92, 98, 108), stand, position=(-0.03, 0.0, 0.5 * _GROUND - 0.001))


def _backdrop() -> NDArray[np.uint8]:
    """A picture of a wall that is lighter above than below, (n, 2, 3)."""
    shade = np.linspace(238.0, 205.0, 256)[:, None]
    rgb = np.round(shade + np.array([-4.0, 0.0, 5.0])).astype(np.uint8)
    return np.repeat(rgb[:, None], 2, axis=1)
