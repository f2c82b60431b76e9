"""What surrounds the paper's policies: one clock before the fit, clearance after the answer."""

import numpy as np
import pytest

from dressing_sim.episode.operator import Operator
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, SyntheticDemonstration, TrajectoryTPGMM, rotation
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.path import Path
from dressing_sim.policies.cleared import ClearPolicy
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.situations import ArmPlanePolicy
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import WorldConfig, grip_start


def demonstration(posture, seed):
    path = Operator().generate(posture, grip_start(posture, WorldConfig().sleeve), seed)
    return SyntheticDemonstration(path.positions, path.dt, posture.frames())


SHOWN = [demonstration(posture, seed) for seed, posture in enumerate(load_suite("case_a"))]


class Fixed:
    """A policy whose answer is always the same."""

    def __init__(self, path):
        self.path = path

    def fit(self, demonstrations):
        return self

    def generate(self, frames, start):
        return self.path


def cleared(points, frames=SHOWN[0].frames, shown=SHOWN[:1]):
    return ClearPolicy(Fixed(Path(points, 0.02))).fit(shown).generate(frames, points[0])


def drawn_in(points, frames, share):
    """A path nearer to the skeleton by a share of its distance, but for its start."""
    skeleton = Skeleton.of(frames)
    way = np.linspace(0.0, 1.0, len(points))[:, None]
    return points - share * np.minimum(10.0 * way, 1.0) * skeleton.outward(points)


def test_the_demonstration_itself_is_as_clear_as_it_was():
    points = SHOWN[0].positions
    np.testing.assert_allclose(cleared(points).positions, points, atol=2e-3)


def test_a_path_too_near_is_led_off_and_begins_where_it_did():
    shown = SHOWN[0]
    near = drawn_in(shown.positions, shown.frames, 0.4)
    moved = cleared(near)
    skeleton = Skeleton.of(shown.frames)
    lacking, left = (
        np.linalg.norm(skeleton.outward(shown.positions), axis=1)
        - np.linalg.norm(skeleton.outward(points), axis=1)
        for points in (near, moved.positions)
    )
    assert lacking.max() > 0.03
    past = slice(len(near) // 4, None)
    assert np.abs(left[past]).max() < 0.35 * lacking[past].max()
    np.testing.assert_allclose(moved.positions[0], near[0], atol=1e-12)
    assert (len(moved), moved.dt) == (len(near), 0.02)


def test_turning_and_moving_the_scene_turns_and_moves_the_answer():
    turn, shift = rotation([0.0, 0.0, 0.7]), np.array([0.1, -0.2, 0.05])
    shown = SHOWN[0]
    near = drawn_in(shown.positions, shown.frames, 0.4)
    frames = [Frame(turn @ frame.A, turn @ frame.b + shift) for frame in shown.frames]
    there = cleared(near @ turn.T + shift, frames).positions
    np.testing.assert_allclose(there, cleared(near).positions @ turn.T + shift, atol=1e-9)


def test_a_path_that_does_not_pass_the_elbow_stays():
    short = SHOWN[0].positions[:40]
    np.testing.assert_array_equal(cleared(short).positions, short)
    with pytest.raises(InvalidInputError, match="demonstration 0 does not pass the elbow"):
        cleared(short, shown=[SyntheticDemonstration(short, 0.02, SHOWN[0].frames)])


def test_what_surrounds_a_policy_is_chosen_by_its_name():
    plain = make_policy("tp-gmm")
    assert type(plain) is TrajectoryTPGMM
    assert plain.alignment is None
    surrounded = make_policy("tp-gmm-rf?aligned=true&clearance=true&free_axes=arm-plane")
    assert type(surrounded) is ClearPolicy
    assert type(surrounded.policy) is ArmPlanePolicy
    assert type(surrounded.policy.policy) is AugmentedTPGMM
    assert surrounded.policy.policy.policy.alignment is not None


def test_on_one_clock_half_the_speed_makes_no_other_policy():
    slow = SyntheticDemonstration(SHOWN[1].positions, 2.0 * SHOWN[1].dt, SHOWN[1].frames)
    ends = {}
    for aligned in ("false", "true"):
        for second in (SHOWN[1], slow):
            policy = make_policy(f"tp-gmm?aligned={aligned}").fit([SHOWN[0], second])
            path = policy.generate(SHOWN[0].frames, SHOWN[0].positions[0])
            ends[aligned, second is slow] = np.asarray(path)[-1]
    change = {
        aligned: np.linalg.norm(ends[aligned, True] - ends[aligned, False])
        for aligned in ("false", "true")
    }
    assert change["true"] < 1e-3
    assert change["true"] < 0.2 * change["false"]


def test_both_together_are_clear_of_an_arm_that_was_not_shown():
    policy = make_policy("tp-gmm?aligned=true&clearance=true").fit(SHOWN)
    posture = load_suite("val50")[0]
    start = grip_start(posture, WorldConfig().sleeve)
    path = policy.generate(posture.frames(), start)
    np.testing.assert_allclose(path.positions[0], start, atol=1e-12)
    inner = policy.policy.generate(posture.frames(), start)
    assert len(path) == len(inner)
    assert path.dt is None
    assert policy.dt == policy.policy.dt
    assert np.abs(path.positions - inner).max() > 1e-3
