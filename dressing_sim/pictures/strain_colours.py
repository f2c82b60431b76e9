"""The cloth in colours of its strain, for pictures."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.world.sleeve import FLEX, SleeveMesh
from dressing_sim.world.strain import StrainGauge

#: Red, green and blue from no strain to the top, evenly spaced; their lightness rises evenly, so
#: that colour-blind readers tell them apart.
COLOURS = (
    (0.27, 0.00, 0.33),
    (0.23, 0.32, 0.55),
    (0.13, 0.57, 0.55),
    (0.37, 0.79, 0.38),
    (0.99, 0.91, 0.14),
)

_STEPS = 256


class StrainColours:
    """Paints the flex of a model that is made for drawing.

    Create it with the spec, compile, then call `paint` before each picture.

    Args:
        spec: Scene with the sleeve, not yet compiled; its flex gets a material.
        mesh: The sleeve at rest.
        top: Principal strain that is drawn in the last colour; no strain has the first.
    """

    def __init__(self, spec: mujoco.MjSpec, mesh: SleeveMesh, top: float) -> None:
        self._gauge = StrainGauge(mesh)
        self._mesh, self._top = mesh, top
        steps = np.linspace(0.0, len(COLOURS) - 1.0, _STEPS)
        rgb = np.stack([np.interp(steps, range(len(COLOURS)), c) for c in np.transpose(COLOURS)], 1)
        texture = spec.add_texture(
            name="strain", type=mujoco.mjtTexture.mjTEXTURE_2D, width=_STEPS, height=2, nchannel=3
        )
        texture.data = np.repeat(np.round(255 * rgb).astype(np.uint8)[None], 2, axis=0).tobytes()
        material = spec.add_material(name="strain")
        textures = material.textures
        textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = "strain"
        material.textures = textures
        flex = next(flex for flex in spec.flexes if flex.name == FLEX)
        flex.material = "strain"
        flex.rgba = [1.0, 1.0, 1.0, 1.0]
        flex.texcoord = np.zeros(2 * len(mesh.vertices), dtype=np.float32).tolist()

    def at_vertices(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean strain of the triangles round each vertex, by area, shape (n_vertices,).

        Args:
            positions: Of the cloth's vertices, shape (n_vertices, 3) [m].
        """
        corners = self._mesh.triangles.ravel()
        areas = np.repeat(self._gauge.areas, 3)
        strains = np.repeat(self._gauge.principal(positions), 3)
        return np.bincount(corners, areas * strains) / np.bincount(corners, areas)

    def paint(self, model: mujoco.MjModel, positions: NDArray[np.float64]) -> None:
        """Colour the model's cloth by its strain.

        Args:
            model: Compiled from the spec.
            positions: Of the cloth's vertices, shape (n_vertices, 3) [m].
        """
        share = np.clip(self.at_vertices(positions) / self._top, 0.0, 1.0)
        # Half a texel in from either end, where the texture would wrap round.
        model.flex_texcoord[:, 0] = (0.5 + share * (_STEPS - 1)) / _STEPS
        model.flex_texcoord[:, 1] = 0.5
