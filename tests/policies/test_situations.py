import numpy as np
import pytest

from dressing_sim.arm import ANGLE_LIMITS_DEG, Posture
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, Policy, SyntheticDemonstration
from dressing_sim.policies.situations import (
    ArmPlanePolicy,
    ArmSampler,
    InArmPlane,
    in_arm_plane,
    joints,
)
from dressing_sim.suites.suites import load_suite

POSTURES = [posture for name in ("case_a", "case_b", "paper5") for posture in load_suite(name)]


def shown(postures):
    return [SyntheticDemonstration(np.eye(3), 0.1, posture.frames()) for posture in postures]


@pytest.mark.parametrize("posture", POSTURES, ids=lambda posture: posture.name)
def test_the_joints_are_read_from_the_frames(posture):
    found = joints(posture.frames())
    expected = posture.shoulder, posture.elbow, posture.wrist
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_the_elbow_of_a_straight_arm_is_on_its_line():
    posture = Posture("straight", 70, 20, 30, 0)
    shoulder, elbow, wrist = joints(posture.frames())
    np.testing.assert_allclose(elbow, (shoulder + wrist) / 2)


@pytest.mark.parametrize("frames", [(), (Frame(np.eye(3), np.zeros(3)),)])
def test_other_situations_are_not_an_arm(frames):
    with pytest.raises(InvalidInputError, match="2 frames"):
        joints(frames)


@pytest.mark.parametrize("posture", POSTURES, ids=lambda posture: posture.name)
def test_frames_in_the_arm_plane_keep_origin_and_x_and_hold_the_whole_arm(posture):
    for frame, turned in zip(posture.frames(), in_arm_plane(posture.frames()), strict=True):
        np.testing.assert_array_equal(turned.b, frame.b)
        np.testing.assert_allclose(turned.A[:, 0], frame.A[:, 0])
        np.testing.assert_allclose(turned.A.T @ turned.A, np.eye(3), atol=1e-12)
        assert np.linalg.det(turned.A) == pytest.approx(1.0)
        local = turned.to_local(np.array([posture.shoulder, posture.elbow, posture.wrist]))
        np.testing.assert_allclose(local[:, 2], 0.0, atol=1e-9)


def test_a_straight_arm_keeps_its_frames():
    frames = Posture("straight", 70, 20, 30, 0).frames()
    assert in_arm_plane(frames) == frames


@pytest.mark.parametrize("suite", ["case_a", "case_b"])
def test_random_arms_are_arms_around_the_demonstrated_ones(suite, rng):
    postures = load_suite(suite)
    sampler = ArmSampler.around(shown(postures), angle_margin=0.1, translation_margin=0.5)
    for _ in range(50):
        frames = sampler.sample(rng)
        shoulder, elbow, wrist = joints(frames)
        upper, fore = elbow - shoulder, wrist - elbow
        # All demonstrated arms have the same lengths and shoulder, so there is no slack for those.
        np.testing.assert_allclose(np.linalg.norm(upper), postures[0].arm_size.upper_arm_length)
        np.testing.assert_allclose(np.linalg.norm(fore), postures[0].arm_size.forearm_length)
        np.testing.assert_allclose(shoulder, postures[0].shoulder)
        slopes = [np.arcsin((p.elbow - p.shoulder)[2] / np.linalg.norm(upper)) for p in postures]
        slope = np.arcsin(upper[2] / np.linalg.norm(upper))
        assert min(slopes) - 0.1 <= slope <= max(slopes) + 0.1
        bend = np.degrees(np.arccos(upper @ fore / np.linalg.norm(upper) / np.linalg.norm(fore)))
        assert bend <= ANGLE_LIMITS_DEG["elbow_deg"][1]


def test_random_arms_differ_and_repeat_with_the_generator():
    sampler = ArmSampler.around(shown(load_suite("case_a")))
    rng, again = np.random.default_rng(4), np.random.default_rng(4)
    first, second, repeated = sampler.sample(rng), sampler.sample(rng), sampler.sample(again)
    assert not np.allclose(first[1].b, second[1].b)
    np.testing.assert_array_equal(first[1].b, repeated[1].b)


def test_the_bounds_of_angles_do_not_jump_at_half_a_turn():
    def arm(azimuth):
        direction = np.array([np.cos(azimuth), np.sin(azimuth), 0.0])
        frames = Frame(_towards(direction), np.zeros(3)), Frame(_towards(-direction), direction)
        return SyntheticDemonstration(np.eye(3), 0.1, frames)

    # Also not at half a turn from the first of the arms.
    for azimuths in ([np.pi - 0.1, 0.1 - np.pi], [0.0, np.pi - 0.1, 0.1 - np.pi]):
        sampler = ArmSampler.around([arm(azimuth) for azimuth in azimuths], angle_margin=0.0)
        width = 0.2 if len(azimuths) == 2 else np.pi + 0.1
        np.testing.assert_allclose((sampler.high - sampler.low)[[5, 7]], width, atol=1e-9)


def _towards(x):
    z = np.array([0.0, 0.0, 1.0])
    return np.column_stack([x, np.cross(z, x), z])


def test_a_policy_in_the_arm_plane_sees_turned_frames_only(posture, rng):
    class Spy:
        dt = 0.3

        def fit(self, demonstrations):
            self.seen = demonstrations[0].frames
            return self

        def generate(self, frames, start):
            self.asked = frames
            return np.stack([start, start])

    spy = Spy()
    policy = ArmPlanePolicy(spy)
    assert isinstance(policy, Policy)
    assert policy.fit(shown([posture])) is policy
    assert policy.generate(posture.frames(), np.zeros(3)).shape == (2, 3)
    assert policy.dt == 0.3
    for frame, seen, asked in zip(in_arm_plane(posture.frames()), spy.seen, spy.asked, strict=True):
        np.testing.assert_array_equal(frame.A, seen.A)
        np.testing.assert_array_equal(frame.A, asked.A)


def test_random_situations_can_be_in_the_arm_plane():
    sampler = ArmSampler.around(shown(load_suite("case_a")))
    plain = sampler.sample(np.random.default_rng(0))
    turned = InArmPlane(sampler).sample(np.random.default_rng(0))
    np.testing.assert_allclose(turned[0].A, in_arm_plane(plain)[0].A)
