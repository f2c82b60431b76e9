"""The scene: robot, mannequin and sleeve in one MuJoCo model, ready to be simulated."""

from __future__ import annotations

from dataclasses import dataclass, field
from types import MappingProxyType

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.checks import one_of
from dressing_sim.config import check_kinds
from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.world.mannequin import add_mannequin
from dressing_sim.world.robot import Robot
from dressing_sim.world.robot_spec import robot_spec
from dressing_sim.world.sleeve import SleeveConfig, SleeveMesh, add_sleeve, sleeve_mesh, vertex_body

# Contact bits. Cloth and robot both touch the mannequin; nothing else touches anything, unless the
# cloth is to touch the robot as well: the fingers hold it by the grip, and that the robot's links
# stay apart is not checked.
_MANNEQUIN, _ROBOT, _CLOTH, _FINGERS = 1, 2, 4, 8


@dataclass(frozen=True, slots=True)
class SolverConfig:
    """How MuJoCo integrates; what is chosen here can change a verdict."""

    timestep: float = 0.01
    """Physics step [s]."""
    solver: str = "Newton"
    """``"CG"`` or ``"Newton"``."""
    iterations: int = 200
    """Most iterations a step, of the solver and of the cloth's linear system; Newton needs about 5,
    CG more than 150."""
    tolerance: float = 1e-9
    """Solver's stopping tolerance. MuJoCo scales it by the mean inertia, most of which is the
    robot's, a hundred times a vertex's mass: at 1e-8 the cloth's strain and pull are still off."""
    impratio: float = 100.0
    """How much harder friction is than contact; at 10 a sleeve creeps down a steep arm by 1 mm a
    second, at 100 by 0.05 mm."""

    def __post_init__(self) -> None:
        check_kinds(self, "solver")
        one_of(self.solver, "solver", ("CG", "Newton"))
        if not (isinstance(self.iterations, int) and self.iterations >= 1):
            raise InvalidInputError(f"solver: iterations is {self.iterations}, valid is 1 or more")
        for name, most in (("timestep", 0.05), ("tolerance", 1e-5), ("impratio", np.inf)):
            value = getattr(self, name)
            if not 0.0 < value <= most or value == np.inf:
                upto = f" up to {most:g}" if most < np.inf else ""
                raise InvalidInputError(f"solver: {name} is {value}, valid is above zero{upto}")


@dataclass(frozen=True, slots=True)
class WorldConfig:
    """Everything about the world but the posture."""

    sleeve: SleeveConfig = field(default_factory=SleeveConfig)
    robot: Robot = field(default_factory=Robot)
    solver: SolverConfig = field(default_factory=SolverConfig)
    settle_time: float = 1.0
    """How long the cloth falls before an episode starts [s]."""

    #: Settings of older files that are within another one now, see `from_plain`.
    MOVED = MappingProxyType({"servo": "robot"})

    #: What files have beside the robot: they had it before it was the robot's, see `to_plain`.
    KEPT = MappingProxyType({"grip_strength": "robot"})

    def __post_init__(self) -> None:
        check_kinds(self, "world")
        if not 0.0 <= self.settle_time < np.inf:
            raise InvalidInputError(f"world: settle_time is {self.settle_time} s, valid is >= 0")
        step, heals = self.solver.timestep, self.sleeve.contact_time
        if heals < 2.0 * step:
            raise InvalidInputError(
                f"sleeve: contact_time is {heals} s, valid is at least twice the solver's "
                f"timestep, {2.0 * step:g} s"
            )


def grip_start(posture: Posture, sleeve: SleeveConfig) -> NDArray[np.float64]:
    """Where the gripper holds the armscye at the start, (3,) in the robot's base frame [m].

    The armscye's centre is at the wrist, so its top is one radius up along the wrist frame's z.
    """
    axes = posture.frames()[1].A
    radius = sleeve.garment.armscye_circumference / (2.0 * np.pi)
    return posture.wrist + radius * axes[:, 2] + axes @ np.array(sleeve.grasp_offset)


def resting_sleeve(posture: Posture, sleeve: SleeveConfig) -> SleeveMesh:
    """The sleeve before it falls: around the forearm's axis, armscye at the wrist, hem outwards."""
    wrist_frame = posture.frames()[1]
    return sleeve_mesh(sleeve, posture.wrist, -wrist_frame.A[:, 0], wrist_frame.A[:, 2])


def build_spec(posture: Posture, config: WorldConfig) -> tuple[mujoco.MjSpec, SleeveMesh]:
    """Assemble the scene as an editable spec.

    Returns:
        The spec, and the sleeve's mesh at rest. The grip's constraints are in the spec, but their
        anchors on the hand are not: they depend on where the hand is (see `World`).
    """
    spec = robot_spec(config.robot, contype=_ROBOT, conaffinity=_MANNEQUIN)
    fingers = [spec.joint(name).parent for name in config.robot.fingers]
    for body in (*fingers, spec.body(config.robot.tool)):
        for geom in body.geoms:
            geom.contype = _FINGERS
    spec.modelname = f"dressing {posture.name}"
    option = spec.option
    option.timestep = config.solver.timestep
    option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    option.solver = getattr(mujoco.mjtSolver, f"mjSOL_{config.solver.solver.upper()}")
    option.iterations = config.solver.iterations
    option.tolerance = config.solver.tolerance
    option.impratio = config.solver.impratio
    option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC

    friction = config.sleeve.garment.fabric.friction
    add_mannequin(spec, posture, friction, _MANNEQUIN, _ROBOT | _FINGERS | _CLOTH)
    mesh = resting_sleeve(posture, config.sleeve)
    more = (config.sleeve.robot_contact, _ROBOT), (config.sleeve.self_contact, _CLOTH)
    touched = _MANNEQUIN | sum(bit for touches, bit in more if touches)
    add_sleeve(spec, config.sleeve, mesh, _CLOTH, touched)
    for vertex in mesh.gripped:
        spec.add_equality(
            name=grip_name(vertex),
            type=mujoco.mjtEq.mjEQ_CONNECT,
            objtype=mujoco.mjtObj.mjOBJ_BODY,
            name1=config.robot.tool,
            name2=vertex_body(vertex),
            solref=[config.sleeve.contact_time, 1.0],
            solimp=[config.sleeve.grip_impedance, config.sleeve.grip_impedance, 0.001, 0.5, 2.0],
        )
    return spec, mesh


def compiled(spec: mujoco.MjSpec) -> mujoco.MjModel:
    """The model of a spec.

    Raises:
        InvalidInputError: MuJoCo refuses it.
    """
    try:
        return spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise InvalidInputError(f"world: MuJoCo refuses it ({one_line(str(error))})") from error


def grip_name(vertex: int) -> str:
    """Name of the constraint by which the fingers hold a vertex."""
    return f"grip_{vertex}"
