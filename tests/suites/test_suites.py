import json

import numpy as np
import pytest

from dressing_sim import load_suite
from dressing_sim.arm import ANGLE_LIMITS_DEG, Posture, gravity_frame
from dressing_sim.control import RobotKinematics
from dressing_sim.errors import InvalidInputError
from dressing_sim.files import assets
from dressing_sim.learning.frame import Frame
from dressing_sim.learning.sampling import rotation
from dressing_sim.suites.distribution import PostureDistribution, reachable
from dressing_sim.suites.drawn import DRAWN_SUITES
from dressing_sim.suites.suites import find_posture, situation_distance, suite_names, write_suite

KINEMATICS = RobotKinematics()
CLEARANCE = PostureDistribution().shoulder_clearance
ARM = {"name": "one", "flexion_deg": 70, "abduction_deg": 20, "rotation_deg": 30, "elbow_deg": 40}
MOST_CHECKED = 15


def written(folder, content):
    path = folder / "suite.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return str(path)


def test_there_are_the_suites_of_the_paper_and_larger_ones():
    sizes = {name: len(load_suite(name)) for name in suite_names()}
    assert sizes == {
        "paper5": 5,
        "case_a": 2,
        "case_b": 2,
        "baseline7": 7,
        "val50": 50,
        "test200": 200,
        "hard_elbow": 50,
        "train200": 200,
        "moving": 50,
        "compliant": 50,
    }


@pytest.mark.parametrize("suite", suite_names())
def test_the_robot_reaches_the_postures_of_a_built_in_suite(suite):
    """All of the small suites, and of the large ones some, chosen by a seed."""
    postures = load_suite(suite)
    chosen = np.random.default_rng(0).permutation(len(postures))[:MOST_CHECKED]
    for posture in (postures[i] for i in chosen):
        assert reachable(posture, KINEMATICS, CLEARANCE), posture


@pytest.mark.parametrize("suite", suite_names())
def test_a_built_in_suite_says_its_name_its_version_and_what_it_is_for(suite):
    content = json.loads((assets() / "suites" / f"{suite}.json").read_text(encoding="utf-8"))
    assert (content["name"], content["version"]) == (suite, 1)
    assert content["description"].endswith(".")


def test_a_name_is_one_posture_in_all_built_in_suites():
    postures = [posture for suite in suite_names() for posture in load_suite(suite)]
    assert len({posture.name for posture in postures}) == len(postures)


@pytest.mark.parametrize("suite", DRAWN_SUITES)
def test_a_drawn_suite_is_what_its_seed_draws_to_the_last_digit(suite):
    drawn, postures = DRAWN_SUITES[suite], load_suite(suite)
    assert len(postures) == drawn.n_postures
    first = 1 if drawn.motions else 3  # an arm that moves must be reached in many places
    assert postures[:first] == drawn.postures(first)
    content = json.loads((assets() / "suites" / f"{suite}.json").read_text(encoding="utf-8"))
    header = json.loads(json.dumps(drawn.header()))
    assert {key: content[key] for key in header} == header


@pytest.mark.parametrize("suite", DRAWN_SUITES)
def test_a_drawn_suite_keeps_to_its_ranges(suite):
    ranges = DRAWN_SUITES[suite].distribution
    for posture in load_suite(suite):
        for angle in ANGLE_LIMITS_DEG:
            low, high = getattr(ranges, angle)
            assert low <= getattr(posture, angle) <= high
        assert posture.size in ranges.sizes
    assert {posture.size for posture in load_suite(suite)} == set(ranges.sizes)


def test_a_suite_that_is_written_is_read_again_unchanged(tmp_path):
    path = tmp_path / "own.json"
    postures = load_suite("paper5")
    write_suite(path, "own", postures, {"description": "Mine."})
    assert load_suite(str(path)) == postures
    content = json.loads(path.read_text())
    assert (content["name"], content["version"], content["description"]) == ("own", 1, "Mine.")


def test_the_first_two_of_seven_are_case_a_and_each_next_one_fills_the_largest_gap():
    postures, ranges = load_suite("baseline7"), PostureDistribution()
    widths = [np.diff(getattr(ranges, angle))[0] for angle in ANGLE_LIMITS_DEG]
    angles = np.array([[getattr(p, a) for a in ANGLE_LIMITS_DEG] for p in postures]) / widths
    apart = np.linalg.norm(angles[:, None] - angles[None], axis=-1)
    for n in range(2, len(postures)):
        gaps = apart[n:, :n].min(axis=1)
        assert gaps[0] == gaps.max()
    for shown, first in zip(load_suite("case_a"), postures[:2], strict=True):
        np.testing.assert_array_equal(shown.wrist, first.wrist)
        np.testing.assert_array_equal(shown.elbow, first.elbow)


def test_the_situations_of_case_a_are_further_apart_than_those_of_case_b():
    a, b = (
        situation_distance(*(posture.frames() for posture in load_suite(suite)))
        for suite in ("case_a", "case_b")
    )
    assert a.origins[0] == b.origins[0] == 0.0  # one shoulder for all
    assert a.origins[1] > 1.5 * b.origins[1]
    assert (a.rotation_deg > 3.0 * b.rotation_deg).all()
    np.testing.assert_allclose(a.euler_deg[:, 0], 0.0, atol=1e-9)
    assert (np.abs(a.euler_deg[:, 1:]) > np.abs(b.euler_deg[:, 1:])).all()


def test_the_distance_of_situations_is_that_of_origins_and_of_euler_angles():
    one = (Frame(rotation([0.0, 0.0, 3.0]), [0.0, 0.0, 0.0]), Frame(np.eye(3), [1.0, 2.0, 3.0]))
    other = (
        Frame(rotation([0.0, 0.0, -3.0]), [0.0, 3.0, 4.0]),
        Frame(rotation([0.1, 0.2, 0.3]), [1.0, 2.0, 3.0]),
    )
    apart = situation_distance(one, other)
    np.testing.assert_allclose(apart.origins, [5.0, 0.0])
    turn = 2.0 * np.pi - 6.0  # the short way round
    np.testing.assert_allclose(
        apart.euler_deg, np.rad2deg([[0.0, 0.0, turn], [0.1, 0.2, 0.3]]), atol=1e-9
    )
    np.testing.assert_allclose(apart.rotation_deg[0], np.rad2deg(turn))
    back = situation_distance(other, one)
    np.testing.assert_allclose(back.euler_deg, -apart.euler_deg, atol=1e-9)
    np.testing.assert_allclose(back.rotation_deg, apart.rotation_deg)
    assert (situation_distance(one, one).rotation_deg == 0.0).all()


def test_situations_of_different_length_have_no_distance():
    frames = load_suite("paper5")[0].frames()
    for one, other in ((frames, frames[:1]), ((), ())):
        with pytest.raises(InvalidInputError, match="valid is the same number"):
            situation_distance(one, other)


def test_frames_of_an_arm_do_not_roll():
    rng = np.random.default_rng(0)
    level = gravity_frame(np.zeros(3), np.array([1.0, 0.0, 0.0]))
    for _ in range(20):
        frame = gravity_frame(rng.normal(size=3), rng.normal(size=3))
        assert abs(situation_distance([level], [frame]).euler_deg[0, 0]) < 1e-9


def test_a_suite_can_be_a_file(tmp_path):
    path = written(tmp_path, {"postures": [ARM, ARM | {"name": "two", "size": "female"}]})
    one, two = load_suite(path)
    assert one == Posture("one", 70, 20, 30, 40)
    assert (two.name, two.size) == ("two", "female")


def test_the_first_of_a_suite_are_a_suite_too(tmp_path):
    assert load_suite("val50:3") == load_suite("val50")[:3]
    path = tmp_path / "own.json"
    path.write_text(json.dumps({"postures": [ARM, {**ARM, "name": "two"}]}))
    assert [posture.name for posture in load_suite(f"{path}:1")] == ["one"]
    with pytest.raises(InvalidInputError, match="valid is 1 to 50 postures of suite 'val50'"):
        load_suite("val50:51")
    # A file of such a name is itself.
    colon = tmp_path / "own.json:1"
    colon.write_text(json.dumps({"postures": [{**ARM, "name": "three"}]}))
    assert [posture.name for posture in load_suite(str(colon))] == ["three"]


@pytest.mark.parametrize(
    "name", ["nope", "", "random", "random:", "random:0", "random:-1", "random:x", "random:1:2:3",
             "random:1.5", "random:2:", "random:2:-1", "random:2:x", "random:100000",
             "random:" + "9" * 5000, "random:2:" + "9" * 5000, ".", "x" * 300],
)  # fmt: skip
def test_an_unknown_suite_is_an_error_that_says_what_is_valid(name):
    with pytest.raises(InvalidInputError, match=r"valid is .*random:N") as caught:
        load_suite(name)
    assert repr(name)[1:40] in str(caught.value)


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ("{", "not JSON"),
        ("\x00", "not JSON"),
        ("[" * 100_000, "not JSON"),
        ("9" * 5000, "not JSON"),
        ([], "no postures"),
        ({}, "no postures"),
        ({"postures": []}, "no postures"),
        ({"postures": "one"}, "no postures"),
        ({"postures": [ARM, ARM]}, "'one' occurs twice"),
        ({"version": 2, "postures": [ARM]}, "version is 2, valid is 1"),
        ({"version": "1", "postures": [ARM]}, "version is '1', valid is 1"),
        ({"version": True, "postures": [ARM]}, "version is True, valid is 1"),
        ({"version": None, "postures": [ARM]}, "version is None, valid is 1"),
        ({"postures": [ARM | {"elbow_deg": 200}]}, "elbow_deg is 200"),
        ({"postures": [ARM | {"elbow_deg": "40"}]}, "elbow_deg is '40'"),
        ({"postures": [ARM | {"shoulder_position": "mid"}]}, "shoulder_position is 'mid'"),
        ({"postures": [ARM | {"elbow_deg": float("nan")}]}, "the number NaN is not finite"),
        ('{"postures": [], "postures": []}', "'postures'"),
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
    assert find_posture("70,30,40,50,male_large").size == "male_large"
    assert find_posture("test199") == load_suite("test200")[199]


def test_a_posture_of_a_random_suite_or_of_a_file_is_found_too(tmp_path):
    assert find_posture("random3-4") == load_suite("random:9:3")[4]
    assert find_posture("random0-0") == load_suite("random:1")[0]
    file = written(tmp_path, {"postures": [ARM, ARM | {"name": "other", "elbow_deg": 31}]})
    assert find_posture(f"{file}:other") == load_suite(file)[1]
    with pytest.raises(InvalidInputError, match="no posture 'third'; valid is one of one, other"):
        find_posture(f"{file}:third")
    with pytest.raises(InvalidInputError, match="unknown posture"):
        find_posture(f"{file}.txt:other")


def test_the_names_of_a_large_suite_are_not_all_listed():
    with pytest.raises(InvalidInputError, match="test000 to test199") as caught:
        find_posture("test200")
    assert "test001" not in str(caught.value)


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
