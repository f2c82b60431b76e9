"""A robot in MuJoCo: its links, servos, gravity compensation and contact masks."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from functools import lru_cache

import mujoco

from dressing_sim.errors import InvalidInputError, one_line
from dressing_sim.world.description import addressed, joint_limits, urdf_path, urdf_text
from dressing_sim.world.robot import Robot
from dressing_sim.world.servo import add_servo


@lru_cache(maxsize=8)
def _physics_urdf(robot: Robot) -> str:
    """The URDF as MuJoCo wants it: absolute mesh paths, no visual meshes (it reads no .dae)."""
    root, folder = ET.fromstring(urdf_text(robot)), urdf_path(robot).parent
    for link in root.findall("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(addressed(mesh.get("filename", ""), folder)))
    settings = ET.SubElement(root, "mujoco")
    ET.SubElement(
        settings, "compiler", strippath="false", fusestatic="false", discardvisual="false"
    )
    return ET.tostring(root, encoding="unicode")


def robot_spec(robot: Robot, contype: int, conaffinity: int) -> mujoco.MjSpec:
    """A spec with the robot where it stands: servos, gravity compensation, contact masks.

    Args:
        robot: Which.
        contype: Contact type bits of every link (see `dressing_sim.world.scene`).
        conaffinity: Contact affinity bits of every link.

    Raises:
        InvalidInputError: MuJoCo cannot read its description.
    """
    try:
        spec = mujoco.MjSpec.from_string(_physics_urdf(robot))
    except (ValueError, mujoco.FatalError) as error:
        told = one_line(str(error))
        raise InvalidInputError(f"robot {robot.name}: MuJoCo refuses its URDF ({told})") from error
    for body in spec.bodies[1:]:
        body.gravcomp = 1.0
        for number, geom in enumerate(body.geoms):
            geom.name = f"{body.name}_collision{number}"
            geom.contype, geom.conaffinity = contype, conaffinity
            geom.group = 3
    servo, limits = robot.servo, joint_limits(robot)
    for i, name in enumerate(robot.joints):
        spec.joint(name).armature = servo.armature
        add_servo(spec, name, servo.stiffness[i], servo.damping[i], limits.effort[i])
    for name in robot.fingers:
        add_servo(
            spec, name, servo.finger_stiffness, servo.finger_damping, servo.finger_force / 2.0
        )
    return spec
