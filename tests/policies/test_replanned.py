"""A policy that asks again as the arm moves; nothing is simulated."""

import numpy as np
import pytest

from dressing_sim.arm import Posture, situation
from dressing_sim.episode.observation import Observation
from dressing_sim.episode.operator import Operator
from dressing_sim.errors import InvalidInputError
from dressing_sim.path import Path
from dressing_sim.policies.registry import learns, make_policy
from dressing_sim.policies.replanned import ReplannedPolicy, Replanning

DT = 0.02
START = np.array([0.3, 0.15, 0.2])


def frames(shift=(0.0, 0.0, 0.0)):
    joints = np.array([[0.5, -0.3, 0.2], [0.4, 0.0, 0.2], [0.3, 0.2, 0.1]]) + shift
    return situation(*joints)


class Straight:
    """A straight line in five seconds from the start to above the shoulder."""

    def __init__(self, with_dt=True):
        self.asked, self.with_dt = [], with_dt

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        self.asked.append((frames, np.array(start)))
        end = frames[0].b + [0.0, 0.0, 0.08]
        return Path(np.linspace(start, end, 251), DT if self.with_dt else None)


def led(policy, seen, seconds=12.0):
    """Targets (n, 3) until the policy ends, of frames that a function of time tells."""
    policy.reset()
    targets = [START]
    for step in range(round(seconds / DT)):
        time = step * DT
        target = policy.act(Observation(time, DT, targets[-1], targets[-1], seen(time)))
        if target is None:
            return np.array(targets)
        targets.append(target)
    raise AssertionError("it never ended")


def test_about_an_arm_that_rests_it_asks_once_and_its_path_is_the_other_s():
    inner, still = Straight(), frames()
    path = led(ReplannedPolicy(inner), lambda time: still)
    assert len(inner.asked) == 1
    end = still[0].b + [0.0, 0.0, 0.08]
    np.testing.assert_allclose(path[-1], end, atol=0.01)
    across = np.cross(path - START, (end - START) / np.linalg.norm(end - START))
    np.testing.assert_allclose(across, 0.0, atol=1e-12)
    assert len(path) == pytest.approx(252, abs=3)


def test_it_asks_with_the_newest_frames_and_where_the_gripper_began():
    inner = Straight()
    led(ReplannedPolicy(inner, Replanning(period=0.5)), lambda time: frames([0, 0, 0.004 * time]))
    assert 10 <= len(inner.asked) <= 13
    heights = [asked[0].b[2] for asked, _ in inner.asked]
    np.testing.assert_allclose(heights, 0.2 + 0.004 * 0.5 * np.arange(len(heights)), atol=1e-9)
    for _, start in inner.asked:
        np.testing.assert_array_equal(start, START)


def test_neither_place_nor_speed_of_the_target_jumps_when_the_arm_is_seen_elsewhere():
    before, after = frames(), frames([0.0, 0.0, 0.03])
    path = led(ReplannedPolicy(Straight()), lambda time: before if time < 2.0 else after)
    speed = np.diff(path, axis=0) / DT
    change = np.linalg.norm(np.diff(speed, axis=0), axis=1)[1:-60]
    # The spring's own acceleration w^2 times the distance, and no more.
    assert change.max() < 1.3 * 3.0**2 * 0.03 * DT
    np.testing.assert_allclose(path[-1], after[0].b + [0.0, 0.0, 0.08], atol=0.006)


def test_it_follows_an_arm_that_drifts_all_the_time():
    path = led(ReplannedPolicy(Straight()), lambda time: frames([0.004 * time, 0.0, 0.0]))
    time = DT * len(path)
    end = frames([0.004 * time, 0.0, 0.0])[0].b + [0.0, 0.0, 0.08]
    assert np.linalg.norm(path[-1] - end) < 0.015


def test_noise_of_what_is_seen_is_smoothed(rng):
    noisy = [frames(rng.normal(0.0, 0.01, 3)) for _ in range(150)]
    path = led(ReplannedPolicy(Straight()), lambda time: noisy[int(time / 0.1)])
    end = frames()[0].b + [0.0, 0.0, 0.08]
    across = np.cross(path - START, (end - START) / np.linalg.norm(end - START))
    assert np.linalg.norm(across, axis=1).max() < 0.02
    assert np.linalg.norm(np.diff(path, 2, axis=0)[2:240], axis=1).max() / DT**2 < 0.5


def test_moving_the_scene_moves_the_targets():
    shift = np.array([0.1, -0.05, 0.08])
    here = led(ReplannedPolicy(Straight()), lambda time: frames([0.004 * time, 0, 0]))
    policy = ReplannedPolicy(Straight())
    targets = [START + shift]
    for step in range(len(here) - 1):
        seen = frames(shift + [0.004 * step * DT, 0, 0])
        targets.append(policy.act(Observation(step * DT, DT, targets[-1], targets[-1], seen)))
    np.testing.assert_allclose(targets, here + shift, atol=1e-9)


def test_each_episode_is_as_the_first():
    policy = ReplannedPolicy(Straight())
    one, other = (led(policy, lambda time: frames([0, 0.003 * time, 0])) for _ in range(2))
    np.testing.assert_array_equal(one, other)


def test_a_path_without_a_time_is_refused():
    with pytest.raises(InvalidInputError, match="no dt"):
        led(ReplannedPolicy(Straight(with_dt=False)), lambda time: frames())


def test_the_operator_who_looks_again_keeps_its_hand():
    """The same seed draws the same variability at every look; another episode has another."""
    policy, posture = make_policy("expert-replan"), Posture("one", 70, 20, 30, 40)
    assert policy.inputs == "posture"
    assert not learns("expert-replan")
    assert learns("transport-replan")
    policy.reset(seed=5)
    policy.act(Observation(0.0, DT, START, START, posture))
    wanted = Operator().generate(posture, START, 5).positions
    end = policy._plan.path(policy._plan.duration)
    np.testing.assert_allclose(end, wanted[-1])
