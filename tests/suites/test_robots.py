"""Robots by file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from dressing_sim.cli import main
from dressing_sim.config import from_plain, to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets
from dressing_sim.suites.measures import Each, Measure, schema_table
from dressing_sim.suites.robots import NO_GRIP_SOURCE, ROBOT, load_robot, with_robot
from dressing_sim.world.description import joint_limits, urdf_path, urdf_text
from dressing_sim.world.robot import PANDA

PAGE = Path(__file__).resolve().parents[2] / "docs" / "measurements.md"

#: A robot of two joints and no shapes.
URDF = """<robot name="two">
  <link name="base"/><link name="tip"/>
  <link name="arm"><inertial><origin xyz="0 0 0"/><mass value="2"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="fist"><inertial><origin xyz="0 0 0"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
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


def test_a_file_says_how_hard_a_robot_holds_and_who_says_so(file):
    robot = load_robot(str(file))
    assert (robot.grip_strength, robot.grip_source) == (PANDA.grip_strength, NO_GRIP_SOURCE)
    file.write_text(TOML.replace("[base]", '[grip]\nstrength_n = 60\nsource = "a sheet"\n[base]'))
    robot = load_robot(str(file))
    assert (robot.grip_strength, robot.grip_source) == (60.0, "a sheet")
    assert load_robot("ur10").grip_strength == PANDA.grip_strength == 42.0


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
        (("[base]", "[grip]\nstrength_n = 60\n[base]"), "both grip.strength_n and grip.source"),
        (("[base]", "[grip]\nstrength_n = nan\nsource = 'x'\n[base]"), "grip.strength_n .* nan"),
        (("home_deg", "home_rad"), "unknown key 'joints.a.home_rad'; valid are joints.a.home_deg"),
        (("home_deg = 10", ""), "no joints.a.home_deg"),
        (("home_deg = 10", "home_deg = 175"), "joint a rests at 3.05433 rad, valid is -3 to 3"),
        (("= 100", "= -100"), r"joints.a.stiffness_n_m_per_rad \[N m/rad\] is -100"),
        (("[joints.a]", "[joints.x]"), "no joint 'x' in its URDF, valid are a, b, c"),
        (("[joints.a]", "[joints.c]"), "joints are c, b, valid is their order .*, b, c"),
        (("[joints.b]", "[joints.c]"), "joint c is 'prismatic' .*; valid is a revolute joint"),
        (("[joints.a]", "[joints.'']"), "joints: a name is ''"),
        (('"tip"', '"top"'), "no link 'top' in its URDF, valid are base, tip, arm, fist"),
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
        (('<link name="arm">', '<link name="head">'), "has a link 'head', valid is a name that"),
        (('lower="-3" upper="3"', 'lower="3" upper="-3"'), "lower 3, upper -3.*the lower below"),
        (('upper="3"', 'upper="1e300"'), r"upper 1e\+300.*none beyond 1e\+06"),
        (('upper="3"', 'upper="nan"'), "upper nan"),
        (('effort="50"', 'effort="inf"'), "effort inf"),
        (('xyz="0 0 0.1"', 'xyz="0 0 nan"'), "element origin with xyz '0 0 nan', valid is 3 num"),
        (('xyz="0 0 0.1"', 'xyz="0 0"'), "element origin with xyz '0 0', valid is 3 numbers"),
        (('xyz="0.4 0 0"', 'xyz="1e300 0 0"'), "xyz '1e300 0 0', valid is 3 numbers from -100"),
        (('value="2"', 'value="1e300"'), "element mass with value '1e300', valid is a number"),
        (('value="2"', 'value="two"'), "element mass with value 'two'"),
        (('value="2"', 'value="-2"'), "MuJoCo refuses"),
        (('ixx="0.1"', 'ixx="inf"'), "element inertia with ixx 'inf'"),
        (('ixx="0.1"', 'ixx="9"'), "MuJoCo refuses"),
        (('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>'), "MuJoCo refuses"),
        (
            (
                "</inertial>",
                '</inertial><collision><geometry><mesh filename="no.stl"/></geometry></collision>',
            ),
            "MuJoCo refuses",
        ),
        (
            ('<link name="base"/>', 3000 * "<a>" + 3000 * "</a>" + '<link name="base"/>'),
            "in a thousand others",
        ),
    ],
)
def test_a_urdf_that_is_none_is_refused_in_one_line(file, change, told):
    assert change[0] in URDF
    file.with_suffix(".urdf").write_text(URDF.replace(*change))
    with pytest.raises(InvalidInputError, match=told) as refused:
        load_robot(str(file))
    assert "\n" not in str(refused.value)


def test_a_robot_s_own_urdf_and_its_meshes_may_not_change_behind_a_run(file):
    robot = load_robot(str(file))
    assert load_robot(str(file)) == robot
    assert load_robot("ur10").urdf_checksum == ""  # the package's version stands for it
    file.with_suffix(".urdf").write_text(URDF.replace('effort="50"', 'effort="49"'))
    again = load_robot(str(file))
    assert again != robot
    np.testing.assert_array_equal(joint_limits(again).effort, [49.0, 49.0])
    of_the_run = from_plain(EpisodeConfig, to_plain(with_robot(EpisodeConfig(), str(file))))
    file.with_suffix(".urdf").write_text(URDF.replace('effort="50"', 'effort="48"'))
    urdf_text.cache_clear()
    with pytest.raises(InvalidInputError, match="is another than its config says") as refused:
        urdf_text(of_the_run.world.robot)
    assert "\n" not in str(refused.value)


BROKEN = {
    "limits swapped": ('lower="-3" upper="3"', 'lower="3" upper="-3"'),
    "no such joint": ('<joint name="b"', '<joint name="d"'),
    "nan": ('value="2"', 'value="nan"'),
    "drawn without a size": (
        '<link name="base"/>',
        '<link name="base"><visual><geometry><box/></geometry></visual></link>',
    ),
    "huge": ('xyz="0.4 0 0"', 'xyz="4e99 0 0"'),
}


@pytest.mark.parametrize("command", ["dress --posture bent10", "evaluate", "demonstrate case_a"])
@pytest.mark.parametrize("broken", [*BROKEN, "no urdf", "nan in the file", "no file"])
def test_a_broken_robot_is_one_line_and_exit_code_2_and_nothing_is_written(
    command, broken, file, monkeypatch, capfd
):
    monkeypatch.chdir(file.parent)
    urdf = file.with_suffix(".urdf")
    if broken in BROKEN:
        assert BROKEN[broken][0] in URDF
        urdf.write_text(URDF.replace(*BROKEN[broken]))
    elif broken == "no urdf":
        urdf.unlink()
    elif broken == "nan in the file":
        file.write_text(TOML.replace("home_deg = 10", "home_deg = nan"))
    else:
        file.unlink()
    before = {path: path.read_bytes() for path in file.parent.iterdir()}
    with pytest.raises(SystemExit) as stopped:
        main([*command.split(), "--robot", "two.toml"])
    told = capfd.readouterr()  # of libraries too
    assert stopped.value.code == 2
    assert told.err.startswith("dressing-sim: ")
    assert told.err.count("\n") == 1
    assert "two.toml" in told.err
    assert told.out == ""
    assert {path: path.read_bytes() for path in file.parent.iterdir()} == before


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
