"""A robot's description: its URDF as installed, with what a `Robot` adds to it.

Pinocchio (`dressing_sim.control`) and MuJoCo read the same text, so both agree on the kinematics by
construction. Nothing is copied: meshes are referenced where they are.
"""

from __future__ import annotations

import hashlib
import xml.etree.ElementTree as ET
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import numpy as np

from dressing_sim.checks import shown
from dressing_sim.errors import DressingSimError, InvalidInputError, one_line
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.robot import PANDA, Gripper, Robot
from dressing_sim.world.urdf_numbers import check_numbers

#: What the link of a `Gripper` is called.
GRIPPER_LINK = "gripper"

#: What a ROS package's address begins with, and the package that is installed with this one.
_PACKAGE, _INSTALLED = "package://", "example-robot-data"

#: Largest limit of a joint that is meant, [rad], [rad/s] and [N m].
_LARGEST_LIMIT = 1e6


@dataclass(frozen=True, slots=True)
class JointLimits:
    """Limits of the arm joints, each array (n,), as the URDF states them."""

    lower: np.ndarray
    """Lowest position [rad]."""
    upper: np.ndarray
    """Highest position [rad]."""
    velocity: np.ndarray
    """Highest speed [rad/s]."""
    effort: np.ndarray
    """Highest torque [N m]."""


def robot_data() -> Path:
    """Folder that addresses of the installed robots' package are relative to.

    Raises:
        DressingSimError: The package ``example-robot-data`` is not installed.
    """
    try:
        share = distribution(_INSTALLED).locate_file("cmeel.prefix/share")
    except PackageNotFoundError as error:
        raise DressingSimError(
            f"the robot's description is missing: install the package {_INSTALLED}"
        ) from error
    return Path(str(share)).resolve()


def addressed(address: str, folder: Path = Path()) -> Path:
    """The file behind an address in a URDF.

    Args:
        address: ``package://PACKAGE/FILE`` of the installed robots, or of a ROS package whose
            folder is one of those that `folder` is in; or a file, relative to `folder`.
        folder: Where the URDF is.
    """
    if not address.startswith(_PACKAGE):
        return folder / address.removeprefix("file://")
    inside = address.removeprefix(_PACKAGE)
    if not inside.startswith(f"{_INSTALLED}/"):
        for parent in (folder, *folder.parents):
            if (parent / inside).exists():
                return parent / inside
    return robot_data() / inside


def urdf_path(robot: Robot = PANDA) -> Path:
    """A robot's URDF.

    Raises:
        InvalidInputError: There is no such file.
    """
    path = addressed(robot.urdf)
    if not path.is_file():
        raise InvalidInputError(f"robot {robot.name}: {path} is missing, valid is a URDF file")
    return path.resolve()


def checksum(robot: Robot) -> str:
    """Of a robot's URDF and of the meshes that touch, wherever they are.

    Raises:
        InvalidInputError: It is no URDF, or a file cannot be read.
    """
    path = urdf_path(robot)
    meshes = _parsed(robot).findall(".//collision//mesh")
    files = [addressed(mesh.get("filename", ""), path.parent) for mesh in meshes]
    digest = hashlib.sha256()
    try:
        for file in (path, *files):
            digest.update(file.read_bytes() if file.is_file() else b"missing")
    except OSError as error:
        raise _wrong(robot, f"{one_line(str(error))}, valid is a file that can be read") from error
    return digest.hexdigest()[:16]


@lru_cache(maxsize=8)
def urdf_text(robot: Robot = PANDA) -> str:
    """A robot's URDF, checked, with its gripper, and standing where it should.

    Raises:
        InvalidInputError: It is none, has not what the `Robot` names, or is not what it was.
    """
    root = _parsed(robot)
    if robot.urdf_checksum not in ("", checksum(robot)):
        told = "or a mesh of it is another than its config says, valid is the one that it was"
        raise _wrong(robot, f"{urdf_path(robot)} {told}")
    try:
        check_numbers(root)
    except InvalidInputError as error:
        raise _wrong(robot, str(error)) from error
    _check_links(robot, root)
    joints = {_name(joint): joint for joint in root.findall("joint")}
    _check_joints(robot, joints)
    _lock(joints, {*robot.joints, *robot.fingers})
    if robot.gripper.flange:
        _attach(root, robot.gripper, robot.tool)
    if any(robot.base_position) or robot.base_yaw:
        _stand(root, robot)
    try:
        return ET.tostring(root, encoding="unicode")
    except RecursionError as error:
        told = "has elements in a thousand others, valid are links and joints beside each other"
        raise _wrong(robot, f"{urdf_path(robot)} {told}") from error


def _parsed(robot: Robot) -> ET.Element:
    path = urdf_path(robot)
    try:
        return ET.parse(path).getroot()
    except (ET.ParseError, OSError, ValueError, LookupError) as error:
        raise _wrong(robot, f"{path} is no URDF ({one_line(str(error))})") from error


@lru_cache(maxsize=8)
def joint_limits(robot: Robot = PANDA) -> JointLimits:
    """Limits of the arm joints, read from the URDF."""
    joints = {_name(joint): joint for joint in ET.fromstring(urdf_text(robot)).findall("joint")}
    arm = [joints[name] for name in robot.joints]

    def column(attribute: str) -> np.ndarray:
        values = np.array([_number(joint, attribute) for joint in arm])
        values.flags.writeable = False
        return values

    return JointLimits(column("lower"), column("upper"), column("velocity"), column("effort"))


def _wrong(robot: Robot, told: str) -> InvalidInputError:
    return InvalidInputError(f"robot {robot.name}: {told}")


def _name(element: ET.Element) -> str:
    return element.get("name", "")


def _end(joint: ET.Element, which: str) -> str:
    """Name of the link that is a joint's parent or child."""
    link = joint.find(which)
    return "" if link is None else link.get("link", "")


def _check_links(robot: Robot, root: ET.Element) -> None:
    links = [_name(link) for link in root.findall("link")]
    hand = robot.gripper.flange or robot.tool
    if hand not in links:
        raise _wrong(robot, f"no link {shown(hand)} in its URDF, valid are {_listed(links)}")
    made = {GRIPPER_LINK, robot.tool} if robot.gripper.flange else set()
    for name in links:
        if name in LINKS or name in made:
            told = f"its URDF has a link {shown(name)}, valid is a name that is not used yet"
            raise _wrong(robot, told)


def _check_joints(robot: Robot, joints: dict[str, ET.Element]) -> None:
    """Refuse joints that are not there, not a chain to the hand, or without limits."""
    for name in (*robot.joints, *robot.fingers):
        if name not in joints:
            told = f"no joint {shown(name)} in its URDF, valid are {_listed(joints)}"
            raise _wrong(robot, told)
    above = {_end(joint, "child"): joint for joint in joints.values()}
    link, chain = robot.gripper.flange or robot.tool, list[str]()
    while link in above and len(chain) <= len(joints):
        chain.insert(0, _name(above[link]))
        link = _end(above[link], "parent")
    order = tuple(name for name in chain if name in robot.joints)
    if order != robot.joints:
        raise _wrong(
            robot,
            f"its joints are {', '.join(robot.joints)}, valid is their order from the base to the "
            f"hand, {', '.join(order) or 'which none of them is between'}",
        )
    for name, home in zip(robot.joints, robot.home, strict=True):
        keys = ("lower", "upper", "velocity", "effort")
        numbers = [_number(joints[name], key) for key in keys]
        if joints[name].get("type") != "revolute" or not (
            numbers[0] < numbers[1]
            and min(numbers[2:]) > 0.0
            and all(abs(number) <= _LARGEST_LIMIT for number in numbers)  # no NaN is
        ):
            told = f"joint {name} is {joints[name].get('type')!r:.40} with the limits"
            valid = (
                "valid is a revolute joint with limits of position, the lower below the upper, and "
                f"of velocity and effort, above zero, none beyond {_LARGEST_LIMIT:g}"
            )
            pairs = zip(keys, numbers, strict=True)
            limits = ", ".join(f"{key} {number:g}" for key, number in pairs)
            raise _wrong(robot, f"{told} {limits}; {valid}")
        if not numbers[0] <= home <= numbers[1]:
            told = f"joint {name} rests at {home:g} rad, valid is {numbers[0]:g} to {numbers[1]:g}"
            raise _wrong(robot, told)


def _number(joint: ET.Element, key: str) -> float:
    """One of a joint's limits; NaN if it is not there, or no number."""
    limit = joint.find("limit")
    try:
        return float((limit is not None and limit.get(key)) or "nan")
    except ValueError:
        return float("nan")


def _listed(names: Iterable[str]) -> str:
    return one_line(", ".join(names))


def _lock(joints: dict[str, ET.Element], free: set[str]) -> None:
    """Fix all joints but some, at zero."""
    for name, joint in joints.items():
        if name not in free and joint.get("type") != "fixed":
            joint.set("type", "fixed")
            for part in ("axis", "limit", "mimic", "dynamics", "safety_controller", "calibration"):
                for found in joint.findall(part):
                    joint.remove(found)


def _attach(root: ET.Element, gripper: Gripper, tool: str) -> None:
    """Add the gripper's link and the tool's."""
    palm = (gripper.palm_thickness, gripper.palm_width, gripper.palm_length)
    finger = (gripper.finger_width, gripper.finger_thickness, gripper.finger_length)
    link = ET.SubElement(root, "link", name=GRIPPER_LINK)
    middle = gripper.palm_length / 2.0
    inertial = ET.SubElement(link, "inertial")
    ET.SubElement(inertial, "origin", xyz=_text(0.0, 0.0, middle))
    ET.SubElement(inertial, "mass", value=repr(gripper.mass))
    # Of a box about its centre.
    x, y, z = (gripper.mass / 12.0 * size**2 for size in palm)
    moments = {"ixx": y + z, "iyy": x + z, "izz": x + y, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    ET.SubElement(inertial, "inertia", {key: repr(moment) for key, moment in moments.items()})
    along = gripper.palm_length + gripper.finger_length / 2.0
    aside = gripper.finger_thickness / 2.0
    for kind in ("visual", "collision"):
        for size, place in (
            (palm, (0.0, 0.0, middle)),
            (finger, (0.0, aside, along)),
            (finger, (0.0, -aside, along)),
        ):
            shape = ET.SubElement(link, kind)
            ET.SubElement(shape, "origin", xyz=_text(*place))
            geometry = ET.SubElement(shape, "geometry")
            ET.SubElement(geometry, "box", size=_text(*size))
    _fix(root, gripper.flange, GRIPPER_LINK)
    ET.SubElement(root, "link", name=tool)
    _fix(root, GRIPPER_LINK, tool, (0.0, 0.0, gripper.reach))


def _stand(root: ET.Element, robot: Robot) -> None:
    """Put the robot on a root of its own, which stands at the origin."""
    children = {_end(joint, "child") for joint in root.findall("joint")}
    roots = [_name(link) for link in root.findall("link") if _name(link) not in children]
    if len(roots) != 1:
        raise _wrong(robot, f"its URDF has {len(roots)} links without a joint above, valid is one")
    old = roots[0]
    if old == "world":  # which MuJoCo takes for its own, wherever it is
        old = "robot_root"
        for element in root.iter():
            for key in ("name", "link"):
                if element.get(key) == "world" and element.tag in ("link", "parent", "child"):
                    element.set(key, old)
    ET.SubElement(root, "link", name="origin")
    _fix(root, "origin", old, robot.base_position, robot.base_yaw)


def _fix(
    root: ET.Element,
    parent: str,
    child: str,
    place: tuple[float, ...] = (0.0, 0.0, 0.0),
    yaw: float = 0.0,
) -> None:
    joint = ET.SubElement(root, "joint", name=f"{parent}_{child}_fixed", type="fixed")
    ET.SubElement(joint, "origin", xyz=_text(*place), rpy=_text(0.0, 0.0, yaw))
    ET.SubElement(joint, "parent", link=parent)
    ET.SubElement(joint, "child", link=child)


def _text(*numbers: float) -> str:
    return " ".join(repr(float(number)) for number in numbers)
