"""Descriptions of robots as they are read."""

import xml.etree.ElementTree as ET
from dataclasses import replace
from importlib.metadata import PackageNotFoundError

import numpy as np
import pytest

from dressing_sim.control import RobotKinematics
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.world import description
from dressing_sim.world.description import addressed, joint_limits, robot_data, urdf_path, urdf_text
from dressing_sim.world.robot import PANDA, Gripper, Robot, ServoConfig


def test_nothing_is_added_to_the_panda_s():
    """All that is published was computed with the description as it is installed."""
    installed = ET.tostring(ET.parse(urdf_path()).getroot(), encoding="unicode")
    assert urdf_text(PANDA) == installed


def test_a_missing_robot_description_is_an_error_that_says_what_to_install(monkeypatch):
    def missing(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(description, "distribution", missing)
    with pytest.raises(DressingSimError, match="install the package example-robot-data"):
        urdf_path()


def test_addresses_are_of_files_of_the_installed_package_and_of_packages_around(tmp_path):
    (tmp_path / "mine" / "urdf").mkdir(parents=True)
    mesh = tmp_path / "mine" / "a.stl"
    mesh.touch()
    folder = tmp_path / "mine" / "urdf"
    assert addressed("package://mine/a.stl", folder) == mesh
    assert addressed("../a.stl", folder).resolve() == mesh
    assert addressed(f"file://{mesh}", folder) == mesh
    assert addressed("package://example-robot-data/x", folder) == (
        robot_data() / "example-robot-data/x"
    )


def test_joints_that_nobody_names_stay_at_zero():
    """The Panda without servos of its fingers has them closed; without a joint it is locked."""
    q = np.array(PANDA.home)
    place = RobotKinematics().tcp_pose(q)[0]
    closed = RobotKinematics(replace(PANDA, fingers=())).tcp_pose(q)[0]
    np.testing.assert_allclose(closed, place, atol=1e-12)
    fewer = replace(
        PANDA,
        joints=PANDA.joints[:-1],
        home=PANDA.home[:-1],
        acceleration=PANDA.acceleration[:-1],
        servo=ServoConfig(PANDA.servo.stiffness[:-1], PANDA.servo.damping[:-1]),
    )
    np.testing.assert_allclose(RobotKinematics(fewer).tcp_pose(q[:-1])[0], place, atol=1e-9)
    assert len(joint_limits(fewer).lower) == 6


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"home": (0.0,) * 6}, "home has 6 numbers, valid is 7"),
        ({"servo": ServoConfig((1.0,) * 6, (1.0,) * 6)}, "servo has 6 numbers, valid is 7"),
        ({"acceleration": (0.0,) * 7}, "acceleration is .*, valid is a number > 0"),
        ({"joints": ()}, "joints are"),
        ({"fingers": PANDA.joints[:1]}, "valid is each of them once"),
        ({"base_position": (0.0, 0.0)}, "base_position has 2 numbers, valid is 3"),
        ({"base_position": (0.0, 0.0, np.nan)}, "base"),
        ({"gripper": 3}, "gripper is 3"),
    ],
)
def test_a_robot_that_cannot_be_meant_is_an_error_that_names_it(change, told):
    with pytest.raises(InvalidInputError, match=told):
        Robot(**change)


@pytest.mark.parametrize("size", [0.0, -1.0, np.nan, "x"])
def test_a_gripper_has_sizes(size):
    with pytest.raises(InvalidInputError, match="palm_length is"):
        Gripper("tool0", palm_length=size)
