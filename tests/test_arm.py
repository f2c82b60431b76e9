import json
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressing_sim.arm import (
    ANGLE_LIMITS_DEG,
    ARM_SIZES,
    ARM_VARIATION,
    DEFAULT_SHOULDER,
    FORWARD,
    LEFT,
    MAX_SHOULDER_DISPLACEMENT,
    UP,
    Posture,
    gravity_frame,
)
from dressing_sim.errors import InvalidInputError

HANGING = Posture("hanging", 0, 0, 0, 0)
RANGE = f"+- {MAX_SHOULDER_DISPLACEMENT:g} m"

shifts = st.floats(-0.99 * MAX_SHOULDER_DISPLACEMENT, 0.99 * MAX_SHOULDER_DISPLACEMENT)
postures = st.builds(
    Posture,
    name=st.text(),
    size=st.sampled_from(sorted(ARM_SIZES)),
    shoulder_position=st.tuples(shifts, shifts, shifts).map(
        lambda shift: tuple(np.add(DEFAULT_SHOULDER, shift).tolist())
    ),
    **{angle: st.floats(*limits) for angle, limits in ANGLE_LIMITS_DEG.items()},
)


@given(postures)
def test_any_posture_keeps_the_lengths_and_bends_the_elbow_as_told(posture):
    upper, fore = posture.elbow - posture.shoulder, posture.wrist - posture.elbow
    assert np.linalg.norm(upper) == pytest.approx(posture.arm_size.upper_arm_length)
    assert np.linalg.norm(fore) == pytest.approx(posture.arm_size.forearm_length)
    cosine = upper @ fore / np.linalg.norm(upper) / np.linalg.norm(fore)
    assert cosine == pytest.approx(np.cos(np.deg2rad(posture.elbow_deg)), abs=1e-9)


@given(postures)
def test_frames_are_right_handed_at_shoulder_and_wrist_with_x_to_the_elbow_and_z_up(posture):
    for frame, origin in zip(posture.frames(), (posture.shoulder, posture.wrist), strict=True):
        np.testing.assert_array_equal(frame.b, origin)
        np.testing.assert_allclose(frame.A.T @ frame.A, np.eye(3), atol=1e-9)
        assert np.linalg.det(frame.A) == pytest.approx(1.0)
        to_elbow = (posture.elbow - origin) / np.linalg.norm(posture.elbow - origin)
        np.testing.assert_allclose(frame.A[:, 0], to_elbow, atol=1e-9)
        if np.linalg.norm(np.cross(to_elbow, UP)) > 0.02:  # not vertical
            assert frame.A[:, 2] @ UP > 0.0
            assert abs(frame.A[:, 1] @ UP) < 1e-9


@given(postures)
def test_a_posture_goes_through_json_unchanged(posture):
    again = Posture.from_dict(json.loads(json.dumps(posture.to_dict())))
    assert again == posture
    np.testing.assert_array_equal(again.wrist, posture.wrist)


def test_with_all_angles_zero_the_arm_hangs_from_the_shoulder():
    size = HANGING.arm_size
    np.testing.assert_allclose(HANGING.shoulder, DEFAULT_SHOULDER)
    np.testing.assert_allclose(HANGING.elbow, HANGING.shoulder - size.upper_arm_length * UP)
    np.testing.assert_allclose(HANGING.wrist, HANGING.elbow - size.forearm_length * UP)


@pytest.mark.parametrize(
    ("angles", "upper_arm", "forearm"),
    [
        ({"flexion_deg": 90}, FORWARD, FORWARD),
        ({"flexion_deg": -60}, -np.sqrt(0.75) * FORWARD - 0.5 * UP, None),
        ({"flexion_deg": 180}, UP, UP),
        ({"abduction_deg": 90}, LEFT, LEFT),
        ({"elbow_deg": 90}, -UP, FORWARD),
        ({"elbow_deg": 90, "flexion_deg": 90}, FORWARD, UP),
        ({"elbow_deg": 90, "abduction_deg": 90}, LEFT, FORWARD),
    ],
)
def test_angles_turn_the_arm_as_in_anatomy(angles, upper_arm, forearm):
    posture = replace(HANGING, **angles)
    size = posture.arm_size
    np.testing.assert_allclose(
        posture.elbow - posture.shoulder, size.upper_arm_length * upper_arm, atol=1e-12
    )
    if forearm is not None:
        np.testing.assert_allclose(
            posture.wrist - posture.elbow, size.forearm_length * forearm, atol=1e-12
        )


def test_internal_rotation_turns_the_hand_of_the_left_arm_to_the_right():
    bent = replace(HANGING, elbow_deg=90)
    inwards, outwards = replace(bent, rotation_deg=60), replace(bent, rotation_deg=-60)
    assert (inwards.wrist - bent.wrist) @ LEFT < -0.1
    assert (outwards.wrist - bent.wrist) @ LEFT > 0.1
    np.testing.assert_allclose(inwards.elbow, bent.elbow)


@pytest.mark.parametrize("target", [UP, -UP, UP + 1e-4 * LEFT])
def test_a_vertical_axis_still_has_a_frame(target):
    frame = gravity_frame(np.array([1.0, 2.0, 3.0]), np.array([1.0, 2.0, 3.0]) + target)
    np.testing.assert_allclose(frame.A.T @ frame.A, np.eye(3), atol=1e-9)
    assert frame.A[:, 2] @ FORWARD > 0.99


@pytest.mark.parametrize("angle", ANGLE_LIMITS_DEG)
@pytest.mark.parametrize("bad", ["below", "above", "nan"])
def test_an_impossible_angle_is_an_error_that_names_it_and_its_range(angle, bad):
    low, high = ANGLE_LIMITS_DEG[angle]
    value = {"below": low - 0.1, "above": high + 0.1, "nan": np.nan}[bad]
    with pytest.raises(InvalidInputError) as caught:
        replace(HANGING, name="odd", **{angle: value})
    message = str(caught.value)
    assert all(part in message for part in ("'odd'", angle, f"{low:g} to {high:g}"))
    assert "\n" not in message


@pytest.mark.parametrize("sign", [-1, 1])
@pytest.mark.parametrize("axis", range(3))
def test_the_ends_of_the_shoulder_s_range_are_valid(axis, sign):
    place = list(HANGING.shoulder_position)
    place[axis] = round(place[axis] + sign * MAX_SHOULDER_DISPLACEMENT, 6)
    assert replace(HANGING, shoulder_position=place).shoulder_position == tuple(place)


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"size": "child"}, ["'child'", *ARM_SIZES]),
        ({"size": ["male"]}, ["['male']", *ARM_SIZES]),
        (
            {"shoulder_position": (0.52, -0.26, 1.0)},
            ["shoulder_position", f"{MAX_SHOULDER_DISPLACEMENT:g}"],
        ),
        (
            {"shoulder_position": (0.52, np.nan, 0.24)},
            ["shoulder_position", f"{MAX_SHOULDER_DISPLACEMENT:g}"],
        ),
        ({"shoulder_position": (0.52, -0.26)}, ["shoulder_position"]),
        ({"shoulder_position": "far"}, ["shoulder_position is 'far'"]),
        ({"shoulder_position": None}, ["shoulder_position is None"]),
        ({"shoulder_position": ("0.52", -0.26, 0.24)}, ["shoulder_position is ('0.52'"]),
        ({"shoulder_position": [[0.52], [-0.26, 0.24]]}, ["shoulder_position is [[0.52]"]),
        ({"elbow_deg": "40"}, ["elbow_deg is '40'", "0 to 150, a number"]),
        ({"elbow_deg": None}, ["elbow_deg is None"]),
        ({"elbow_deg": [40.0]}, ["elbow_deg is [40.0]"]),
        ({"elbow_deg": True}, ["elbow_deg is True"]),
        ({"elbow_deg": 1j}, ["elbow_deg is 1j"]),
    ],
)
def test_an_impossible_size_or_place_is_an_error_that_says_what_is_valid(change, parts):
    with pytest.raises(InvalidInputError) as caught:
        replace(HANGING, **change)
    assert all(part in str(caught.value) for part in ["'hanging'", *parts])


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        ({"elbow_angle": 3}, ["unknown", "elbow_angle", "elbow_deg"]),
        ({"elbow_deg": None}, ["hanging"]),
        ({"elbow_deg": "much"}, ["much"]),
        ({"shoulder_position": 3}, ["hanging"]),
        ({"size": 5}, ["size 5", "male"]),
        ({"name": 5}, ["posture 5", "text"]),
    ],
)
def test_values_of_a_file_are_checked(change, parts):
    with pytest.raises(InvalidInputError) as caught:
        Posture.from_dict(HANGING.to_dict() | change)
    assert all(part in str(caught.value) for part in parts)


def test_a_missing_value_is_an_error_that_names_it():
    values = HANGING.to_dict()
    del values["rotation_deg"]
    with pytest.raises(InvalidInputError, match=r"missing \['rotation_deg'\].*elbow_deg"):
        Posture.from_dict(values)


def test_numbers_of_any_kind_are_kept_as_floats():
    place = np.array(DEFAULT_SHOULDER)
    posture = Posture("any", np.float32(70), 20, np.int64(30), 40.0, shoulder_position=place)
    assert posture == Posture("any", 70.0, 20.0, 30.0, 40.0)
    assert {type(getattr(posture, angle)) for angle in ANGLE_LIMITS_DEG} == {float}
    assert posture.shoulder_position == DEFAULT_SHOULDER
    assert Posture("any", 70, 20, 30, 40, shoulder_position=list(DEFAULT_SHOULDER)) == posture
    assert hash(posture) == hash(Posture("any", 70, 20, 30, 40))


@pytest.mark.parametrize("sex", ARM_VARIATION)
def test_small_and_large_arms_are_two_standard_deviations_off_the_median(sex):
    small, median, large = (astuple(ARM_SIZES[sex + name]) for name in ("_small", "", "_large"))
    relative = 2.0 * np.array(astuple(ARM_VARIATION[sex]))
    np.testing.assert_allclose(small, median * (1.0 - relative))
    np.testing.assert_allclose(large, median * (1.0 + relative))
    assert (relative > 0.0).all()
    assert (relative < 0.25).all()
    assert set(ARM_SIZES) == {s + n for s in ARM_VARIATION for n in ("_small", "", "_large")}


@pytest.mark.parametrize(
    ("size", "elbow", "wrist"),
    [
        ("male", (0.3805, -0.039268153, 0.14172385), (0.476097451, 0.189117787, 0.210644019)),
        ("female", (0.388, -0.051135457, 0.147007514), (0.475042037, 0.156811275, 0.20975973)),
    ],
)
def test_an_arm_with_all_its_angles_is_where_it_has_always_been(size, elbow, wrist):
    """Every published number depends on the order of the rotations and on the arms' sizes."""
    posture = Posture("bent", 66, 30, 48, 65, size=size)
    np.testing.assert_allclose(posture.elbow, elbow, atol=1e-8)
    np.testing.assert_allclose(posture.wrist, wrist, atol=1e-8)


def test_ranges_of_the_angles_are_those_of_the_left_arm():
    assert dict(ANGLE_LIMITS_DEG) == {
        "flexion_deg": (-60.0, 180.0),
        "abduction_deg": (-50.0, 180.0),
        "rotation_deg": (-90.0, 70.0),
        "elbow_deg": (0.0, 150.0),
    }


def test_frames_have_names_and_others_can_be_asked_for():
    posture = Posture("p", 70, 20, 30, 40)
    frames = posture.frames()
    assert frames.names == ("shoulder", "wrist")
    three = posture.frames("shoulder", "wrist", "elbow")
    assert three[:2] == frames
    np.testing.assert_allclose(three.elbow.b, posture.elbow)
    towards = (posture.shoulder - posture.elbow) / posture.arm_size.upper_arm_length
    np.testing.assert_allclose(three.elbow.A[:, 0], towards, atol=1e-12)
    assert posture.frames("elbow").names == ("elbow",)
    with pytest.raises(InvalidInputError, match="'head'; valid is shoulder, wrist, elbow"):
        posture.frames("head")
