"""The sleeve as drawn: smoother than it is simulated, with a thickness, and outside the skin.

Drawn only. The fine surface passes through the simulated vertices, save where the skin that is
drawn would poke through: there it is moved out of it.
"""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.pictures.implicit import Field, gradient
from dressing_sim.pictures.reshaping import reshape
from dressing_sim.pictures.strain_colours import StrainScale
from dressing_sim.pictures.subdivision import subdivided
from dressing_sim.pictures.weave import weave
from dressing_sim.world.sleeve import SleeveMesh

NAME = "drawn_sleeve"

#: Geom group of the sleeve, which moves although it hangs on no joint.
SLEEVE_GROUP = 4

#: Thickness of the cloth and of its hems as drawn [m]; jersey has 1 mm, a hem two layers.
_THICK, _HEM_THICK = 0.0020, 0.0036

#: Width of the hems [m].
_HEM = 0.018

#: From the skin to the inner side of the cloth, at least [m].
_GAP, _LEAST_GAP = 0.0012, 0.0004

#: The sleeve is divided until it has so many triangles a side.
_ENOUGH = 2000


class DrawnSleeve:
    """The sleeve's mesh in a model that is made for drawing.

    Create it with the spec, compile, then `place` it before each picture.

    Args:
        spec: To which the mesh and its fabric are added.
        mesh: The simulated sleeve at rest.
        skin: What the cloth is kept outside of.
        strain: The scale of its colours, or None for cloth in its own.

    Attributes:
        skin: As given; another one once the person has moved.
    """

    def __init__(
        self, spec: mujoco.MjSpec, mesh: SleeveMesh, skin: Field, strain: StrainScale | None
    ) -> None:
        self._mesh, self.skin, self._strain = mesh, skin, strain
        levels = next(n for n in range(6) if len(mesh.triangles) * 4**n >= _ENOUGH or n == 5)
        self._fine = fine = subdivided(mesh.triangles, len(mesh.vertices), levels)
        n, rest = len(fine.smooth), fine.through @ mesh.vertices
        coarse_edge = np.zeros(n, dtype=bool)
        coarse_edge[fine.edges] = True
        far = np.linalg.norm(rest[:, None] - rest[coarse_edge][None], axis=2).min(axis=1)
        self._half = 0.5 * np.where(far < _HEM, _HEM_THICK, _THICK)
        a, b = fine.edges.T
        c, d, e, f = a + n, b + n, a + 2 * n, b + 2 * n
        rim = [(a, e, f), (a, f, b), (e, c, d), (e, d, f)]
        self._faces = np.concatenate(
            [fine.triangles, fine.triangles[:, ::-1] + n, *(np.stack(t, axis=1) for t in rim)]
        ).astype(np.int32)
        used = np.unique(self._faces)
        self._used = used
        self._faces = np.searchsorted(used, self._faces).astype(np.int32)
        self._corner_texture(rest)
        self._add(spec)

    def _corner_texture(self, rest: NDArray[np.float64]) -> None:
        """A place in the fabric's picture for each corner of each triangle."""
        mesh = self._mesh
        rings = mesh.rings(mesh.vertices)
        start, end = rings[0].mean(axis=0), rings[-1].mean(axis=0)
        axis = (end - start) / np.linalg.norm(end - start)
        up = rings[0, 0] - start
        up = (up - up @ axis * axis) / np.linalg.norm(up - up @ axis * axis)
        offset = rest - start
        angle = np.arctan2(offset @ np.cross(axis, up), offset @ up) / (2.0 * np.pi)
        place = np.stack([angle, offset @ axis / np.linalg.norm(end - start)], axis=1)
        corners = np.tile(place, (3, 1))[self._used][self._faces]
        # Round the back the angle jumps by a turn: a triangle must not see all of the picture.
        first = corners[:, :1, 0]
        corners[:, :, 0] -= np.round(corners[:, :, 0] - first)
        self._texture = corners.reshape(-1, 2)

    def _add(self, spec: mujoco.MjSpec) -> None:
        ends = self._mesh.rings(self._mesh.vertices)[[0, -1]].mean(axis=1)
        picture = (
            weave(_HEM / float(np.linalg.norm(ends[1] - ends[0])))
            if self._strain is None
            else self._strain.picture()
        )
        texture = spec.add_texture(
            name=NAME,
            type=mujoco.mjtTexture.mjTEXTURE_2D,
            width=picture.shape[1],
            height=picture.shape[0],
            nchannel=3,
        )
        texture.data = picture.tobytes()
        material = spec.add_material(name=NAME, specular=0.08, shininess=0.15)
        textures = material.textures
        textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = NAME
        material.textures = textures
        points, normals = self.shape(self._mesh.vertices)
        n_corners = self._faces.size
        spec.add_mesh(
            name=NAME,
            uservert=points.ravel(),
            userface=self._faces.ravel(),
            usernormal=normals.ravel(),
            userfacenormal=self._faces.ravel(),
            usertexcoord=self._texture.ravel(),
            userfacetexcoord=np.arange(n_corners),
            inertia=mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL,
        )
        spec.worldbody.add_geom(
            name=NAME,
            type=mujoco.mjtGeom.mjGEOM_MESH,
            meshname=NAME,
            material=NAME,
            contype=0,
            conaffinity=0,
            mass=0.0,
            group=SLEEVE_GROUP,
        )

    def shape(
        self, positions: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The drawn surface.

        Args:
            positions: Of the simulated vertices, shape (n_vertices, 3) [m].

        Returns:
            Vertices (n, 3) [m] and normals (n, 3): outer side, inner side, and rim.
        """
        fine = self._fine
        middle = fine.through @ positions
        for _ in range(2):  # where fingers meet, the nearest way out is not yet out
            depth = _GAP + self._half - self.skin(middle)
            under = depth > 0.0
            if not under.any():
                break
            middle[under] += depth[under, None] * gradient(self.skin, middle[under])
        corners = middle[fine.triangles]
        across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        normals = np.empty_like(middle)
        for axis in range(3):
            weights = np.repeat(across[:, axis], 3)
            normals[:, axis] = np.bincount(fine.triangles.ravel(), weights, len(middle))
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
        offset = self._half[:, None] * normals
        a, b = fine.edges.T
        outwards = np.zeros_like(middle)
        beside = np.cross(middle[b] - middle[a], normals[a])
        np.add.at(outwards, a, beside)
        np.add.at(outwards, b, beside)
        outwards /= np.maximum(np.linalg.norm(outwards, axis=1, keepdims=True), 1e-12)
        points = [middle + offset, middle - offset, middle + 0.8 * self._half[:, None] * outwards]
        surface = np.concatenate(points)[self._used]
        depth = _LEAST_GAP - self.skin(surface)  # in sharp folds a side is not where it was sent
        under = depth > 0.0
        if under.any():
            surface[under] += depth[under, None] * gradient(self.skin, surface[under])
        return surface, np.concatenate([normals, -normals, outwards])[self._used]

    def place(self, model: mujoco.MjModel, positions: NDArray[np.float64]) -> int:
        """Move the model's mesh to where the cloth is.

        Args:
            model: Compiled from the spec.
            positions: Of the simulated vertices, shape (n_vertices, 3) [m].

        Returns:
            The mesh to upload.
        """
        mesh = reshape(model, NAME, *self.shape(positions))
        if self._strain is not None:
            strain = self._fine.smooth @ self._strain.at_vertices(positions)
            column = self._strain.column(np.tile(strain, 3)[self._used])
            at, n = model.mesh_texcoordadr[mesh], model.mesh_texcoordnum[mesh]
            model.mesh_texcoord[at : at + n, 0] = column[self._faces.ravel()]
            model.mesh_texcoord[at : at + n, 1] = 0.5
        return mesh
