"""Robots by file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dressing_sim.config import from_plain, to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets
from dressing_sim.suites.measures import Each, Measure, schema_table
from dressing_sim.suites.robots import ROBOT, load_robot, with_robot
from dressing_sim.world.description import joint_limits, urdf_path
from dressing_sim.world.robot import PANDA

PAGE = Path(__file__).resolve().parents[2] / "docs" / "measurements.md"

#: A robot of two joints and no shapes.
URDF = """<robot name="two">
  <link name="base"/><link name="arm"/><link name="fist"/><link name="tip"/>
  <joint name="a" type="revolute">
    <parent link="base"/><child link="arm"/><origin xyz="0 0 0.1"/><axis xyz="0 0 1"/>
    <limit lower="-3" upper="3" velocity="2" effort="50"/>
  </joint>
  <joint name="b" type="revolute">
    <parent link="arm"/><child link="fist"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/>
    <limit lower="-3" upper="3" velocity="2" effort="50"/>
  </joint>
  <joint name="c" type="prismatic">
    <parent link="fist"/><child link="tip"/><origin xyz="0.2 0 0" rpy="0 1.5707963 0"/>
    <axis xyz="0 0 1"/><limit lower="0" upper="0.1" velocity="1" effort="10"/>
  </joint>
</robot>"""

_JOINT = """
home_deg = 10
stiffness_n_m_per_rad = 100
damping_n_m_s_per_rad = 10
acceleration_rad_per_s2 = 5
"""

TOML = f"""
name = "two"
urdf = "two.urdf"
tool = "tip"
[base]
y_m = 0.1
yaw_deg = 90
[joints.a]{_JOINT}
[joints.b]{_JOINT}
"""


@pytest.fixture
def file(tmp_path):
    """A robot's file, its URDF beside it."""
    (tmp_path / "two.urdf").write_text(URDF)
    path = tmp_path / "two.toml"
    path.write_text(TOML)
    return path


def test_a_file_says_what_a_robot_is(file):
    robot = load_robot(str(file))
    assert (robot.name, robot.joints, robot.fingers, robot.tool) == ("two", ("a", "b"), (), "tip")
    assert urdf_path(robot) == file.with_suffix(".urdf").resolve()
    assert robot.servo.stiffness == (100.0, 100.0)
    assert robot.servo.armature == PANDA.servo.armature
    np.testing.assert_allclose(robot.home, np.deg2rad([10.0, 10.0]))
    assert robot.base_position == (0.0, 0.1, 0.0)
    assert robot.base_yaw == pytest.approx(np.pi / 2.0)
    np.testing.assert_array_equal(joint_limits(robot).effort, [50.0, 50.0])


def test_a_run_s_settings_hold_the_robot(file):
    config = with_robot(EpisodeConfig(), str(file))
    assert config.world == replace(EpisodeConfig().world, robot=load_robot(str(file)))
    assert from_plain(EpisodeConfig, to_plain(config)) == config
    assert with_robot(config, None) is config
    assert with_robot(config, "panda") == EpisodeConfig()


@pytest.mark.parametrize("path", sorted((assets() / "robots").glob("*.toml")), ids=lambda p: p.stem)
def test_robots_that_come_along_can_be_loaded(path):
    assert load_robot(path.stem) == load_robot(str(path))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("name =", "called ="), "unknown key 'called'; valid are name, urdf, tool"),
        (('name = "two"', ""), "no name; valid is a robot's name, urdf and joints"),
        (('tool = "tip"', ""), "valid is either tool"),
        (("[base]", "[gripper]\nflange = 'fist'\n[base]"), "valid is either tool"),
        (("home_deg", "home_rad"), "unknown key 'joints.a.home_rad'; valid are joints.a.home_deg"),
        (("home_deg = 10", ""), "no joints.a.home_deg"),
        (("home_deg = 10", "home_deg = 175"), "joint a rests at 3.05433 rad, valid is -3 to 3"),
        (("= 100", "= -100"), r"joints.a.stiffness_n_m_per_rad \[N m/rad\] is -100"),
        (("[joints.a]", "[joints.x]"), "no joint 'x' in its URDF, valid are a, b, c"),
        (("[joints.a]", "[joints.c]"), "joints are c, b, valid is their order .*, b, c"),
        (("[joints.b]", "[joints.c]"), "joint c is 'prismatic' .*; valid is a revolute joint"),
        (("[joints.a]", "[joints.'']"), "joints: a name is ''"),
        (('"tip"', '"top"'), "no link 'top' in its URDF, valid are base, arm, fist, tip"),
        (("two.urdf", "three.urdf"), "three.urdf is missing, valid is a URDF file"),
        (("y_m = 0.1", "y_m = 30"), r"base.y_m \[m\] is 30, valid is a number from -2 to 2"),
    ],
)
def test_a_robot_that_is_none_is_refused_in_one_line(file, change, told):
    assert change[0] in TOML
    file.write_text(TOML.replace(*change))
    with pytest.raises(InvalidInputError, match=told) as refused:
        load_robot(str(file))
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(f"robot {file}: ")


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("<robot", "<robot <"), "is no URDF"),
        (('effort="50"', ""), "joint a is 'revolute' with the limits .* effort nan; valid is"),
        (('upper="3"', 'upper="-3"'), "upper -3"),
        (('velocity="2"', 'velocity="fast"'), "velocity nan"),
        (('<link name="arm"/>', '<link name="head"/>'), "has a link 'head', valid is a name that"),
    ],
)
def test_a_urdf_that_is_none_is_refused_in_one_line(file, change, told):
    assert change[0] in URDF
    file.with_suffix(".urdf").write_text(URDF.replace(*change))
    with pytest.raises(InvalidInputError, match=told) as refused:
        load_robot(str(file))
    assert "\n" not in str(refused.value)


def test_there_is_no_such_robot():
    with pytest.raises(InvalidInputError, match="unknown robot 'x'; valid is one of panda, ur10"):
        load_robot("x")


def test_every_key_names_its_unit_and_the_page_has_it():
    text = PAGE.read_text(encoding="utf-8")
    for line in schema_table(ROBOT):
        assert line in text, line

    def keys(part):
        for key, wanted in part.items():
            if isinstance(wanted, Measure):
                yield key, wanted.unit
            elif not hasattr(wanted, "what"):
                yield from keys(wanted.schema if isinstance(wanted, Each) else wanted)

    for key, unit in keys(ROBOT):
        spelled = unit.replace("^", "").replace("/", " per ").replace(" ", "_")
        assert key.lower().endswith(f"_{spelled.lower()}"), key
