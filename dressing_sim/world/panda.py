"""The Franka Panda with its hand, built from the URDF that ``example-robot-data`` installs.

The same file is read by Pinocchio (`dressing_sim.control`), so both agree on the kinematics by
construction. Nothing is copied: meshes are referenced where the package keeps them.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import mujoco
import numpy as np

from dressing_sim.config import check_numbers
from dressing_sim.errors import DressingSimError, InvalidInputError

ARM_JOINTS = tuple(f"panda_joint{i}" for i in range(1, 8))
FINGER_JOINTS = ("panda_finger_joint1", "panda_finger_joint2")
TCP_BODY = "panda_hand_tcp"
BASE_BODY = "panda_link0"

#: A resting posture with the hand pointing down in front of the base [rad].
HOME = (0.0, -0.785398, 0.0, -2.356194, 0.0, 1.570796, 0.785398)


@dataclass(frozen=True, slots=True)
class ServoConfig:
    """Joint position servos: torque = stiffness (command - q) - damping qd, clipped at the limit.

    The gains are our own choice, as stiff as the physics step allows: the discrete integrator takes
    servos implicitly, but clips them by what they would do at the step's start, so a servo at its
    limit loses its damping. So each is critically damped for the inertia that its joint feels at
    most (Pinocchio), and at half its speed and acceleration limits stays below its torque limit.
    """

    stiffness: tuple[float, ...] = (4500.0, 4500.0, 3500.0, 3500.0, 600.0, 600.0, 400.0)
    """Of each arm joint [N m/rad]; any sequence, kept as a tuple, as is the damping."""
    damping: tuple[float, ...] = (250.0, 250.0, 150.0, 120.0, 20.0, 20.0, 14.0)
    """Of each arm joint [N m s/rad]."""
    finger_stiffness: float = 2000.0
    """Of each finger [N/m]."""
    finger_damping: float = 50.0
    """Of each finger [N s/m]."""
    finger_force: float = 70.0
    """Largest grip force [N], the Panda hand's continuous rating."""
    armature: float = 0.1
    """Reflected rotor inertia added to each arm joint [kg m^2]."""

    def __post_init__(self) -> None:
        for name in ("stiffness", "damping"):
            gains = tuple(map(float, getattr(self, name)))
            if len(gains) != len(ARM_JOINTS) or not all(0.0 < gain < np.inf for gain in gains):
                raise InvalidInputError(
                    f"servo: {name} is {gains}, valid is a number > 0 for each of the "
                    f"{len(ARM_JOINTS)} joints"
                )
            object.__setattr__(self, name, gains)
        check_numbers(
            self, "servo", ("finger_stiffness", "finger_damping", "finger_force"), ("armature",)
        )


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of the seven arm joints, each array (7,), as the URDF states them."""

    lower: np.ndarray
    """Lowest position [rad]."""
    upper: np.ndarray
    """Highest position [rad]."""
    velocity: np.ndarray
    """Highest speed [rad/s]."""
    effort: np.ndarray
    """Highest torque [N m]."""


def robot_data() -> Path:
    """Folder that ``package://`` addresses in the robot's URDF are relative to.

    Raises:
        DressingSimError: The package ``example-robot-data`` is not installed.
    """
    try:
        share = distribution("example-robot-data").locate_file("cmeel.prefix/share")
    except PackageNotFoundError as error:
        raise DressingSimError(
            "the robot's description is missing: install the package example-robot-data"
        ) from error
    return Path(str(share)).resolve()


def urdf_path() -> Path:
    """The Panda's URDF as installed."""
    path = robot_data() / "example-robot-data/robots/panda_description/urdf/panda.urdf"
    if not path.is_file():
        raise DressingSimError(f"the installed example-robot-data has no Panda: {path} is missing")
    return path


def mesh_path(address: str) -> Path:
    """The file behind a ``package://`` address of the URDF."""
    return robot_data() / address.removeprefix("package://")


@cache
def joint_limits() -> JointLimits:
    """Limits of the arm joints, read from the URDF."""
    joints = {joint.get("name"): joint for joint in ET.parse(urdf_path()).iter("joint")}
    limits = [joints[name].find("limit") for name in ARM_JOINTS]

    def column(attribute: str) -> np.ndarray:
        values = np.array([float(limit.get(attribute)) for limit in limits])  # type: ignore[union-attr, arg-type]
        values.flags.writeable = False
        return values

    return JointLimits(column("lower"), column("upper"), column("velocity"), column("effort"))


@cache
def _physics_urdf() -> str:
    """The URDF as MuJoCo wants it: absolute mesh paths, no visual meshes (it reads no .dae)."""
    root = ET.parse(urdf_path()).getroot()
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(mesh_path(mesh.get("filename", ""))))
    settings = ET.SubElement(root, "mujoco")
    ET.SubElement(
        settings, "compiler", strippath="false", fusestatic="false", discardvisual="false"
    )
    return ET.tostring(root, encoding="unicode")


def panda_spec(servo: ServoConfig, contype: int, conaffinity: int) -> mujoco.MjSpec:
    """A spec with the robot at the origin: servos, gravity compensation, contact masks.

    Args:
        servo: Gains of the joint servos.
        contype: Contact type bits of every link (see `dressing_sim.world.scene`).
        conaffinity: Contact affinity bits of every link.
    """
    spec = mujoco.MjSpec.from_string(_physics_urdf())
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0
        for number, geom in enumerate(body.geoms):
            geom.name = f"{body.name}_collision{number}"
            geom.contype, geom.conaffinity = contype, conaffinity
            geom.group = 3
    limits = joint_limits()
    for i, name in enumerate(ARM_JOINTS):
        spec.joint(name).armature = servo.armature
        _add_servo(spec, name, servo.stiffness[i], servo.damping[i], limits.effort[i])
    for name in FINGER_JOINTS:
        _add_servo(
            spec, name, servo.finger_stiffness, servo.finger_damping, servo.finger_force / 2.0
        )
    return spec


def _add_servo(
    spec: mujoco.MjSpec, joint: str, stiffness: float, damping: float, effort: float
) -> None:
    gain, bias = np.zeros(10), np.zeros(10)
    gain[0], bias[1], bias[2] = stiffness, -stiffness, -damping
    spec.add_actuator(
        name=joint,
        target=joint,
        trntype=mujoco.mjtTrn.mjTRN_JOINT,
        gaintype=mujoco.mjtGain.mjGAIN_FIXED,
        biastype=mujoco.mjtBias.mjBIAS_AFFINE,
        gainprm=gain,
        biasprm=bias,
        forcelimited=True,
        forcerange=[-effort, effort],
    )
