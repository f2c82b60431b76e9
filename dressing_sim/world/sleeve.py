"""The garment in the world: its mesh at rest, and a 2-D flex of MuJoCo with one body a vertex.

Vertices are ordered ring by ring: ring 0 is the armscye (the wide end, which the gripper holds),
the last ring is the hem. Within a ring, vertex 0 is the topmost one at rest. The vertices of the
shirt's body, if it has one, come last.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.checks import real_vector
from dressing_sim.config import LATER, check_kinds
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.garment import Garment

FLEX = "sleeve"

#: MuJoCo's codes for what of a sheet is elastic.
_STRETCHING, _BOTH = 2, 3

#: Its way to find which of a sheet's triangles touch each other.
_TOUCHING = mujoco.mjtFlexSelf.mjFLEXSELF_AUTO

#: Density of air at 20 degrees Celsius [kg / m^3], and what a flat plate across the stream has for
#: a drag coefficient (Hoerner 1965, Fluid-Dynamic Drag, chapter 3).
_AIR, _PLATE = 1.204, 1.17

#: MuJoCo's least impedance of a contact.
_LEAST_IMPEDANCE = 0.0001

#: How a contact hardens across its layer: a sigmoid that is flat at both ends. With a power of 2
#: what holds the load is the layer's last tenth of a millimetre, which a step jumps over.
_MIDPOINT, _POWER = 0.5, 4.0

#: Longer edges leave cloth far inside of an elbow, and a contact that heals more slowly lets it
#: through [m], [s].
LONGEST_EDGE, LONGEST_CONTACT_TIME = 0.06, 0.05

#: A sleeve of more vertices around, or along, would take hours to simulate.
MOST_VERTICES = 400


@dataclass(frozen=True, slots=True)
class SleeveConfig:
    """A garment, how it is held, and how finely it is meshed."""

    garment: Garment = field(default_factory=Garment)
    edge: float = 0.028
    """Length of the mesh's edges [m]."""
    grip_width: float = 0.05
    """How much of the armscye's edge, to both sides of its top together, the fingers hold [m]."""
    grip_depth: float = 0.025
    """How far from the edge towards the hem the fingers hold the cloth [m]."""
    grasp_offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """From the armscye's top to the gripper's tool centre point, in the wrist's frame [m]; any
    sequence of three numbers, kept as a tuple."""
    grip_impedance: float = 0.9999
    """How hard the grip is, 0 to 1; with less the cloth stretches out of the fingers."""
    contact_time: float = 0.02
    """Time in which a penetration heals [s]; at least twice the physics step."""
    contact_depth: float = 0.004
    """Depth over which a contact hardens from nothing to `contact_impedance` [m]: fuzz of the
    fabric, air and skin that give way. It also keeps sliding contacts closed: MuJoCo's model of
    friction lifts what slides at a speed v by ``2 friction v contact_time``, and without a layer
    deeper than that the cloth leaves the contact and falls back through the skin's surface."""
    contact_impedance: float = 0.9999
    """How hard a contact is below its layer, 0 to 1."""
    bending: bool = False
    """Whether bending is simulated. Jersey bends under its weight over 22 mm, less than an edge of
    the mesh, and it costs half as much again."""
    self_contact: bool = field(default=False, metadata=LATER)
    """Whether the cloth touches itself."""
    robot_contact: bool = field(default=False, metadata=LATER)
    """Whether the cloth touches the robot's links, but for what holds it, the fingers."""
    air_drag: bool = field(default=False, metadata=LATER)
    """Whether still air resists the cloth, see `drag_of_air`."""

    def __post_init__(self) -> None:
        check_kinds(self, "sleeve")
        for name in ("edge", "grip_width", "grip_depth", "contact_time", "contact_depth"):
            value = getattr(self, name)
            if not (np.isfinite(value) and value > 0.0):
                raise InvalidInputError(f"sleeve: {name} is {value}, valid is > 0")
        for name in ("grip_impedance", "contact_impedance"):
            if not 0.0 < getattr(self, name) < 1.0:
                raise InvalidInputError(
                    f"sleeve: {name} is {getattr(self, name)}, valid is between 0 and 1"
                )
        for name, most in (
            ("grip_width", 0.5 * self.garment.armscye_circumference),
            ("grip_depth", self.garment.length),
        ):
            if not getattr(self, name) < most:
                raise InvalidInputError(
                    f"sleeve: {name} is {getattr(self, name)}, valid for this garment is < {most:g}"
                )
        offset = real_vector(self.grasp_offset, 3, "sleeve: grasp_offset has", "m")
        object.__setattr__(self, "grasp_offset", tuple(offset.tolist()))
        sizes = self.garment.armscye_circumference, self.garment.length / np.sqrt(0.75)
        if max(sizes) > MOST_VERTICES * self.edge:
            raise InvalidInputError(
                f"sleeve: edge is {self.edge}, valid is one that makes no more than "
                f"{MOST_VERTICES} vertices around and along"
            )
        if self.vertices_around < 6 or self.vertices_along < 3:
            raise InvalidInputError(
                f"a sleeve of {self.vertices_around} x {self.vertices_along} vertices is too "
                "coarse, valid is 6 or more around and 3 or more along: choose a shorter edge"
            )
        for name, most in (("edge", LONGEST_EDGE), ("contact_time", LONGEST_CONTACT_TIME)):
            if getattr(self, name) > most:
                raise InvalidInputError(
                    f"sleeve: {name} is {getattr(self, name)}, valid is up to {most:g}"
                )

    @property
    def vertices_around(self) -> int:
        """Vertices of a ring."""
        return round(self.garment.armscye_circumference / self.edge)

    @property
    def vertices_along(self) -> int:
        """Rings, armscye and hem included; the triangles are nearly equilateral."""
        return round(self.garment.length / (self.edge * np.sqrt(0.75))) + 1


@dataclass(frozen=True, slots=True)
class SleeveMesh:
    """A garment's mesh at rest.

    Attributes:
        vertices: Positions, shape (n_vertices, 3) [m].
        triangles: Vertex indices, shape (n_triangles, 3), counter-clockwise from outside.
        masses: Mass of each vertex, a third of its triangles', shape (n_vertices,) [kg]; in sum
            that of the sleeve and of the shirt's body as they are before meshing.
        gripped: Indices of the vertices that the gripper holds, the armscye's topmost one first.
        around: Vertices of a ring of the sleeve.
        along: Rings of the sleeve.
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    masses: NDArray[np.float64]
    gripped: NDArray[np.int32]
    around: int
    along: int

    @property
    def edges(self) -> NDArray[np.int32]:
        """Each edge once, shape (n_edges, 2)."""
        pairs = self.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
        return np.unique(np.sort(pairs, axis=1), axis=0)

    def rings(self, positions: NDArray[np.float64]) -> NDArray[np.float64]:
        """The sleeve's rings, (..., along, around, 3), of all positions (..., n_vertices, 3)."""
        sleeve = positions[..., : self.along * self.around, :]
        return sleeve.reshape(*positions.shape[:-2], self.along, self.around, 3)


def sleeve_mesh(
    config: SleeveConfig,
    armscye_centre: NDArray[np.float64],
    axis: NDArray[np.float64],
    up: NDArray[np.float64],
) -> SleeveMesh:
    """Mesh of a garment at rest.

    Each ring is turned by half a cell against the one before, so that triangles are nearly
    equilateral: a mesh of squares with diagonals locks in shear and, for as many vertices, pulls
    several times as hard where the cloth must turn round an elbow.

    Args:
        config: Size and mesh density.
        armscye_centre: Where the centre of the wide end is, (3,) [m].
        axis: Unit vector (3,) from the armscye to the hem.
        up: Unit vector (3,) across the axis, from the centre to the armscye's top.
    """
    garment, around, along = config.garment, config.vertices_around, config.vertices_along
    # Around, the grip's patch is divided evenly to both sides of vertex 0, which is topmost.
    patch = 2.0 * np.pi * config.grip_width / garment.armscye_circumference
    wide = 2 * max(1, round(patch / (4.0 * np.pi) * around))
    even = _graded(patch, wide, 2.0 * np.pi, around)
    even = np.roll(even[:-1] - 0.5 * patch, -(wide // 2))
    odd = even + 0.5 * (np.roll(even, -1) - even) % np.pi
    deep = min(max(1, round(config.grip_depth / garment.length * (along - 1))), along - 2)
    distance = _graded(config.grip_depth, deep, garment.length, along - 1)
    place = _Place(armscye_centre, axis, up, np.cross(axis, up))
    rows = []
    for ring, at in enumerate(distance):
        angles = odd if ring % 2 else even
        taper = garment.hem_circumference - garment.armscye_circumference
        circumference = garment.armscye_circumference + taper * at / garment.length
        rows.append(place.row(angles, _radius(circumference, angles), at))
    triangles = _ring_triangles(around, along)
    body, below = _shirt_body(config, place, even, odd)
    vertices = np.concatenate(rows + body)
    faces = np.array(triangles + below, dtype=np.int32)
    columns = np.arange(-(wide // 2), wide // 2 + 1)
    held = [ring * around + columns[: len(columns) - ring % 2] % around for ring in range(deep + 1)]
    gripped = np.sort(np.concatenate(held)).astype(np.int32)
    masses = _masses(garment, vertices, faces, len(triangles))
    return SleeveMesh(vertices, faces, masses, gripped, around, along)


@dataclass(frozen=True, slots=True)
class _Place:
    """Where a garment is: the armscye's centre, and unit vectors along it, up and to the side."""

    centre: NDArray[np.float64]
    axis: NDArray[np.float64]
    up: NDArray[np.float64]
    side: NDArray[np.float64]

    def row(self, angles: NDArray[np.float64], radius: float, at: float) -> NDArray[np.float64]:
        """Points (n, 3) round the axis, ``at`` [m] from the armscye towards the hem."""
        radial = np.cos(angles)[:, None] * self.up + np.sin(angles)[:, None] * self.side
        return self.centre + radius * radial + at * self.axis


def _radius(circumference: float, angles: NDArray[np.float64]) -> float:
    """Of the circle whose polygon at these angles is as long as the circumference says [m]."""
    steps = (np.roll(angles, -1) - angles) % (2.0 * np.pi)
    return circumference / float(np.sum(2.0 * np.sin(0.5 * steps)))


def _ring_triangles(around: int, along: int) -> list[tuple[int, int, int]]:
    triangles = []
    for ring in range(along - 1):
        for i in range(around):
            a, b = ring * around + i, ring * around + (i + 1) % around
            c, d = a + around, b + around
            triangles += [(a, b, d), (a, d, c)] if ring % 2 else [(a, b, c), (b, d, c)]
    return triangles


def _shirt_body(
    config: SleeveConfig,
    place: _Place,
    even: NDArray[np.float64],
    odd: NDArray[np.float64],
) -> tuple[list[NDArray[np.float64]], list[tuple[int, int, int]]]:
    """Rows of vertices and triangles of the shirt's body, beyond the armscye's lower half."""
    garment = config.garment
    below = np.flatnonzero(np.cos(even) < 1e-9)
    before = below.tolist()
    total = config.vertices_around * config.vertices_along
    body_rows = max(1, round(garment.body / (config.edge * np.sqrt(0.75))))
    rows, triangles = [], []
    for number in range(1, body_rows + 1 if garment.body else 1):
        angles = even[below] if number % 2 == 0 else odd[below[:-1]]
        at = -garment.body * number / body_rows
        now = list(range(total, total + len(angles)))
        total += len(angles)
        rows.append(place.row(angles, _radius(garment.armscye_circumference, even), at))
        wider, narrower = (before, now) if number % 2 else (now, before)
        strip = [*zip(wider[:-1], wider[1:], narrower, strict=True)]
        strip += zip(narrower[:-1], wider[1:-1], narrower[1:], strict=True)
        # Seen from outside, the wider row is on the other side of each second strip.
        triangles += [(b, a, c) for a, b, c in strip] if number % 2 else strip
        before = now
    return rows, triangles


def _masses(
    garment: Garment, vertices: NDArray[np.float64], faces: NDArray[np.int32], n_of_sleeve: int
) -> NDArray[np.float64]:
    """Mass of each vertex [kg]; the first `n_of_sleeve` faces are the sleeve's.

    The cloth weighs what the garment does: corners cut off by the mesh, at the edges of the
    shirt's body above all, have their weight with the triangles that are left.
    """
    corners = vertices[faces]
    areas = 0.5 * np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    of_sleeve, of_body = np.split(areas, [n_of_sleeve])  # views
    of_sleeve *= garment.sleeve_area / of_sleeve.sum()
    if garment.body:
        of_body *= garment.body_area / of_body.sum()
    shares = np.repeat(areas * garment.fabric.areal_density / 3.0, 3)
    return np.bincount(faces.ravel(), shares, minlength=len(vertices)).astype(np.float64)


def _graded(patch: float, inside: int, total: float, cells: int) -> NDArray[np.float64]:
    """Boundaries (cells + 1,) of cells on a length, the first `inside` of them on a patch.

    With a boundary exactly at the patch's end, the fingers hold the same piece of cloth whatever
    the mesh.
    """
    held = np.linspace(0.0, patch, inside + 1)
    return np.concatenate([held, np.linspace(patch, total, cells - inside + 1)[1:]])


def drag_of_air(mesh: SleeveMesh, garment: Garment) -> NDArray[np.float64]:
    """Drag of each vertex by its speed squared, (n_vertices,) [N s^2 / m^2].

    ``rho c A / 2``, as if the cloth moved broadside on wherever it moves: more than it is.
    """
    areas = mesh.masses / garment.fabric.areal_density
    drag: NDArray[np.float64] = 0.5 * _AIR * _PLATE * areas
    return drag


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
    fabric = config.garment.fabric
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
        radius=0.5 * fabric.thickness,
        vertbody=[vertex_body(i) for i in range(len(mesh.vertices))],
        elem=mesh.triangles.ravel().tolist(),
        young=fabric.young,
        poisson=fabric.poisson,
        damping=fabric.damping,
        thickness=fabric.elastic_thickness,
        elastic2d=_BOTH if config.bending else _STRETCHING,
        contype=contype,
        conaffinity=conaffinity,
        condim=3,
        priority=1,  # else contacts take the mean of these settings and the mannequin's defaults
        friction=[fabric.friction, 0.005, 0.0001],
        solref=[config.contact_time, 1.0],
        solimp=[
            _LEAST_IMPEDANCE,
            config.contact_impedance,
            config.contact_depth,
            _MIDPOINT,
            _POWER,
        ],
        margin=config.contact_depth,
        selfcollide=_TOUCHING if config.self_contact else mujoco.mjtFlexSelf.mjFLEXSELF_NONE,
        rgba=[0.20, 0.42, 0.75, 1.0],
    )
