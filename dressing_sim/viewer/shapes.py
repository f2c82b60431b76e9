"""What is drawn, as meshes: arrays in, arrays out, in the robot's base frame."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from dressing_sim.arm import Posture
from dressing_sim.pictures.meshes import robot_skin
from dressing_sim.pictures.person import SKIN_INSET
from dressing_sim.pictures.person import person as drawn_person
from dressing_sim.pictures.strain_colours import COLOURS
from dressing_sim.pictures.subdivision import subdivided
from dressing_sim.world.mannequin import ARM_LINKS, LINKS, SHIRT, SKIN, add_mannequin
from dressing_sim.world.robot import PANDA
from dressing_sim.world.robot_spec import robot_spec
from dressing_sim.world.scene import compiled
from dressing_sim.world.sleeve import SleeveMesh
from dressing_sim.world.strain import StrainGauge

#: Points round a capsule, and rings of each of its caps.
_AROUND, _CAP = 20, 6

#: Vertices of the robot's skin that are nearer than this become one [m]: a browser draws a tenth.
_GRAIN = 0.005

#: Colours in which strain is drawn.
N_COLOURS = 12

Colour = tuple[int, int, int]

#: Vertices (n, 3) [m] and faces (m, 3).
_Part = tuple[NDArray[np.float64], NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles.

    Attributes:
        vertices: (n, 3) [m].
        faces: Indices of vertices, (m, 3).
        colour: Red, green and blue, 0 to 255.
    """

    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    colour: Colour


def colour_bytes(rgb: tuple[float, ...]) -> Colour:
    """Red, green and blue of 0 to 1 as bytes; more than these three are left out."""
    red, green, blue = (round(255 * value) for value in rgb[:3])
    return red, green, blue


def capsule(start: NDArray[np.float64], end: NDArray[np.float64], radius: float) -> _Part:
    """Vertices (n, 3) [m] and faces (m, 3) of a capsule; a sphere if it has no length.

    The numbers of both are the same for all capsules.
    """
    way = end - start
    length = float(np.linalg.norm(way))
    z = way / length if length > 0.0 else np.array([0.0, 0.0, 1.0])
    x = np.cross(z, [1.0, 0.0, 0.0] if abs(z[0]) < 0.9 else [0.0, 1.0, 0.0])
    x /= np.linalg.norm(x)
    slopes = np.linspace(-np.pi / 2.0, 0.0, _CAP)
    slopes = np.concatenate([slopes, -slopes[::-1]])
    centres = np.where(np.arange(2 * _CAP)[:, None] < _CAP, start, end)
    turns = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    ring = np.cos(turns)[:, None] * x + np.sin(turns)[:, None] * np.cross(z, x)
    rings = (
        centres[:, None]
        + radius * np.sin(slopes)[:, None, None] * z
        + radius * np.cos(slopes)[:, None, None] * ring
    )
    low = np.arange((2 * _CAP - 1) * _AROUND).reshape(-1, _AROUND)
    right = np.roll(low, -1, axis=1)
    faces = np.concatenate(
        [
            np.stack([low, right, right + _AROUND], axis=-1).reshape(-1, 3),
            np.stack([low, right + _AROUND, low + _AROUND], axis=-1).reshape(-1, 3),
        ]
    )
    return rings.reshape(-1, 3), faces


def person(posture: Posture) -> dict[str, Mesh]:
    """The person as it is simulated, ``skin`` and ``shirt``; the arm a little thinner, as in films.

    The numbers of vertices and faces are the same for all postures.
    """
    spec = mujoco.MjSpec()
    add_mannequin(spec, posture, 0.3, 1, 1)
    parts: dict[str, list[tuple[NDArray[np.float64], NDArray[np.int64]]]] = {
        "skin": [],
        "shirt": [],
    }
    for link in LINKS:
        inset = SKIN_INSET if link in ARM_LINKS else 0.0
        for geom in spec.body(link).geoms:
            is_capsule = geom.type == mujoco.mjtGeom.mjGEOM_CAPSULE
            ends = np.array(geom.fromto).reshape(2, 3) if is_capsule else np.stack([geom.pos] * 2)
            made = capsule(ends[0], ends[1], geom.size[0] - inset)
            parts["shirt" if link == "torso" else "skin"].append(made)
    return {
        "skin": _joined(parts["skin"], colour_bytes(SKIN)),
        "shirt": _joined(parts["shirt"], colour_bytes(SHIRT)),
    }


def likeness(posture: Posture) -> dict[str, Mesh]:
    """The person as films draw it, by part; that takes half a second."""
    return {
        part.name: Mesh(
            part.vertices.astype(np.float32),
            part.faces.astype(np.uint32),
            colour_bytes(part.colour),
        )
        for part in drawn_person(posture)
    }


def _joined(parts: list[tuple[NDArray[np.float64], NDArray[np.int64]]], colour: Colour) -> Mesh:
    firsts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    faces = [face + first for (_, face), first in zip(parts, firsts, strict=False)]
    vertices = np.concatenate([vertices for vertices, _ in parts])
    return Mesh(vertices.astype(np.float32), np.concatenate(faces).astype(np.uint32), colour)


class Robot:
    """The robot's skin, and where its links are.

    Attributes:
        skin: Meshes of each link, in the link's frame, by the link's name.
    """

    def __init__(self) -> None:
        self._model = compiled(robot_spec(PANDA, 0, 0))
        self._data = mujoco.MjData(self._model)
        self._joints = [self._model.joint(name).qposadr[0] for name in PANDA.joints]
        self.skin: dict[str, list[Mesh]] = {}
        for part in robot_skin(PANDA):
            vertices, faces = read_obj(part.obj)
            turned = Rotation.from_euler("xyz", part.rpy).apply(vertices) + part.xyz
            # White as white plastic is under a lamp; a browser would burn it out.
            red, green, blue = (round(0.86 * byte) for byte in bytes.fromhex(part.colour))
            mesh = Mesh(*coarser(turned, faces), (red, green, blue))
            if len(mesh.faces):
                self.skin.setdefault(part.link, []).append(mesh)

    def poses(self, q: NDArray[np.float64]) -> dict[str, tuple[NDArray[np.float64], ...]]:
        """Position (3,) [m] and quaternion (4,), w first, of each link with a skin.

        Args:
            q: Joint positions (7,) [rad].
        """
        self._data.qpos[self._joints] = q
        mujoco.mj_kinematics(self._model, self._data)
        bodies = {name: self._data.body(name) for name in self.skin}
        return {name: (body.xpos.copy(), body.xquat.copy()) for name, body in bodies.items()}


def read_obj(text: str) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices (n, 3) [m] and faces (m, 3) of an OBJ of triangles."""
    lines = text.split("\n")
    vertices = [line.split()[1:4] for line in lines if line.startswith("v ")]
    corners = [
        [corner.partition("/")[0] for corner in line.split()[1:4]]
        for line in lines
        if line.startswith("f ")
    ]
    return np.array(vertices, dtype=float), np.array(corners, dtype=np.int64) - 1


def coarser(
    vertices: NDArray[np.float64], faces: NDArray[np.int64]
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    """A mesh whose vertices are merged cell by cell of a grid of `_GRAIN` (vertex clustering)."""
    cells = np.round(vertices / _GRAIN).astype(np.int64)
    _, where = np.unique(cells, axis=0, return_inverse=True)
    where = where.ravel()
    counts = np.bincount(where)
    merged = np.stack([np.bincount(where, axis) / counts for axis in vertices.T], axis=1)
    kept = where[faces]
    kept = kept[(kept != np.roll(kept, 1, axis=1)).all(axis=1)]
    return merged.astype(np.float32), np.unique(kept, axis=0).astype(np.uint32)


class Cloth:
    """The sleeve as it is drawn: finer than it is simulated, in colours of its strain.

    Args:
        mesh: The sleeve at rest.
        top: Strain of the last colour.
    """

    def __init__(self, mesh: SleeveMesh, top: float) -> None:
        self._gauge, self._top = StrainGauge(mesh), top
        self._corners = mesh.triangles.ravel()
        self._areas = np.repeat(self._gauge.areas, 3)
        self._total = np.bincount(self._corners, self._areas)
        fine = subdivided(mesh.triangles, len(mesh.vertices), 1)
        self._smooth = csr_array(fine.smooth.astype(np.float32))
        self._through = fine.through.astype(np.float32)
        self._faces = fine.triangles.astype(np.uint32)

    def drawn(
        self, cloth: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], list[NDArray[np.uint32]]]:
        """Vertices (n, 3) [m], and the triangles (m, 3) of each of `N_COLOURS`, some of them none.

        Args:
            cloth: Vertices that are simulated, (n_vertices, 3) [m].
        """
        strain = np.repeat(self._gauge.principal(cloth.astype(float)), 3)
        mean = np.bincount(self._corners, self._areas * strain) / self._total
        share = (self._smooth @ mean.astype(np.float32))[self._faces].mean(axis=1) / self._top
        step = np.clip((share * N_COLOURS).astype(int), 0, N_COLOURS - 1)
        parts = [self._faces[step == colour] for colour in range(N_COLOURS)]
        return self._through @ cloth, parts

    def plain(self, cloth: NDArray[np.float32]) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
        """Vertices (n, 3) [m] and all triangles (m, 3)."""
        return self._through @ cloth, self._faces


def strain_colours() -> list[Colour]:
    """Colours of strain as in pictures, evenly spaced from no strain to the top."""
    at = np.linspace(0.0, len(COLOURS) - 1.0, N_COLOURS)
    mixed = [np.interp(at, range(len(COLOURS)), channel) for channel in np.transpose(COLOURS)]
    return [colour_bytes(tuple(rgb)) for rgb in np.transpose(mixed)]


def link_centres(posture: Posture) -> Mapping[str, NDArray[np.float64]]:
    """Where the force on each link of the arm is drawn from, (3,) [m]."""
    shoulder, elbow, wrist = posture.shoulder, posture.elbow, posture.wrist
    hand = wrist + 0.06 * (wrist - elbow) / np.linalg.norm(wrist - elbow)
    return {
        "hand": hand,
        "forearm": (wrist + elbow) / 2.0,
        "upper_arm": (elbow + shoulder) / 2.0,
    }
