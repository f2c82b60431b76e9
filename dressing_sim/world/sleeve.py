"""The sleeve: a conical tube of cloth, as a 2-D flex of MuJoCo with one body a vertex.

Vertices are ordered ring by ring: ring 0 is the armscye (the wide end, which the gripper holds),
the last ring is the hem. Within a ring, vertex 0 is the topmost one at rest.
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.errors import InvalidInputError

FLEX = "sleeve"


@dataclass(frozen=True, slots=True)
class SleeveConfig:
    """Size, fabric and mesh of a sleeve, in SI units."""

    length: float = 0.20
    """From armscye to hem along the cone's axis [m]; T-shirt size M: 0.191 to 0.216."""
    armscye_circumference: float = 0.48
    """Armhole all round [m]; T-shirt size M: 0.440 to 0.480."""
    hem_circumference: float = 0.368
    """Sleeve opening all round [m]; T-shirt size M: 0.356 to 0.368."""
    areal_density: float = 0.18
    """Mass of the fabric an area [kg/m^2]; jersey: 0.150 to 0.207."""
    membrane_stiffness: float = 180.0
    """Young's modulus times thickness [N/m]; jersey: 17 to 410."""
    bending_stiffness: float = 2e-5
    """Plate rigidity [N m]."""
    poisson: float = 0.3
    """Poisson's ratio of the fabric."""
    damping: float = 0.01
    """Rayleigh damping: ratio of viscous to elastic stress an inverse second [s]."""
    friction: float = 0.3
    """Sliding friction coefficient between fabric and skin; measured on forearms: 0.31 +- 0.07."""
    collision_radius: float = 0.002
    """Half the thickness that contacts see [m]; thicker than fabric, for the contact solver."""
    contact_time: float = 0.015
    """Time in which a penetration heals [s]; at least twice the physics step."""
    contact_impedance: float = 0.975
    """How hard a contact is, 0 to 1. Forces scale with the vertices' tiny masses: with MuJoCo's
    default of 0.95 an elbow pokes through the cloth at a few newtons."""
    grip_impedance: float = 0.9999
    """How hard the grip is, 0 to 1; with less the cloth stretches out of the fingers."""
    vertices_around: int = 18
    """Vertices of a ring."""
    vertices_along: int = 8
    """Rings, armscye and hem included."""
    grip_radius: float = 0.03
    """Cloth within this distance of the armscye's top is between the fingers [m]."""

    def __post_init__(self) -> None:
        if self.vertices_around < 6 or self.vertices_along < 2:
            raise InvalidInputError(
                f"a sleeve of {self.vertices_around} x {self.vertices_along} vertices is too "
                "coarse, valid is 6 or more around and 2 or more along"
            )
        for name in (
            "length",
            "armscye_circumference",
            "hem_circumference",
            "areal_density",
            "membrane_stiffness",
            "bending_stiffness",
            "collision_radius",
            "grip_radius",
        ):
            if not getattr(self, name) > 0.0:
                raise InvalidInputError(f"sleeve: {name} is {getattr(self, name)}, valid is > 0")
        for name in ("friction", "damping"):
            if not getattr(self, name) >= 0.0:
                raise InvalidInputError(f"sleeve: {name} is {getattr(self, name)}, valid is >= 0")
        if not 0.0 <= self.poisson < 0.5:
            raise InvalidInputError(f"sleeve: poisson is {self.poisson}, valid is 0 to below 0.5")

    @property
    def elastic_thickness(self) -> float:
        """Thickness [m] of the solid sheet that has both measured stiffnesses.

        A fabric bends more easily than a solid sheet of its thickness. MuJoCo derives both
        stiffnesses from one sheet, membrane ``E t`` and bending ``E t^3 / 12 (1 - nu^2)``, so t
        follows from their ratio.
        """
        ratio = self.bending_stiffness / self.membrane_stiffness
        return float(np.sqrt(12.0 * (1.0 - self.poisson**2) * ratio))

    @property
    def young(self) -> float:
        """Young's modulus [Pa] of the sheet of `elastic_thickness`."""
        return self.membrane_stiffness / self.elastic_thickness


@dataclass(frozen=True, slots=True)
class SleeveMesh:
    """A sleeve's mesh at rest.

    Attributes:
        vertices: Positions, shape (n_rings * n_around, 3) [m].
        triangles: Vertex indices, shape (n_triangles, 3), counter-clockwise from outside.
        masses: Mass of each vertex, a third of its triangles', shape (n_vertices,) [kg].
        gripped: Indices of the vertices that the gripper holds, the armscye's topmost one first.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    masses: NDArray[np.float64]
    gripped: NDArray[np.int32]

    @property
    def edges(self) -> NDArray[np.int32]:
        """Each edge once, shape (n_edges, 2)."""
        pairs = self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        return np.unique(np.sort(pairs, axis=1), axis=0)


def sleeve_mesh(
    config: SleeveConfig,
    armscye_centre: NDArray[np.float64],
    axis: NDArray[np.float64],
    up: NDArray[np.float64],
) -> SleeveMesh:
    """Mesh of a sleeve at rest.

    Args:
        config: Size and mesh density.
        armscye_centre: Where the centre of the wide end is, (3,) [m].
        axis: Unit vector (3,) from the armscye to the hem.
        up: Unit vector (3,) across the axis, from the centre to the armscye's top.
    """
    around, along = config.vertices_around, config.vertices_along
    fraction = np.repeat(np.linspace(0.0, 1.0, along), around)
    angle = np.tile(np.arange(around) * 2.0 * np.pi / around, along)
    circumference = (1 - fraction) * config.armscye_circumference + (
        fraction * config.hem_circumference
    )
    radius = (circumference / (2.0 * np.pi))[:, None]
    side = np.cross(axis, up)
    radial = np.cos(angle)[:, None] * up + np.sin(angle)[:, None] * side
    vertices = armscye_centre + radius * radial + fraction[:, None] * config.length * axis

    triangles = []
    for ring in range(along - 1):
        for i in range(around):
            a, b = ring * around + i, ring * around + (i + 1) % around
            c, d = a + around, b + around
            # Alternate the diagonals so that the mesh has no preferred direction of twist.
            triangles += [(a, b, d), (a, d, c)] if (ring + i) % 2 else [(a, b, c), (b, d, c)]
    faces = np.array(triangles, dtype=np.int32)

    corners = vertices[faces]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    shares = np.repeat(areas * config.areal_density / 3.0, 3)
    masses = np.bincount(faces.ravel(), shares, minlength=len(vertices)).astype(np.float64)
    distance = np.linalg.norm(vertices - vertices[0], axis=1)
    gripped = np.flatnonzero(distance <= config.grip_radius).astype(np.int32)
    return SleeveMesh(vertices, faces, masses, gripped)


def vertex_body(index: int) -> str:
    """Name of the body that carries a vertex."""
    return f"{FLEX}_{index}"


def add_sleeve(
    spec: mujoco.MjSpec,
    config: SleeveConfig,
    mesh: SleeveMesh,
    contype: int,
    conaffinity: int,
) -> None:
    """Add the cloth to the world at its rest shape, one body with three slides a vertex."""
    axes = np.eye(3)
    for index, (position, mass) in enumerate(zip(mesh.vertices, mesh.masses, strict=True)):
        # A point mass: MuJoCo wants some rotational inertia, which no joint ever feels.
        body = spec.worldbody.add_body(
            name=vertex_body(index),
            pos=position,
            mass=mass,
            inertia=np.full(3, 1e-6 * mass),
            explicitinertial=True,
        )
        for axis, letter in zip(axes, "xyz", strict=True):
            body.add_joint(
                name=f"{vertex_body(index)}_{letter}", type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis
            )
    spec.add_flex(
        name=FLEX,
        dim=2,
        radius=config.collision_radius,
        vertbody=[vertex_body(i) for i in range(len(mesh.vertices))],
        elem=mesh.triangles.ravel().tolist(),
        young=config.young,
        poisson=config.poisson,
        damping=config.damping,
        thickness=config.elastic_thickness,
        elastic2d=3,  # both stretching and bending
        contype=contype,
        conaffinity=conaffinity,
        condim=3,
        priority=1,  # else contacts take the mean of these settings and the mannequin's defaults
        friction=[config.friction, 0.005, 0.0001],
        solref=[config.contact_time, 1.0],
        solimp=[config.contact_impedance, config.contact_impedance, 0.001, 0.5, 2.0],
        selfcollide=mujoco.mjtFlexSelf.mjFLEXSELF_NONE,
        rgba=[0.20, 0.42, 0.75, 1.0],
    )
