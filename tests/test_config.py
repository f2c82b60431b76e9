import json
from dataclasses import dataclass, field, replace
from math import inf, nan

import pytest

from dressing_sim.config import from_plain, to_plain
from dressing_sim.control import TrackingConfig
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import OperatorConfig
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.world.robot import PANDA, ServoConfig
from dressing_sim.world.scene import SolverConfig, WorldConfig


@dataclass(frozen=True)
class Inner:
    size: float = 1.0
    numbers: tuple[float, ...] = (1.0, 2.0)


@dataclass(frozen=True)
class Outer:
    inner: Inner = field(default_factory=Inner)
    name: str = "cloth"


@pytest.mark.parametrize(
    "config",
    [Outer(Inner(3.5, (4.0, 5.0)), "silk"), EpisodeConfig(hold=0.3), OperatorConfig(speed=0.2)],
)
def test_settings_go_through_json_unchanged(config):
    assert from_plain(type(config), json.loads(json.dumps(to_plain(config)))) == config


def test_plain_values_are_nested_as_the_settings_are():
    plain = {"inner": {"size": 1.0, "numbers": [1.0, 2.0]}, "name": "cloth"}
    assert to_plain(Outer()) == plain


def test_what_is_not_said_keeps_its_default():
    assert from_plain(Outer, {"inner": {"size": 2.0}}) == Outer(Inner(2.0))


@pytest.mark.parametrize(
    ("values", "parts"),
    [
        ({"colour": "red"}, ["Outer", "colour", "inner, name"]),
        ({"inner": {"weight": 1}}, ["Inner", "weight", "size, numbers"]),
    ],
)
def test_an_unknown_setting_is_an_error_that_names_it_and_the_valid_ones(values, parts):
    with pytest.raises(InvalidInputError) as caught:
        from_plain(Outer, values)
    assert all(part in str(caught.value) for part in parts)


@pytest.mark.parametrize(
    ("kind", "values", "told"),
    [
        (Outer, {"name": 3}, "Outer: name is 3, valid is a text"),
        (Outer, {"inner": {"size": "3"}}, "Inner: size is '3', valid is a number"),
        (Outer, {"inner": {"size": True}}, "Inner: size is True, valid is a number"),
        (Outer, {"inner": {"numbers": 3.0}}, "Inner: numbers is 3.0, valid is a list"),
        (Outer, {"inner": {"numbers": [1.0, "x"]}}, "Inner: numbers is 'x', valid is a number"),
        (EpisodeConfig, {"protective_stop": "no"}, "protective_stop is 'no', valid is true or f"),
        (EpisodeConfig, {"protective_stop": 1}, "protective_stop is 1, valid is true or false"),
        (SolverConfig, {"iterations": 1.5}, "iterations is 1.5, valid is a whole number"),
    ],
)
def test_a_value_of_another_kind_is_an_error_that_names_the_setting(kind, values, told):
    with pytest.raises(InvalidInputError) as caught:
        from_plain(kind, values)
    assert told in str(caught.value)


@pytest.mark.parametrize(
    ("kind", "name", "value"),
    [
        *((TrackingConfig, "max_speed", value) for value in (0.0, -0.25, inf, nan)),
        (TrackingConfig, "smoothing", -1.0),
        (TrackingConfig, "max_error", nan),
        (OperatorConfig, "speed", -0.1),
        (OperatorConfig, "tremor", nan),
        (OperatorConfig, "height_variation", -0.1),
        (OperatorConfig, "overshoot", inf),
        (ServoConfig, "stiffness", (4500.0,) * 6),
        (ServoConfig, "damping", (1.0,) * 6 + (0.0,)),
        (ServoConfig, "finger_force", -1.0),
        (Thresholds, "strain", nan),
        (Thresholds, "strain_percentile", 950.0),
        (Thresholds, "moment", -1.0),
        (Thresholds, "hold_time", nan),
        (EpisodeConfig, "hold", inf),
        (EpisodeConfig, "time_limit", inf),
    ],
)
def test_a_number_that_cannot_be_meant_is_an_error_that_names_it(kind, name, value):
    with pytest.raises(InvalidInputError, match=f"{name} is .*, valid is"):
        kind(**{name: value})


@pytest.mark.parametrize("values", [5, {"inner": 5}])
def test_values_that_are_not_settings_are_an_error(values):
    with pytest.raises(InvalidInputError):
        from_plain(Outer, values)


def test_a_limit_may_be_switched_off_and_a_robot_need_not_be_drawn_to_its_rest():
    limits = dict.fromkeys(("strain", "grip_force", "link_force", "gripper_distance"), inf)
    assert Thresholds(**limits).grip_force == inf
    assert TrackingConfig(posture_cost=0.0).posture_cost == 0.0


def test_the_grip_stands_where_files_have_always_had_it_though_it_is_the_robot_s():
    world = to_plain(WorldConfig())
    assert list(world)[-1] == "grip_strength"
    assert world["grip_strength"] == 42.0
    assert not {"grip_strength", "grip_source", "urdf_checksum"} & set(world["robot"])
    strong = replace(PANDA, grip_strength=60.0, grip_source="data sheet")
    told = to_plain(WorldConfig(robot=strong))
    assert (told["grip_strength"], told["robot"]["grip_source"]) == (60.0, "data sheet")
    assert from_plain(WorldConfig, json.loads(json.dumps(told))).robot == strong
    assert from_plain(WorldConfig, {**world, "grip_strength": 7.0}).robot.grip_strength == 7.0


def test_files_of_before_robots_were_data_are_read():
    old = to_plain(EpisodeConfig())
    servo = {**old["world"].pop("robot")["servo"], "finger_force": 60.0}
    old["world"]["servo"] = servo
    robot = from_plain(EpisodeConfig, json.loads(json.dumps(old))).world.robot
    assert robot == replace(PANDA, servo=replace(PANDA.servo, finger_force=60.0))
    with pytest.raises(InvalidInputError, match="unknown setting servo"):
        from_plain(WorldConfig, {"robot": 3, "servo": servo})
