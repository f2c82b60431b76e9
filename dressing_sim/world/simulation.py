"""The running world: stepping, and what an instrumented laboratory would measure in it."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.contacts import ClothForces, ContactReader, Touch
from dressing_sim.world.description import joint_limits
from dressing_sim.world.kernels import fastest, is_sound, servo_torques
from dressing_sim.world.mannequin import ARM_LINKS, LINKS
from dressing_sim.world.person import Person
from dressing_sim.world.scene import WorldConfig, build_spec, compiled, grip_name
from dressing_sim.world.sleeve import FLEX, SleeveMesh, drag_of_air, vertex_body

#: Cutoff of the low pass in the force sensors of gripper and arm [Hz]: own choice, of the order of
#: the filters that force-torque sensors at a robot's wrist are read with. Chatter between two
#: physics steps goes, a sleeve that catches (in tenths of a second) stays.
FORCE_CUTOFF = 10.0

#: Cloth this deep in the mannequin has gone through its skin [m]: half of the thinnest limb. All
#: that dress with the garments of `dressing_sim.world.garment.GARMENTS` stay above it.
TOO_DEEP = 0.02

#: Cloth that the fingers hold and that is this fast has got its energy from the solver [m/s]; the
#: gripper moves at a quarter of a metre a second.
TOO_FAST = 10.0

#: For how long in all a simulation may do what it must not before it is not trusted [s].
DOUBTFUL_TIME = 0.1

#: What it must not do, in the order of `World.doubts`.
DOUBTS = (
    f"the cloth was more than {1e3 * TOO_DEEP:g} mm deep in the mannequin",
    "the solver stopped at its limit of iterations",
    f"the cloth was faster than {TOO_FAST:g} m/s",
)

#: What MuJoCo's next step depends on, the solver's warm start included.
_STATE = int(mujoco.mjtState.mjSTATE_INTEGRATION)


class World:
    """Robot, mannequin and sleeve, simulated.

    All positions are in the robot's base frame [m], forces in newtons.

    Args:
        posture: The mannequin's posture.
        config: Cloth, robot, solver.
        arm_configuration: Joint positions (n,) to start from [rad]; the hand's pose there decides
            where the grip holds the sleeve, so the gripper should be at `grip_start`.

    Attributes:
        posture: As given.
        config: As given.
        mesh: The sleeve at rest.
        model: MuJoCo's model.
        data: MuJoCo's state.
        robot_links: Names of the robot's links that can touch the mannequin.
        holding: Whether the fingers still hold the cloth.
        doubts: For how long the simulation did each of `DOUBTS`, in all [s].
    """

    def __init__(
        self, posture: Posture, config: WorldConfig, arm_configuration: NDArray[np.float64]
    ) -> None:
        spec, mesh = build_spec(posture, config)
        self.posture = posture
        self.config = config
        self.mesh: SleeveMesh = mesh
        self.model = compiled(spec)
        self.data = mujoco.MjData(self.model)
        model = self.model
        robot = config.robot
        self._tcp = model.body(robot.tool).id
        # The joints of a chain follow one another, and so do their servos.
        self._arm_qpos = _following(model.joint(robot.joints[0]).qposadr[0], robot.n_joints)
        self._arm_dof = _following(model.joint(robot.joints[0]).dofadr[0], robot.n_joints)
        self._arm_actuator = _following(model.actuator(robot.joints[0]).id, robot.n_joints)
        self._grip = np.array([model.equality(grip_name(v)).id for v in mesh.gripped])
        self._stiffness = np.array(robot.servo.stiffness)
        self._damping = np.array(robot.servo.damping)
        self._lag = self._damping / self._stiffness
        self._effort = joint_limits(robot).effort
        flex = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, FLEX)
        first = model.flex_vertadr[flex]
        # A vertex slides along the world's axes, and vertices follow one another.
        dof = model.joint(f"{vertex_body(0)}_x").dofadr[0]
        self._cloth_dofs = slice(dof, dof + 3 * len(mesh.vertices))
        self._vertices = slice(first, first + len(mesh.vertices))
        self._drag = drag_of_air(mesh, config.sleeve.garment) if config.sleeve.air_drag else None
        self._contacts = ContactReader(model)
        self.robot_links = self._contacts.robot_links
        self._arm_geoms = np.array(
            [g for g in range(model.ngeom) if model.body(model.geom_bodyid[g]).name in ARM_LINKS]
        )
        # The exact step of a first-order low pass, x' = 2 pi f (u - x), with u held for the step.
        self._load_share = 1.0 - np.exp(-2.0 * np.pi * FORCE_CUTOFF * model.opt.timestep)
        self._load = np.zeros(3)
        self._cloth_load = ClothForces(np.zeros((len(LINKS), 3)), np.zeros(len(LINKS)))
        self.holding = True
        self._last_sound = 0.0
        self.doubts = np.zeros(len(DOUBTS))
        self._still = np.stack([posture.wrist, posture.elbow, posture.shoulder])
        self._person = None if posture.motion is None else Person(model, posture)
        self._moves_since: float | None = None
        self._place(np.asarray(arm_configuration, dtype=float))

    def _place(self, q: NDArray[np.float64]) -> None:
        self.data.qpos[self._arm_qpos] = q
        self.command(q, np.zeros_like(q))
        mujoco.mj_kinematics(self.model, self.data)
        rotation = self.data.xmat[self._tcp].reshape(3, 3)
        for equality, vertex in zip(self._grip, self.mesh.gripped, strict=True):
            offset = self.mesh.vertices[vertex] - self.data.xpos[self._tcp]
            self.model.eq_data[equality, 0:3] = rotation.T @ offset
            self.model.eq_data[equality, 3:6] = 0.0
        mujoco.mj_forward(self.model, self.data)
        # Equality constraints come first among the solver's rows, in their own order; those of
        # the grip are there in every step until the cloth is released.
        rows = np.flatnonzero(np.isin(self.data.efc_id[: self.data.ne], self._grip))
        self._grip_rows = slice(int(rows[0]), int(rows[-1]) + 1)

    def copy(self) -> World:
        """Another world in the same state, which goes on by itself with the same bits."""
        other = copy(self)
        other.model, other.data = copy(self.model), copy(self.data)
        return other

    def state(self) -> dict[str, NDArray[np.float64]]:
        """All that the simulation goes on from, for `restore`."""
        size = mujoco.mj_stateSize(self.model, _STATE)
        physics = np.empty(size)
        mujoco.mj_getState(self.model, self.data, physics, _STATE)
        return {
            "physics": physics,
            "warnings": self.data.warning.number.astype(float),
            "tcp": self.data.xpos.copy(),
            "cloth": self.data.flexvert_xpos.copy(),
            "load": self._load,
            "net": self._cloth_load.net,
            "normal": self._cloth_load.normal,
            "depth": np.array(self._cloth_load.depth),
            "doubts": self.doubts,
            "flags": np.array([self._last_sound, float(self.holding)]),
        }

    def restore(self, state: Mapping[str, NDArray[np.float64]]) -> None:
        """Go on from a `state` of a world that was made with the same arguments.

        What is read off places is as it was; contacts and torques are there again after a step.
        """
        mujoco.mj_setState(self.model, self.data, state["physics"].copy(), _STATE)
        self.data.warning.number[:] = state["warnings"]
        self.data.xpos[:] = state["tcp"]
        self.data.flexvert_xpos[:] = state["cloth"]
        self._load = state["load"].copy()
        self._cloth_load = ClothForces(
            state["net"].copy(), state["normal"].copy(), float(state["depth"])
        )
        self.doubts = state["doubts"].copy()
        self._last_sound = float(state["flags"][0])
        self.holding = bool(state["flags"][1])

    def begin_motion(self) -> None:
        """From now on the person moves, if at all; until then it waits in its posture."""
        self._moves_since = self.time

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return float(self.data.time)

    def command(self, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> None:
        """Set the arm servos' reference.

        Args:
            positions: Joint positions (n,) [rad].
            velocities: Joint velocities (n,) [rad/s]; fed forward, so that the servos' damping
                does not make the arm lag behind a moving reference.
        """
        self.data.ctrl[self._arm_actuator] = positions + self._lag * velocities

    def step(self) -> None:
        """Advance the simulation by one time step.

        The fingers lose the cloth if it pulls harder than they can hold it.
        """
        if self.invalid_reason is None:
            self._last_sound = self.time
        if self._person is not None:
            since = self._moves_since
            self._person.lead(self.data, None if since is None else self.time - since)
        if self._drag is not None:
            moves = self.data.qvel[self._cloth_dofs].reshape(-1, 3)
            resists = self._drag * np.linalg.norm(moves, axis=1)
            self.data.qfrc_applied[self._cloth_dofs] = -(resists[:, None] * moves).ravel()
        mujoco.mj_step(self.model, self.data)
        rows = self._grip_rows
        grip = rows.start, rows.stop if self.holding else rows.start
        self._load, self._cloth_load = self._contacts.sensed(
            self.data, grip, self._load_share, self._load, self._cloth_load
        )
        found = (
            self._cloth_load.depth > TOO_DEEP,
            self.data.solver_niter[0] >= self.config.solver.iterations,
            self.holding and self.cloth_speed > TOO_FAST,
        )
        if any(found):
            self.doubts = self.doubts + self.model.opt.timestep * np.array(found)
        if self.holding and self._load @ self._load > self.config.robot.grip_strength**2:
            self.release()

    def release(self) -> None:
        """Open the fingers: the cloth is no longer held."""
        self.data.eq_active[self._grip] = 0
        self.holding = False

    @property
    def invalid_reason(self) -> str | None:
        """Why the simulation can no longer be trusted, or None while it can."""
        data, numbers = self.data, self.data.warning.number
        if is_sound(numbers, data.qpos, data.qvel, self.doubts, DOUBTFUL_TIME):
            return None
        # MuJoCo sets a world that diverges back to its beginning, its clock included.
        when = f"{self._last_sound:.2f} s after the cloth began to fall"
        if numbers.any():
            name = mujoco.mjtWarning(int(np.flatnonzero(numbers)[0])).name.removeprefix("mjWARN_")
            return f"solver warning {name} {when}"
        if not (np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all()):
            return f"non-finite state {when}"
        worst = int(np.argmax(self.doubts))
        return f"{DOUBTS[worst]} for more than {DOUBTFUL_TIME:g} s in all, {when}"

    @property
    def arm_configuration(self) -> NDArray[np.float64]:
        """Joint positions (n,) of the arm [rad]."""
        return self.data.qpos[self._arm_qpos].copy()

    @property
    def arm_velocity(self) -> NDArray[np.float64]:
        """Joint velocities (n,) of the arm [rad/s]."""
        return self.data.qvel[self._arm_dof].copy()

    @property
    def arm_torque(self) -> NDArray[np.float64]:
        """Torques (n,) of the arm's joints in the last step, gravity included [N m]."""
        # MuJoCo clips what a servo would do in the state before the step. If that is within the
        # limit, the discrete integrator applies what it does in the state after the step.
        data, dofs = self.data, self._arm_dof
        torque: NDArray[np.float64] = servo_torques(
            data.ctrl[self._arm_actuator],
            data.qpos[self._arm_qpos],
            data.qvel[dofs],
            data.actuator_force[self._arm_actuator],
            data.qfrc_gravcomp[dofs],
            self._stiffness,
            self._damping,
            self._effort,
        )
        return torque

    @property
    def tcp_position(self) -> NDArray[np.float64]:
        """Tool centre point (3,), between the fingertips, as the last physics step began."""
        return self.data.xpos[self._tcp].copy()

    @property
    def arm_joints(self) -> NDArray[np.float64]:
        """Wrist, elbow and shoulder joint, (3, 3), as the last physics step began."""
        return self._still if self._person is None else self._person.joints(self.data)

    @property
    def person(self) -> NDArray[np.float64] | None:
        """Coordinates (7,) of the mannequin's arm [m, rad], see `dressing_sim.motion.COORDINATES`;
        None if it does not move."""
        return None if self._person is None else self.data.qpos[self._person.positions].copy()

    @property
    def cloth(self) -> NDArray[np.float64]:
        """Positions of the sleeve's vertices, (n_vertices, 3), as the last physics step began."""
        return self.data.flexvert_xpos[self._vertices].copy()

    @property
    def cloth_speed(self) -> float:
        """Speed of the fastest vertex of the sleeve [m/s]."""
        return float(fastest(self.data.qvel[self._cloth_dofs]))

    def clearance(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Distance (n,) [m] of points (n, 3) from the surface of the arm, negative inside."""
        model, data, geoms = self.model, self.data, self._arm_geoms
        # Spheres and capsules: the latter are cylinders along z with a rounded end each.
        capsule = model.geom_type[geoms] == int(mujoco.mjtGeom.mjGEOM_CAPSULE)
        half = np.where(capsule, model.geom_size[geoms, 1], 0.0)
        axis = data.geom_xmat[geoms].reshape(-1, 3, 3)[:, :, 2]
        offset = points[:, None] - data.geom_xpos[geoms]
        along = np.clip((offset * axis).sum(axis=2), -half, half)
        distance = np.linalg.norm(offset - along[:, :, None] * axis, axis=2)
        return np.min(distance - model.geom_size[geoms, 0], axis=1)

    def robot_clearance(
        self,
        configurations: NDArray[np.float64],
        persons: NDArray[np.float64] | None = None,
    ) -> NDArray[np.float64]:
        """Distance (n,) [m] of the robot from the mannequin, negative where they overlap.

        Args:
            configurations: Joint positions of the robot's arm, (n, n_joints) [rad].
            persons: `person` in each of them, (n, 7); its posture if not given.
        """
        data = mujoco.MjData(self.model)
        nearest = np.empty(len(configurations))
        for row, q in enumerate(configurations):
            data.qpos[self._arm_qpos] = q
            if persons is not None and self._person is not None:
                data.qpos[self._person.positions] = persons[row]
            mujoco.mj_kinematics(self.model, data)
            nearest[row] = self._contacts.robot_distance(self.model, data)
        return nearest

    @property
    def grip_force(self) -> NDArray[np.float64]:
        """Force (3,) with which the fingers pull the cloth, the sum over the gripped vertices."""
        if not self.holding:
            return np.zeros(3)
        # A connect constraint has three rows, the axes of the world; its force is that on the
        # first body, the hand, and the cloth feels the opposite.
        return -self.data.efc_force[self._grip_rows].reshape(-1, 3).sum(axis=0)

    @property
    def grip_load(self) -> NDArray[np.float64]:
        """The grip's force (3,) as a force sensor reads it: low-passed at `FORCE_CUTOFF`."""
        return self._load.copy()

    @property
    def cloth_load(self) -> ClothForces:
        """How the cloth presses on each link of the mannequin, as force sensors in the links read
        it: low-passed at `FORCE_CUTOFF`."""
        return self._cloth_load

    def cloth_forces(self) -> ClothForces:
        """How the cloth presses on each link of the mannequin now."""
        return self._contacts.cloth(self.data)

    def link_force(self, link: str, source: str = "cloth") -> NDArray[np.float64]:
        """Net contact force (3,) on a link of the mannequin.

        Args:
            link: One of `dressing_sim.world.mannequin.LINKS`.
            source: ``"cloth"`` or ``"robot"``.

        Raises:
            InvalidInputError: Another source.
        """
        if source not in ("cloth", "robot"):
            raise InvalidInputError(f"source is {source!r}, valid is cloth or robot")
        robot = source == "robot"
        net = self._contacts.robot(self.data) if robot else self._contacts.cloth(self.data).net
        return net[LINKS.index(link)]

    def touches(self) -> tuple[Touch, ...]:
        """Where the robot touches the mannequin now, with a force or without."""
        return self._contacts.touches(self.data)


def _following(first: int, n: int) -> slice:
    return slice(int(first), int(first) + n)
