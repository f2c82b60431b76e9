"""The running world: stepping, and what an instrumented laboratory would measure in it."""

from __future__ import annotations

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import Posture
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.panda import ARM_JOINTS, TCP_BODY
from dressing_sim.world.scene import (
    WorldConfig,
    build_spec,
    force_sensor_name,
    grip_name,
)
from dressing_sim.world.sleeve import FLEX, SleeveMesh, vertex_body


class World:
    """Robot, mannequin and sleeve, simulated.

    All positions are in the robot's base frame [m], forces in newtons.

    Args:
        posture: The mannequin's posture.
        config: Cloth, servos, solver.
        arm_configuration: Joint positions (7,) to start from [rad]; the hand's pose there decides
            where the grip holds the sleeve, so the gripper should be at `grip_start`.

    Attributes:
        posture: As given.
        config: As given.
        mesh: The sleeve at rest.
        model: MuJoCo's model.
        data: MuJoCo's state.
    """

    def __init__(
        self, posture: Posture, config: WorldConfig, arm_configuration: NDArray[np.float64]
    ) -> None:
        spec, mesh = build_spec(posture, config)
        self.posture = posture
        self.config = config
        self.mesh: SleeveMesh = mesh
        self.model: mujoco.MjModel = spec.compile()
        self.data = mujoco.MjData(self.model)
        model = self.model
        self._tcp = model.body(TCP_BODY).id
        self._arm_qpos = np.array([model.joint(name).qposadr[0] for name in ARM_JOINTS])
        self._arm_dof = np.array([model.joint(name).dofadr[0] for name in ARM_JOINTS])
        self._arm_actuator = np.array([model.actuator(name).id for name in ARM_JOINTS])
        self._grip = np.array([model.equality(grip_name(v)).id for v in mesh.gripped])
        self._lag = np.array(config.servo.damping) / np.array(config.servo.stiffness)
        flex = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_FLEX, FLEX)
        first = model.flex_vertadr[flex]
        self._vertex_bodies = np.array(
            [model.body(vertex_body(i)).id for i in range(len(mesh.vertices))]
        )
        self._vertices = slice(first, first + len(mesh.vertices))
        self._sensors = {
            (link, source): model.sensor(force_sensor_name(link, source)).adr[0]
            for link in LINKS
            for source in ("all", "robot")
        }
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

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return float(self.data.time)

    def command(self, positions: NDArray[np.float64], velocities: NDArray[np.float64]) -> None:
        """Set the arm servos' reference.

        Args:
            positions: Joint positions (7,) [rad].
            velocities: Joint velocities (7,) [rad/s]; fed forward, so that the servos' damping
                does not make the arm lag behind a moving reference.
        """
        self.data.ctrl[self._arm_actuator] = positions + self._lag * velocities

    def step(self) -> None:
        """Advance the simulation by one time step."""
        mujoco.mj_step(self.model, self.data)

    def release(self) -> None:
        """Open the fingers: the cloth is no longer held."""
        self.data.eq_active[self._grip] = 0

    @property
    def void_reason(self) -> str | None:
        """Why the simulation can no longer be trusted, or None while it can."""
        for kind, warning in enumerate(self.data.warning):
            if warning.number:
                name = mujoco.mjtWarning(kind).name.removeprefix("mjWARN_")
                return f"solver warning {name} at {self.time:.2f} s"
        if not (np.isfinite(self.data.qpos).all() and np.isfinite(self.data.qvel).all()):
            return f"non-finite state at {self.time:.2f} s"
        return None

    @property
    def arm_configuration(self) -> NDArray[np.float64]:
        """Joint positions (7,) of the arm [rad]."""
        return self.data.qpos[self._arm_qpos].copy()

    @property
    def arm_velocity(self) -> NDArray[np.float64]:
        """Joint velocities (7,) of the arm [rad/s]."""
        return self.data.qvel[self._arm_dof].copy()

    @property
    def arm_torque(self) -> NDArray[np.float64]:
        """Servo torques (7,) of the arm [N m]."""
        return self.data.actuator_force[self._arm_actuator].copy()

    @property
    def tcp_position(self) -> NDArray[np.float64]:
        """Tool centre point (3,), between the fingertips."""
        return self.data.xpos[self._tcp].copy()

    @property
    def cloth(self) -> NDArray[np.float64]:
        """Positions of the sleeve's vertices, (n_vertices, 3)."""
        return self.data.flexvert_xpos[self._vertices].copy()

    @property
    def cloth_speed(self) -> float:
        """Speed of the fastest vertex of the sleeve [m/s]."""
        speeds = self.data.cvel[self._vertex_bodies, 3:]
        return float(np.sqrt(np.max(np.einsum("ij,ij->i", speeds, speeds))))

    @property
    def grip_force(self) -> NDArray[np.float64]:
        """Force (3,) with which the fingers pull the cloth, the sum over the gripped vertices."""
        rows = self.data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        held = rows & np.isin(self.data.efc_id, self._grip)
        # A connect constraint has three rows, the axes of the world; its force is that on the
        # first body, the hand, and the cloth feels the opposite.
        return -self.data.efc_force[held].reshape(-1, 3).sum(axis=0)

    def link_force(self, link: str, source: str = "cloth") -> NDArray[np.float64]:
        """Net contact force (3,) on a link of the mannequin.

        Args:
            link: One of `dressing_sim.world.mannequin.LINKS`.
            source: ``"cloth"`` or ``"robot"``.
        """
        robot = self._read_force(link, "robot")
        return robot if source == "robot" else self._read_force(link, "all") - robot

    def robot_contacts(self) -> list[str]:
        """Links of the mannequin that the robot touches now, with a force or without."""
        return [link for link in LINKS if self.data.sensordata[self._sensors[link, "robot"]] > 0]

    def _read_force(self, link: str, source: str) -> NDArray[np.float64]:
        address = self._sensors[link, source]
        # The sensor's normal points away from the link, so the force on the link is its negative.
        return -self.data.sensordata[address + 1 : address + 4]
