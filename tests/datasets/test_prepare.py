from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from lab_recordings import POSTURE, TURN_DEG, columns, path
from scipy.spatial.transform import Rotation

from dressing_sim.arm import ANGLE_LIMITS_DEG, ARM_SIZES, Posture
from dressing_sim.datasets.prepare import ImportConfig, demonstration_of, moving_rows, posture_of
from dressing_sim.datasets.recording import of_columns
from dressing_sim.episode.demonstration import load_demonstrations, save_demonstrations
from dressing_sim.episode.record import replay
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.registry import make_policy

BACK = ImportConfig(turn_deg=-TURN_DEG)

angles = st.tuples(*(st.floats(*limits) for limits in ANGLE_LIMITS_DEG.values()))


@settings(max_examples=40)
@given(angles, st.sampled_from(sorted(ARM_SIZES)))
def test_joints_tell_the_posture(drawn, size):
    arm = Posture("a", *drawn, size)
    # At 90 degrees of abduction two of the angles turn about the same axis.
    assume(abs(abs(arm.abduction_deg) - 90.0) > 0.01)
    found = posture_of("a", arm.shoulder, arm.elbow, arm.wrist, ARM_SIZES["female"])
    for joint in ("shoulder", "elbow", "wrist"):
        np.testing.assert_allclose(getattr(found, joint), getattr(arm, joint), atol=1e-7)
    assert found.arm_size.upper_arm_radius == ARM_SIZES["female"].upper_arm_radius


def test_a_recording_of_the_simulator_is_found_again_whatever_the_labs_frame_and_clock():
    made = demonstration_of(of_columns("r", columns()), BACK)
    even = columns(uneven=False)
    for joint in ("shoulder", "elbow", "wrist"):
        np.testing.assert_allclose(getattr(made.posture, joint), getattr(POSTURE, joint), atol=1e-9)
    # Four rows at random times for each of 20 ms: interpolated twice, and half a step lost.
    assert abs(len(made.positions) - len(even["time"])) <= 1
    n = min(len(made.positions), len(even["time"]))
    assert np.linalg.norm(made.positions[:n] - path()[:n], axis=1).max() < 2e-3
    turns = Rotation.from_quat(made.orientations).as_rotvec()
    np.testing.assert_allclose(turns[:, 2], 0.1 * 0.02 * np.arange(len(turns)), atol=1e-9)
    np.testing.assert_allclose(made.forces, np.tile([1.0, 2.0, 3.0], (len(turns), 1)), atol=1e-9)


def test_even_times_in_the_robots_frame_are_kept_to_the_last_bits():
    values = columns(turn_deg=0.0, uneven=False)
    values = {
        name: one - [1.0, 2.0, 0.9] if name in ("gripper", "shoulder", "elbow", "wrist") else one
        for name, one in values.items()
    }
    made = demonstration_of(of_columns("r", values), ImportConfig(keep_place=True))
    np.testing.assert_allclose(made.positions, path(), atol=1e-12)


@pytest.mark.parametrize("turn_deg", [0.0, 33.0])
def test_a_right_arm_mirrored_is_the_left_arm(turn_deg):
    """The mirror image of all that was recorded, mirrored again."""
    values = columns(turn_deg=0.0)
    flip = np.array([-1.0, 1.0, 1.0])
    turn = Rotation.from_euler("z", turn_deg, degrees=True)
    right = {
        name: turn.apply(flip * one)
        for name, one in values.items()
        if name not in ("time", "quaternion")
    }
    hand = Rotation.from_quat(values["quaternion"]).as_matrix()
    hand = turn * Rotation.from_matrix(flip[:, None] * hand * flip)
    right |= {"time": values["time"], "quaternion": hand.as_quat()}
    config = ImportConfig(turn_deg=-turn_deg, mirror=True)
    made = demonstration_of(of_columns("r", right), config)
    left = demonstration_of(of_columns("r", values), ImportConfig())
    np.testing.assert_allclose(made.positions, left.positions, atol=1e-9)
    np.testing.assert_allclose(made.forces, left.forces, atol=1e-9)
    same = Rotation.from_quat(made.orientations) * Rotation.from_quat(left.orientations).inv()
    assert same.magnitude().max() < 1e-9
    other = demonstration_of(of_columns("r", right), replace(config, mirror=False)).posture
    assert abs(other.abduction_deg - made.posture.abduction_deg) > 5.0


def test_pauses_are_left_out_and_nothing_else():
    positions = path()
    still = np.repeat(positions, 1, axis=0)
    parts = [np.repeat(still[:1], 60, 0), still[:200], np.repeat(still[200:201], 50, 0)]
    paused = np.concatenate([*parts, still[200:], np.repeat(still[-1:], 80, 0)])
    kept = paused[moving_rows(paused, 0.02)]
    # The operator begins and ends slowly; all that is lost are rows within a centimetre.
    assert len(positions) - 60 < len(kept) <= len(positions) + 30
    assert np.linalg.norm(np.diff(kept, axis=0), axis=1).max() < 0.012
    np.testing.assert_allclose(kept[0], positions[0], atol=2e-3)
    np.testing.assert_allclose(kept[-1], positions[-1], atol=5e-3)
    with pytest.raises(InvalidInputError, match="rests all the time"):
        moving_rows(np.repeat(positions[:1], 100, 0), 0.02)


def test_what_was_imported_is_in_a_file_and_policies_learn_from_it(tmp_path):
    made = [
        demonstration_of(of_columns(f"r{seed}", columns(seed)), replace(BACK, trim_pauses=True))
        for seed in range(2)
    ]
    save_demonstrations(tmp_path / "mine.h5", made)
    again = load_demonstrations(tmp_path / "mine.h5")
    for one, other in zip(made, again, strict=True):
        np.testing.assert_array_equal(one.positions, other.positions)
        np.testing.assert_array_equal(one.orientations, other.orientations)
        np.testing.assert_array_equal(one.forces, other.forces)
        assert (other.commands, other.posture, other.dt) == (None, one.posture, one.dt)
        assert other.settings["import"]["trim_pauses"] is True
    policy = make_policy("default").fit(again)
    made_path = policy.generate(POSTURE.frames(), path()[0])
    points = np.asarray(getattr(made_path, "positions", made_path))
    assert np.linalg.norm(points[-1] - path()[-1]) < 0.05
    with pytest.raises(InvalidInputError, match="recorded in the simulator"):
        replay(again[0])


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"time": lambda t: t[::-1]}, "time does not rise from row 0"),
        ({"time": lambda t: t * 1e-3}, "median speed"),
        ({"time": lambda t: t + (t > 5.0)}, "nothing for"),
        ({"gripper": lambda x: x * 1e3}, "another unit"),
        ({"gripper": lambda x: x[:-1]}, "gripper has"),
        ({"gripper": lambda x: np.full_like(x, np.nan)}, "not finite"),
        ({"gripper": lambda x: np.repeat(x[:1], len(x), 0)}, "median speed"),
        ({"wrist": lambda x: x * 1e3}, "forearm_length"),
        ({"elbow": lambda x: x + [0.0, 0.0, 0.6]}, "upper_arm_length"),
        ({"quaternion": lambda q: 2.0 * q}, "norm"),
        ({"force": lambda f: f[:, :2]}, "force has"),
        ({"shoulder": lambda x: x + np.linspace(0, 1, 9)[:, None]}, "moves by"),
    ],
)
def test_what_cannot_be_meant_is_refused(change, told):
    values = columns()
    values |= {name: one(values[name]) for name, one in change.items()}
    with pytest.raises(InvalidInputError, match=told) as refused:
        demonstration_of(of_columns("r", values), BACK)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("missing", ["time", "gripper", "shoulder", "elbow", "wrist"])
def test_what_is_missing_is_named(missing):
    values = {name: one for name, one in columns().items() if name != missing}
    with pytest.raises(InvalidInputError, match=f"no {missing}"):
        of_columns("r", values)


def test_frames_tell_the_elbow():
    values = {name: one for name, one in columns().items() if name != "elbow"}
    lab = Rotation.from_euler("z", TURN_DEG, degrees=True)
    for name, frame in zip(("shoulder", "wrist"), POSTURE.frames(), strict=True):
        values[f"{name}_quaternion"] = (lab * Rotation.from_matrix(frame.A)).as_quat()
    np.testing.assert_allclose(of_columns("r", values).elbow, columns()["elbow"], atol=1e-9)


@pytest.mark.parametrize(
    "wrong", [{"dt": 0.0}, {"dt": np.nan}, {"turn_deg": 1e4}, {"mirror": 1}, {"max_gap": 0.0}]
)
def test_a_config_that_cannot_be_meant_is_refused(wrong):
    with pytest.raises(InvalidInputError, match=next(iter(wrong))):
        ImportConfig(**wrong)
