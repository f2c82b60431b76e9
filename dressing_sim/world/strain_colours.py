"""The cloth in colours of its strain, for pictures."""

from __future__ import annotations

import mujoco
import numpy as np
from matplotlib import colormaps
from numpy.typing import NDArray

from dressing_sim.world.sleeve import FLEX, SleeveMesh
from dressing_sim.world.strain import StrainGauge

#: Matplotlib's name of the colours; even in lightness, and told apart by colour-blind readers.
COLOURS = "viridis"

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
        rgb = np.round(255 * colormaps[COLOURS](np.linspace(0.0, 1.0, _STEPS))[:, :3])
        texture = spec.add_texture(
            name="strain", type=mujoco.mjtTexture.mjTEXTURE_2D, width=_STEPS, height=2, nchannel=3
        )
        texture.data = np.repeat(rgb.astype(np.uint8)[None], 2, axis=0).tobytes()
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
