import json

import numpy as np
import pytest

from dressing_sim import load_suite, sample_postures
from dressing_sim.arm import ARM_SIZES, DEFAULT_SHOULDER, Posture
from dressing_sim.benchmark.suites import (
    PostureDistribution,
    find_posture,
    reachable,
    suite_names,
)
from dressing_sim.control import PandaKinematics
from dressing_sim.errors import InvalidInputError

KINEMATICS = PandaKinematics()
CLEARANCE = PostureDistribution().shoulder_clearance
ARM = {"name": "one", "flexion_deg": 70, "abduction_deg": 20, "rotation_deg": 30, "elbow_deg": 40}


@pytest.fixture(scope="module")
def random_postures():
    return load_suite("random:8")


def written(folder, content):
    path = folder / "suite.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return str(path)


def test_there_are_the_suites_of_the_paper():
    assert {"paper5", "case_a", "case_b", "baseline7"} <= set(suite_names())
    sizes = {name: len(load_suite(name)) for name in suite_names()}
    assert (sizes["paper5"], sizes["case_a"], sizes["case_b"], sizes["baseline7"]) == (5, 2, 2, 7)


@pytest.mark.parametrize("suite", suite_names())
def test_the_robot_reaches_every_posture_of_a_built_in_suite(suite):
    for posture in load_suite(suite):
        assert reachable(posture, KINEMATICS, CLEARANCE), posture


def test_a_name_is_one_posture_in_all_built_in_suites():
    postures = [posture for suite in suite_names() for posture in load_suite(suite)]
    assert len({posture.name for posture in postures}) == len(postures)


def test_the_two_postures_of_case_a_are_further_apart_than_those_of_case_b():
    def apart(suite):
        one, other = load_suite(suite)
        return np.linalg.norm(one.wrist - other.wrist), abs(one.elbow_deg - other.elbow_deg)

    assert all(a > b for a, b in zip(apart("case_a"), apart("case_b"), strict=True))


def test_random_postures_are_a_matter_of_the_seed(random_postures):
    assert load_suite("random:3") == random_postures[:3]
    assert load_suite("random:3:0") == random_postures[:3]
    assert load_suite("random:3:1") != random_postures[:3]


def test_random_postures_come_from_the_distribution_and_can_be_reached(random_postures):
    ranges = PostureDistribution()
    for posture in random_postures:
        for angle in ("flexion_deg", "abduction_deg", "rotation_deg", "elbow_deg"):
            low, high = getattr(ranges, angle)
            assert low <= getattr(posture, angle) <= high
        shift = np.abs(posture.shoulder - DEFAULT_SHOULDER)
        assert shift.max() <= ranges.shoulder_displacement + 1e-12
        assert np.hypot(*posture.wrist[:2]) >= ranges.min_wrist_distance
        rise = abs(posture.wrist[2] - posture.elbow[2]) / posture.arm_size.forearm_length
        assert np.rad2deg(np.arcsin(rise)) <= ranges.max_forearm_slope_deg + 1e-9
        assert reachable(posture, KINEMATICS, ranges.shoulder_clearance)
    assert {posture.size for posture in random_postures} == set(ARM_SIZES)
    assert [posture.name for posture in random_postures] == [f"random{i}" for i in range(8)]


def test_the_generator_alone_decides_what_is_drawn():
    np.random.seed(1)  # noqa: NPY002
    one = sample_postures(2, np.random.default_rng(7))
    np.random.seed(2)  # noqa: NPY002
    assert sample_postures(2, np.random.default_rng(7)) == one
    assert sample_postures(0, np.random.default_rng(7)) == []


def test_an_arm_out_of_reach_is_not_reachable():
    assert not reachable(Posture("back", -60, 0, 0, 0), KINEMATICS, CLEARANCE)
    assert not reachable(Posture("high", 75, 20, 40, 10), KINEMATICS, clearance=1.0)


def test_a_suite_can_be_a_file(tmp_path):
    path = written(tmp_path, {"postures": [ARM, ARM | {"name": "two", "size": "female"}]})
    one, two = load_suite(path)
    assert one == Posture("one", 70, 20, 30, 40)
    assert (two.name, two.size) == ("two", "female")


@pytest.mark.parametrize(
    "name", ["nope", "", "random", "random:", "random:0", "random:-1", "random:x", "random:1:2:3",
             "random:1.5", "random:2:", ".", "x" * 300],
)  # fmt: skip
def test_an_unknown_suite_is_an_error_that_says_what_is_valid(name):
    with pytest.raises(InvalidInputError, match=r"valid is .*random:N") as caught:
        load_suite(name)
    assert repr(name) in str(caught.value)


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ("{", "not JSON"),
        ("\x00", "not JSON"),
        ([], "no postures"),
        ({}, "no postures"),
        ({"postures": []}, "no postures"),
        ({"postures": "one"}, "no postures"),
        ({"postures": [ARM, ARM]}, "'one' occurs twice"),
        ({"postures": [ARM | {"elbow_deg": 200}]}, "elbow_deg is 200"),
        ({"postures": [ARM | {"elbow_deg": float("nan")}]}, "elbow_deg is nan"),
        ({"postures": [ARM | {"elbow": 20}]}, "unknown ['elbow']"),
        ({"postures": [5]}, "missing"),
        ({"postures": [{"name": "half"}]}, "'half': missing"),
    ],
)
def test_a_bad_file_is_an_error_that_says_what_is_wrong(tmp_path, content, part):
    with pytest.raises(InvalidInputError) as caught:
        load_suite(written(tmp_path, content))
    assert part in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_file_that_is_no_text_is_an_error(tmp_path):
    (tmp_path / "suite.json").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InvalidInputError, match="not JSON"):
        load_suite(str(tmp_path / "suite.json"))


def test_a_posture_is_found_by_its_name_or_its_angles():
    posture = load_suite("paper5")[0]
    assert find_posture(posture.name) == posture
    assert find_posture("70,30,40,50").elbow_deg == 50.0
    assert find_posture("70,30,40,50").size == "male"
    assert find_posture("70, -30.5, 40, 50,female").abduction_deg == -30.5
    assert find_posture("70,30,40,50,female").size == "female"


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("nobody", "bent10"),
        ("", "bent10"),
        ("1,2,3", "FLEXION,ABDUCTION,ROTATION,ELBOW"),
        ("1,2,3,x", "FLEXION,ABDUCTION,ROTATION,ELBOW"),
        ("1,2,3,4,male,5", "FLEXION,ABDUCTION,ROTATION,ELBOW"),
        ("1,2,3,4,child", "male, female"),
        ("1,2,3,nan", "elbow_deg is nan"),
        ("1,2,3,151", "0 to 150"),
    ],
)
def test_an_unknown_posture_is_an_error_that_says_what_is_valid(name, part):
    with pytest.raises(InvalidInputError) as caught:
        find_posture(name)
    assert part in str(caught.value)
    assert repr(name) in str(caught.value)
