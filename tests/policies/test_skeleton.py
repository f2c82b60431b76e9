import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.learning import Frame, rotation
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.suites.suites import load_suite

POSTURES = [posture for name in ("case_a", "case_b", "paper5") for posture in load_suite(name)]
STRAIGHT = Posture("straight", 70, 20, 30, 0)
MALE = np.array([0.279, 0.257])


def joints(skeleton):
    return np.array([skeleton.shoulder, skeleton.elbow, skeleton.wrist])


def noisy(frames, degrees, rng):
    """The frames with their axes turned by a random angle."""
    turns = [rotation(np.deg2rad(degrees) * rng.standard_normal(3)) for _ in frames]
    return [Frame(turn @ frame.A, frame.b) for turn, frame in zip(turns, frames, strict=True)]


@pytest.mark.parametrize("posture", POSTURES, ids=lambda posture: posture.name)
def test_the_elbow_of_exact_frames_is_exact_whatever_the_bones(posture):
    expected = [posture.shoulder, posture.elbow, posture.wrist]
    np.testing.assert_allclose(joints(Skeleton.of(posture.frames())), expected, atol=1e-9)
    # The bones expected are those of another arm.
    bones = 0.95 * np.array([posture.arm_size.upper_arm_length, posture.arm_size.forearm_length])
    np.testing.assert_allclose(joints(Skeleton.of(posture.frames(), bones)), expected, atol=3e-3)


def test_the_elbow_of_a_straight_arm_follows_the_bones():
    found = Skeleton.of(STRAIGHT.frames(), MALE)
    np.testing.assert_allclose(found.elbow, STRAIGHT.elbow, atol=1e-6)
    half_way = Skeleton.of(STRAIGHT.frames())
    assert np.linalg.norm(half_way.elbow - STRAIGHT.elbow) > 5e-3


@pytest.mark.parametrize("elbow_deg", [2, 10, 20, 40, 80, 120])
def test_bones_help_where_axes_are_noisy(elbow_deg, rng):
    posture = Posture("arm", 70, 25, 40, elbow_deg)
    errors = []
    for _ in range(60):
        frames = noisy(posture.frames(), 3.0, rng)
        places = Skeleton.of(frames), Skeleton.of(frames, MALE)
        errors.append([np.linalg.norm(found.elbow - posture.elbow) for found in places])
    met, likely = np.median(errors, axis=0)
    assert likely < 0.02
    assert likely < 1.05 * met
    if elbow_deg <= 20:
        assert likely < 0.75 * met


def test_the_skeleton_turns_and_moves_with_the_frames(rng):
    turn, shift = rotation([0.3, 0.2, 1.0]), np.array([0.1, -0.2, 0.3])
    frames = noisy(POSTURES[1].frames(), 3.0, rng)
    moved = [Frame(turn @ frame.A, turn @ frame.b + shift) for frame in frames]
    here, there = Skeleton.of(frames, MALE), Skeleton.of(moved, MALE)
    np.testing.assert_allclose(joints(there), joints(here) @ turn.T + shift, atol=1e-6)


def test_bends():
    shoulder, elbow = np.array([0.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])
    sideways = Skeleton(shoulder, elbow, np.array([1.0, 1.0, 0.0]))
    assert (sideways.bend, sideways.sideways) == pytest.approx((1.0, 1.0))
    upwards = Skeleton(shoulder, elbow, np.array([0.0, 1.0, 1.0]))
    assert (upwards.bend, upwards.sideways) == pytest.approx((1.0, 0.0))
    # The forearm comes down to the elbow: the way on keeps as much of that as is wanted.
    np.testing.assert_allclose(upwards.onward(1.0), [0.0, 0.0, -1.0])
    np.testing.assert_allclose(upwards.onward(0.25), [0.0, 0.0, -0.25])
    np.testing.assert_allclose(sideways.onward(0.0), [-1.0, 0.0, 0.0])


def test_what_is_outward_of_two_bones():
    skeleton = Skeleton(np.zeros(3), np.array([0.0, 1.0, 0.0]), np.array([1.0, 1.0, 0.0]))
    points = np.array([[0.0, 0.5, 0.2], [0.5, 1.3, 0.0], [-0.3, 1.0, 0.0], [2.0, 1.0, 0.0]])
    expected = [[0.0, 0.0, 0.2], [0.0, 0.3, 0.0], [-0.3, 0.0, 0.0], [1.0, 0.0, 0.0]]
    np.testing.assert_allclose(skeleton.outward(points), expected, atol=1e-12)


@pytest.mark.parametrize("posture", [*POSTURES, STRAIGHT], ids=lambda posture: posture.name)
def test_landmarks_are_on_the_bones_over_them_and_beyond_the_elbow(posture):
    skeleton = Skeleton(posture.shoulder, posture.elbow, posture.wrist)
    marks = skeleton.landmarks(0.08, [0.1, 0.2], 0.25, 5)
    assert marks.shape == (9 + 9 + 2, 3)
    distance = np.linalg.norm(skeleton.outward(marks), axis=1)
    np.testing.assert_allclose(distance[:9], 0.0, atol=1e-12)
    assert np.all(distance[9:18] < 0.08 + 1e-12)
    np.testing.assert_allclose(marks[9:18, 2] > marks[:9, 2], True)
    np.testing.assert_allclose(marks[19] - marks[18], 0.1 * skeleton.onward(0.25))


def test_the_way_on_is_over_a_straight_elbow_and_beside_a_bent_one():
    shoulder, elbow = np.zeros(3), np.array([0.0, 1.0, 0.0])
    for bend, height in ((0.0, 0.1), (np.pi / 3, 0.05), (np.pi / 2, 0.0), (2.0, 0.0)):
        wrist = elbow + [np.sin(bend), np.cos(bend), 0.0]
        beyond = Skeleton(shoulder, elbow, wrist).landmarks(0.1, [0.2], 0.25, 2)[-1]
        assert beyond[2] == pytest.approx(height, abs=1e-12)
