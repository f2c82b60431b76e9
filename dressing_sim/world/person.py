"""A person who moves: the mannequin as a chain of joints, and what leads it through its motion.

The chain is the posture's own: three slides for the shoulder, with torso and head, then flexion,
abduction and rotation of the upper arm and the elbow, so that a joint's position is the coordinate
of `dressing_sim.motion.COORDINATES` in [m, rad]. What is prescribed is led: before each physics
step the joint is where, and as fast as, the motion says, and so heavy that no force changes that
within the step; contacts and friction then see the skin move. Compliant joints are springs and
dampers about where the motion wants them, integrated with the cloth.
"""

from __future__ import annotations

from typing import TypeAlias

import mujoco
import numpy as np
from numpy.typing import NDArray

from dressing_sim.arm import ANGLE_LIMITS_DEG, FORWARD, LEFT, UP, Posture, rotation_about
from dressing_sim.motion import COORDINATES, JOINTS, UNITS, Motion
from dressing_sim.world.servo import add_servo

#: Density of an arm's segments [kg/m^3]: Dempster 1955, as in Winter, "Biomechanics and Motor
#: Control of Human Movement".
DENSITY = {"upper_arm": 1070.0, "forearm": 1130.0, "hand": 1160.0}

#: Inertia added to joints that are led [kg, kg m^2]: ten newtons of cloth change the speed of what
#: is led by a ten-thousandth of a millimetre a second in a physics step, before it is led again,
#: and a compliant arm feels of that a millionth of the force.
LED = 1e6

#: The body that carries torso, head and arm.
_PERSON = "person"

#: A body of the model, and its origin (3,) in the robot's base frame [m].
_Placed: TypeAlias = "tuple[mujoco.MjsBody, NDArray[np.float64]]"


def joint_name(coordinate: str) -> str:
    """Name of the joint, or of its actuator, for a coordinate."""
    return f"{_PERSON}_{coordinate}"


def add_chain(spec: mujoco.MjSpec, posture: Posture) -> dict[str, _Placed]:
    """Add the bodies of a person who moves, without their geoms.

    Args:
        spec: Model to edit, whose compiler takes angles in radians.
        posture: An arm with a motion.

    Returns:
        Body and origin of each link of the mannequin.
    """
    shoulder, elbow, wrist = posture.shoulder, posture.elbow, posture.wrist
    person = spec.worldbody.add_body(
        name=_PERSON, pos=shoulder, mass=1.0, inertia=[1.0, 1.0, 1.0], explicitinertial=True
    )
    upper_arm = person.add_body(name="upper_arm")
    forearm = upper_arm.add_body(name="forearm", pos=elbow - shoulder)
    bodies = {
        "hand": (forearm.add_body(name="hand", pos=wrist - elbow), wrist),
        "forearm": (forearm, elbow),
        "upper_arm": (upper_arm, shoulder),
        "torso": (person.add_body(name="torso"), shoulder),
        "head": (person.add_body(name="head"), shoulder),
    }
    # The person carries the arm's weight, wherever it is.
    for body in (person, *(body for body, _ in bodies.values())):
        body.gravcomp = 1.0
    for coordinate, axis in zip(COORDINATES[:3], np.eye(3), strict=True):
        _add_joint(spec, person, posture, coordinate, axis)
    # The axes of `Posture.upper_arm_rotation`, in the order in which it turns the arm.
    flexion, abduction = np.deg2rad([posture.flexion_deg, posture.abduction_deg])
    flexed = rotation_about(LEFT, -flexion)
    abducted = flexed @ rotation_about(FORWARD, abduction)
    for coordinate, axis in zip(JOINTS[:3], (-LEFT, flexed @ FORWARD, -abducted @ UP), strict=True):
        _add_joint(spec, upper_arm, posture, coordinate, axis)
    _add_joint(spec, forearm, posture, JOINTS[3], -posture.upper_arm_rotation[:, 1])
    return bodies


def _add_joint(
    spec: mujoco.MjSpec,
    body: mujoco.MjsBody,
    posture: Posture,
    coordinate: str,
    axis: NDArray[np.float64],
) -> None:
    place = COORDINATES.index(coordinate)
    motion, name = posture.motion, joint_name(coordinate)
    assert motion is not None
    slides = coordinate not in JOINTS
    joint = body.add_joint(
        name=name,
        type=mujoco.mjtJoint.mjJNT_SLIDE if slides else mujoco.mjtJoint.mjJNT_HINGE,
        axis=axis,
        ref=float(posture.coordinates[place] * (1.0 if slides else UNITS[place])),
    )
    if slides or motion.compliance is None:
        joint.armature = LED
        return
    number = JOINTS.index(coordinate)
    joint.limited = mujoco.mjtLimited.mjLIMITED_TRUE
    joint.range = np.deg2rad(ANGLE_LIMITS_DEG[coordinate])
    gives = motion.compliance
    add_servo(spec, name, gives.stiffness[number], gives.damping[number])


class Person:
    """Leads the joints of a mannequin that `add_chain` added.

    Args:
        model: The world; what the solver's tolerance is measured by becomes that of a world with
            a still mannequin.
        posture: Its arm, with a motion.

    Attributes:
        positions: Where the chain's joints are in ``MjData.qpos``, (7,).
    """

    def __init__(self, model: mujoco.MjModel, posture: Posture) -> None:
        assert posture.motion is not None
        self._motion: Motion = posture.motion
        self._rest = posture.coordinates * UNITS
        joints = [model.joint(joint_name(coordinate)) for coordinate in COORDINATES]
        self.positions = np.array([joint.qposadr[0] for joint in joints])
        self._speeds = np.array([joint.dofadr[0] for joint in joints])
        self._bodies = [model.body(name).id for name in ("hand", "forearm", "upper_arm")]
        compliance = self._motion.compliance
        self._n_led = len(COORDINATES) if compliance is None else len(COORDINATES) - len(JOINTS)
        if compliance is not None:
            self._actuators = np.array([model.actuator(joint_name(name)).id for name in JOINTS])
            self._lag = np.array(compliance.damping) / np.array(compliance.stiffness)
        self._dt = float(model.opt.timestep)
        _leave_out_of_scale(model, self._speeds)

    def wanted(self, time: float) -> NDArray[np.float64]:
        """Where the motion wants the coordinates, (7,) [m, rad], so long after it began [s]."""
        return self._rest + self._motion.offsets(time)

    def lead(self, data: mujoco.MjData, time: float | None) -> None:
        """Before a physics step, put what is led where it is then, and tell the rest where to be.

        Args:
            data: The world's state.
            time: Since the motion began [s]; None before it.
        """
        here = self._rest if time is None else self.wanted(time)
        there = self._rest if time is None else self.wanted(time + self._dt)
        speed, led = (there - here) / self._dt, slice(self._n_led)
        data.qpos[self.positions[led]] = here[led]
        data.qvel[self._speeds[led]] = speed[led]
        if self._n_led < len(COORDINATES):
            data.ctrl[self._actuators] = there[self._n_led :] + self._lag * speed[self._n_led :]

    def joints(self, data: mujoco.MjData) -> NDArray[np.float64]:
        """Wrist, elbow and shoulder joint, (3, 3), as the last physics step began [m]."""
        return data.xpos[self._bodies].copy()


def _leave_out_of_scale(model: mujoco.MjModel, dofs: NDArray[np.intp]) -> None:
    """MuJoCo scales the solver's tolerance by the mean inertia; that of led joints is no one's."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    inertia = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, inertia)
    others = np.setdiff1d(np.arange(model.nv), dofs)
    if len(others):
        model.stat.meaninertia = float(np.diag(inertia)[others].mean())
