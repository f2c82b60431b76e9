"""Strips of a garment's fabric in a world of their own, and how soft friction creeps.

Integrator, solver, step and tolerance are those of an episode (`SolverConfig`), and so are the
fabric (`Fabric`) and the contacts' settings (`SleeveConfig`). Strips are meshed as a sleeve is, in
staggered rows of equilateral triangles, unless a test says otherwise. "The manual" is that of
MuJoCo 4.0.
"""

from dataclasses import replace

import mujoco
import numpy as np
from scipy.optimize import brentq

from dressing_sim.world.garment import Fabric, Garment
from dressing_sim.world.scene import SolverConfig
from dressing_sim.world.sleeve import SleeveConfig, SleeveMesh, add_sleeve, vertex_body

GRAVITY = 9.81
FABRIC, SLEEVE, SOLVER = Fabric(), SleeveConfig(), SolverConfig()
X, Y, Z = np.eye(3)
#: Height of an equilateral triangle of side 1.
HEIGHT = np.sqrt(0.75)


def strip_mesh(fabric, along, across, cells, staggered=True, height=0.0):
    """A flat rectangle, its vertices row by row.

    Args:
        fabric: Whose areal density the masses have.
        along: Vector (3,) from the first row to the last [m].
        across: Vector (3,) of the rows [m].
        cells: Numbers of cells along and across.
        staggered: As in a sleeve: each other row is moved by half a cell, and begins and ends with
            half a cell. If not, squares, with diagonals that alternate by column.
        height: How much the strip is raised along z [m].
    """
    rows, columns = cells
    whole = np.linspace(-0.5, 0.5, columns + 1)
    halves = np.concatenate([[-0.5], whole[:-1] + 0.5 / columns, [0.5]])
    lines = [halves if staggered and row % 2 else whole for row in range(rows + 1)]
    first = np.cumsum([0, *map(len, lines)]).tolist()
    triangles = []
    for row in range(rows):
        a, b = first[row], first[row + 1]
        if staggered:
            # From the whole cells' row to the halves', then turned where that is downwards.
            a, b = (b, a) if row % 2 else (a, b)
            some = [(a + i, a + i + 1, b + i + 1) for i in range(columns)]
            some += [(b + i, a + i, b + i + 1) for i in range(columns + 1)]
            triangles += [corners[::-1] for corners in some] if row % 2 else some
        else:
            for i in range(columns):
                c, d, e, f = a + i, a + i + 1, b + i, b + i + 1
                triangles += [(c, d, f), (c, f, e)] if i % 2 else [(c, d, e), (d, f, e)]
    s = np.repeat(np.linspace(0.0, 1.0, rows + 1), [len(line) for line in lines])
    vertices = np.outer(s, along) + np.outer(np.concatenate(lines), across) + height * Z
    faces = np.array(triangles, dtype=np.int32)
    a, b, c = vertices[faces].transpose(1, 0, 2)
    areas = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    masses = np.bincount(faces.ravel(), np.repeat(fabric.areal_density * areas / 3.0, 3))
    return SleeveMesh(vertices, faces, masses, np.zeros(0, dtype=np.int32), 0, 0)


def beam_mesh(fabric, cells, edge, kind):
    """A strip along x, from x = 0, cells of a length `edge` along and across it.

    Args:
        fabric: As of `strip_mesh`.
        cells: Numbers of cells along x and y.
        edge: Of the triangles or squares [m].
        kind: ``"squares"``, or the direction of a sleeve in which it is cut: ``"axial"``, rows of
            triangles across the strip, or ``"circumferential"``, rows along it.

    Returns:
        The mesh, and the length of a cell along x.
    """
    long, wide = cells
    if kind == "circumferential":
        mesh = strip_mesh(fabric, wide * edge * HEIGHT * Y, long * edge * X, (wide, long))
        return replace(mesh, vertices=mesh.vertices + 0.5 * long * edge * X), edge
    step = edge * HEIGHT if kind == "axial" else edge
    return strip_mesh(fabric, long * step * X, wide * edge * Y, cells, kind == "axial"), step


def shares(places):
    """Length of an edge that belongs to each of its vertices, at the places (n,) along it."""
    order = np.argsort(places)
    between = 0.5 * (places[order][1:] + places[order][:-1])
    lengths = np.empty(len(places))
    lengths[order] = np.diff([places.min(), *between, places.max()])
    return lengths


class Strip:
    """A strip of cloth, simulated with an episode's SOLVER.

    Args:
        fabric: Fabric.
        mesh: Mesh at rest.
        fixed: For each vertex that is not free, the axes along which it is fixed.
        incline: Put a plane below, z = 0, and tilt gravity by this angle towards +x [rad].
        weightless: No gravity.
        elasticity: Which forces the cloth has: 0 none, 1 bending, 2 stretching, 3 both.
        iterations: Of the solver, if not an episode's.
        timestep: If not an episode's [s].
    """

    def __init__(
        self,
        fabric,
        mesh,
        fixed=None,
        incline=None,
        weightless=False,
        elasticity=3,
        iterations=SOLVER.iterations,
        timestep=SOLVER.timestep,
    ):
        spec = mujoco.MjSpec()
        option = spec.option
        option.timestep = timestep
        option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
        option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{SOLVER.solver.upper()}")
        option.iterations = iterations
        option.tolerance = SOLVER.tolerance
        option.impratio = SOLVER.impratio
        option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        if incline is None:
            down = -Z
        else:
            down = np.sin(incline) * X - np.cos(incline) * Z
            self._add_support(spec, fabric.friction)
        option.gravity = np.zeros(3) if weightless else GRAVITY * down
        config = replace(SLEEVE, garment=Garment(fabric=fabric))
        add_sleeve(spec, config, mesh, contype=4, conaffinity=1)
        spec.flexes[0].elastic2d = elasticity
        for vertex, axes in (fixed or {}).items():
            for axis in axes:
                spec.delete(spec.joint(f"{vertex_body(vertex)}_{axis}"))
        self.fabric, self.mesh = fabric, mesh
        self.model = spec.compile()
        self.data = mujoco.MjData(self.model)
        mujoco.mj_forward(self.model, self.data)

    @staticmethod
    def _add_support(spec, friction):
        """A plane with the contact settings of the mannequin's links, and a sensor of its load."""
        body = spec.worldbody.add_body(name="support")
        body.add_geom(
            type=mujoco.mjtGeom.mjGEOM_PLANE,
            size=[5.0, 5.0, 1.0],
            friction=[friction, 0.005, 0.0001],
            contype=1,
            conaffinity=4,
            condim=3,
        )
        found = mujoco.mjtConDataField.mjCONDATA_FOUND
        force = mujoco.mjtConDataField.mjCONDATA_FORCE
        spec.add_sensor(
            name="support_force",
            type=mujoco.mjtSensor.mjSENS_CONTACT,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            objname="support",
            intprm=[(1 << found.value) | (1 << force.value), 3, 1],
        )

    def run(self, seconds):
        """Simulate, and yield after every step."""
        for _ in range(round(seconds / self.model.opt.timestep)):
            mujoco.mj_step(self.model, self.data)
            yield self.data.time
        assert not any(warning.number for warning in self.data.warning)
        assert np.isfinite(self.data.qpos).all()

    def settle(self, seconds):
        for _ in self.run(seconds):
            pass

    def pull(self, vertices, forces):
        """Apply constant forces (n, 3) to vertices (n,), besides those already applied."""
        for vertex, force in zip(vertices, forces, strict=True):
            self.data.xfrc_applied[self.model.body(vertex_body(vertex)).id, :3] += force

    @property
    def vertices(self):
        return self.data.flexvert_xpos.copy()

    @property
    def centre(self):
        """Centre of mass (3,)."""
        return self.mesh.masses @ self.vertices / self.weight * GRAVITY

    @property
    def weight(self):
        return self.mesh.masses.sum() * GRAVITY

    @property
    def support_force(self):
        """Net contact force (3,) on the plane."""
        return -self.data.sensor("support_force").data[1:4]


def creep(load, pressed):
    """How fast friction creeps that carries a load, pressed on, in m/s; both a mass [m/s^2].

    MuJoCo's friction is a damper. A contact of impedance d pushes back with R f = b v per mass of
    its vertex, b = 2 / (D T), R = (1 - d) / d, impratio times less for friction, where D is the
    impedance below the layer and T the contact's time (the manual's chapter on computation). How
    far d has grown follows from what is pressed on: R f = d k r in the depth r, k = 1 / (D T)^2.
    The discrete integrator evaluates damper and spring at the end of the step, which divides the
    damper by 1 + h b, and R, the normal direction's, by 1 + h b + h^2 d k.
    """
    most, time, h = SLEEVE.contact_impedance, SLEEVE.contact_time, SOLVER.timestep
    b, k = 2.0 / (most * time), 1.0 / (most * time) ** 2

    def pressing(depth):
        return k * depth * impedance(depth) ** 2 / (1.0 - impedance(depth))

    d = impedance(brentq(lambda r: pressing(r) - pressed, 1e-9, SLEEVE.contact_depth))
    soft = (1.0 - d) / d / SOLVER.impratio
    return soft * load / b * (1.0 + h * b) / (1.0 + h * b + h**2 * d * k)


def impedance(depth):
    """How hard a contact is, this deep in its layer [m]: the manual's sigmoid, its power 4."""
    half = 0.5 * (2.0 * min(depth, SLEEVE.contact_depth - depth) / SLEEVE.contact_depth) ** 4
    share = half if depth < 0.5 * SLEEVE.contact_depth else 1.0 - half
    return 1e-4 + share * (SLEEVE.contact_impedance - 1e-4)
