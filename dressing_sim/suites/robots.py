"""Robots by file: a URDF, and what it does not say."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from dressing_sim.checks import of_kind
from dressing_sim.control import RobotKinematics
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.measures import (
    Choice,
    Each,
    Measure,
    Schema,
    Values,
    find_file,
    load_named,
)
from dressing_sim.system import silent_libraries
from dressing_sim.world.description import checksum, joint_limits
from dressing_sim.world.robot import MAX_BASE_DISTANCE, PANDA, Gripper, Robot, ServoConfig
from dressing_sim.world.robot_spec import robot_spec
from dressing_sim.world.scene import compiled

#: Robots by name that need no file.
ROBOTS: Mapping[str, Robot] = {PANDA.name: PANDA}

#: What the address of a URDF that is installed begins with.
_PACKAGE = "package://"

#: What is called the tool centre point of a robot with a gripper of ours.
_TOOL = "gripper_tcp"

#: What is told of a grip that a robot's file says nothing of.
NO_GRIP_SOURCE = "not known: the strength of the Panda's hand stands for it"

#: Sizes of `Gripper`, by key.
_GRIPPER: Mapping[str, str] = {
    "mass_kg": "mass",
    "palm_length_m": "palm_length",
    "palm_width_m": "palm_width",
    "palm_thickness_m": "palm_thickness",
    "finger_length_m": "finger_length",
    "finger_width_m": "finger_width",
    "finger_thickness_m": "finger_thickness",
}

_BASE = Measure("m", -MAX_BASE_DISTANCE, MAX_BASE_DISTANCE, "where its root stands, forward")

#: What the file of a robot may say.
ROBOT: Schema = {
    "name": Choice("what the robot is called; must be there"),
    "urdf": Choice("its description: a file beside this one, or package://...; must be there"),
    "tool": Choice("link between the fingertips of its own hand, z along them; or a gripper"),
    "rotor_inertia_kg_m2": Measure("kg m^2", 0.0, 10.0, "reflected, added to each joint"),
    "grip": {
        "strength_n": Measure("N", 0.1, 1000.0, "pull at which cloth slips from its fingers"),
        "source": Choice("where that is from; must be there with a strength"),
    },
    "base": {
        "x_m": _BASE,
        "y_m": replace(_BASE, what="to the left"),
        "z_m": replace(_BASE, what="up"),
        "yaw_deg": Measure("deg", -360.0, 360.0, "how far it is turned to the left there"),
    },
    "gripper": {
        "flange": Choice("link that a plain gripper is fixed to, z away from the robot"),
        "mass_kg": Measure("kg", 0.01, 10.0, "all of it"),
        "palm_length_m": Measure("m", 0.01, 0.5, "along the fingers"),
        "palm_width_m": Measure("m", 0.01, 0.5, "along the way that the fingers open"),
        "palm_thickness_m": Measure("m", 0.01, 0.5, "across both"),
        "finger_length_m": Measure("m", 0.02, 0.3, "from the palm to the tip"),
        "finger_width_m": Measure("m", 0.002, 0.1, "as the palm's thickness"),
        "finger_thickness_m": Measure("m", 0.002, 0.1, "of each, as the palm's width"),
    },
    "joints": Each(
        "NAME",
        {
            "home_deg": Measure("deg", -360.0, 360.0, "at rest, hand down; must be there"),
            "stiffness_n_m_per_rad": Measure("N m/rad", 1.0, 1e6, "of its servo; must be there"),
            "damping_n_m_s_per_rad": Measure("N m s/rad", 0.1, 1e5, "of its servo; must be there"),
            "acceleration_rad_per_s2": Measure(
                "rad/s^2", 0.1, 1000.0, "largest of a command; must be there"
            ),
        },
    ),
}


def load_robot(name_or_file: str) -> Robot:
    """A robot, once its description has been found to have what it says.

    Args:
        name_or_file: ``panda``, one of ``assets/robots``, or a TOML file, see `ROBOT`.

    Raises:
        InvalidInputError: There is none, or the file or its URDF is not valid.
    """
    if of_kind(name_or_file, str, "a robot", "a name or a TOML file") in ROBOTS:
        return ROBOTS[name_or_file]
    folder = find_file(name_or_file, "robot", "robots", ROBOTS).parent

    def made(values: Values) -> Robot:
        found = robot(values, folder)
        if not found.urdf.startswith(_PACKAGE):
            found = replace(found, urdf_checksum=checksum(found))
        check_robot(found)
        return found

    return load_named(name_or_file, "robot", ROBOTS, "robots", ROBOT, made)


def check_robot(robot: Robot) -> None:
    """Find out before anything begins whether a robot can be simulated and controlled.

    Raises:
        InvalidInputError: Its description is not valid, or MuJoCo or Pinocchio refuses it.
    """
    joint_limits(robot)
    try:
        compiled(robot_spec(robot, contype=0, conaffinity=0))
    except InvalidInputError as error:
        told = str(error).removeprefix(f"robot {robot.name}: ").removeprefix("world: ")
        raise InvalidInputError(f"robot {robot.name}: {told}") from error
    with silent_libraries():  # the reader behind Pinocchio prints lines of its own
        RobotKinematics(robot)


def robot(values: Values, folder: Path) -> Robot:
    """The robot whose file says this, see `ROBOT`.

    Args:
        values: What it says.
        folder: Where it is.

    Raises:
        InvalidInputError: Something is missing, or no robot is like that.
    """
    for key in ("name", "urdf", "joints"):
        if key not in values:
            raise InvalidInputError(f"no {key}; valid is a robot's name, urdf and joints")
    hand = dict(values.get("gripper", {}))
    if ("flange" in hand) == ("tool" in values):
        raise InvalidInputError("valid is either tool, of a hand of its own, or gripper.flange")
    joints = values["joints"]
    for name, said in joints.items():
        for key in _joint_keys():
            if key not in said:
                raise InvalidInputError(f"no joints.{name}.{key}; valid is one for each joint")
    grip = values.get("grip", {})
    if ("strength_n" in grip) != ("source" in grip):
        raise InvalidInputError("valid are both grip.strength_n and grip.source, or neither")
    column = {key: tuple(said[key] for said in joints.values()) for key in _joint_keys()}
    base, urdf = values.get("base", {}), values["urdf"]
    return Robot(
        name=values["name"],
        urdf=urdf if urdf.startswith(_PACKAGE) else str((folder / urdf).resolve()),
        joints=tuple(joints),
        fingers=(),
        tool=values.get("tool", _TOOL),
        home=tuple(np.deg2rad(column["home_deg"]).tolist()),
        acceleration=column["acceleration_rad_per_s2"],
        servo=ServoConfig(
            stiffness=column["stiffness_n_m_per_rad"],
            damping=column["damping_n_m_s_per_rad"],
            armature=values.get("rotor_inertia_kg_m2", ServoConfig().armature),
        ),
        gripper=Gripper(
            hand.pop("flange", ""), **{_GRIPPER[key]: value for key, value in hand.items()}
        ),
        base_position=tuple(base.get(f"{axis}_m", 0.0) for axis in "xyz"),
        base_yaw=float(np.deg2rad(base.get("yaw_deg", 0.0))),
        grip_strength=grip.get("strength_n", PANDA.grip_strength),
        grip_source=grip.get("source", NO_GRIP_SOURCE),
    )


def _joint_keys() -> tuple[str, ...]:
    joints = ROBOT["joints"]
    assert isinstance(joints, Each)
    return tuple(joints.schema)


def with_robot(config: EpisodeConfig, name_or_file: str | None) -> EpisodeConfig:
    """The same world with another robot, see `load_robot`, or as it is for None."""
    of_kind(config, EpisodeConfig, "config", "an EpisodeConfig")
    if name_or_file is None:
        return config
    return replace(config, world=replace(config.world, robot=load_robot(name_or_file)))
