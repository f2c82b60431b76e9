"""The person as drawn, where the arm moves."""

from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.episode.dressing import Dressing
from dressing_sim.motion import UNITS, Drift, Motion
from dressing_sim.pictures.moving import bone_weights, bones
from dressing_sim.pictures.person import left_arm, person
from dressing_sim.pictures.rendering import OffscreenRenderer
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import WorldConfig

REST = load_suite("paper5")[1]
NOW = REST.at(REST.coordinates + [0.02, -0.01, -0.02, -15.0, 8.0, 5.0, 14.0])


def moved(points, weights):
    sums = zip(bones(REST, NOW), weights.T, strict=True)
    return sum(w[:, None] * ((points - at) @ turn.T + to) for (turn, at, to), w in sums)


@pytest.fixture(scope="module")
def parts():
    return {part.name: part for part in person(REST)}


def test_each_bone_takes_its_own_joints_to_where_they_are():
    trunk, upper, fore = bones(REST, NOW)
    for (turn, at, to), joints in (
        (trunk, ["shoulder"]),
        (upper, ["shoulder", "elbow"]),
        (fore, ["elbow", "wrist"]),
    ):
        np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
        assert np.linalg.det(turn) == pytest.approx(1.0)
        for joint in joints:
            there = turn @ (getattr(REST, joint) - at) + to
            np.testing.assert_allclose(there, getattr(NOW, joint), atol=1e-9)


def test_where_nothing_moved_all_stays(parts):
    for turn, at, to in bones(REST, REST):
        np.testing.assert_allclose(turn, np.eye(3), atol=1e-12)
        np.testing.assert_array_equal(at, to)


def test_the_hand_goes_with_the_forearm_and_the_head_with_the_trunk(parts):
    skin = parts["skin"].vertices
    weights = bone_weights(REST, skin)
    np.testing.assert_allclose(weights.sum(axis=1), 1.0)
    assert (weights >= 0.0).all()
    np.testing.assert_allclose(weights[skin[:, 2] > REST.shoulder[2] + 0.15, 0], 1.0)
    hand = bone_weights(REST, parts["skin_hand"].vertices)
    np.testing.assert_allclose(hand[:, 2], 1.0)


@pytest.mark.parametrize("angles", [(160.0, 10.0, 0.0, 20.0), (20.0, 60.0, -40.0, 90.0)])
def test_so_it_is_where_the_arm_is_raised_beside_the_head_or_bent(angles):
    names = ("flexion_deg", "abduction_deg", "rotation_deg", "elbow_deg")
    rest = replace(REST, **dict(zip(names, angles, strict=True)))
    for part in person(rest):
        if part.name == "skin_hand":
            assert bone_weights(rest, part.vertices)[:, 2].min() > 0.99


def test_the_skin_of_the_moved_arm_is_where_a_moved_arm_has_its_skin(parts):
    skin = parts["skin"].vertices
    weights = bone_weights(REST, skin)
    whole = weights.max(axis=1) > 0.999  # between joints, where a part is rigid
    for bone in (1, 2):
        there = moved(skin, weights)[whole & (weights[:, bone] > 0.999)]
        assert len(there) > 100
        assert np.abs(left_arm(NOW)(there)).max() < 0.006


def test_a_person_who_moves_is_drawn_elsewhere(opengl):
    drift = Motion(drift=(Drift("elbow_deg", 14.0, 0.0, 1.0), Drift("shoulder_z", -0.02, 0.0, 1.0)))
    arm, config = replace(REST, motion=drift), WorldConfig()
    dressing = Dressing(arm)
    dressing.reset()
    world = dressing.world
    before = world.data.qpos.copy()
    after = before.copy()
    n = len(before) - world.cloth.size
    assert n == 9 + 7
    np.testing.assert_allclose(before[9:n], REST.coordinates * UNITS)
    after[9:n] = NOW.coordinates * UNITS
    with OffscreenRenderer(arm, config, 160, 120, fine=False) as renderer:
        first, second, again = (renderer.draw(q) for q in (before, after, before))
    np.testing.assert_array_equal(first, again)
    assert (first != second).any(axis=2).mean() > 0.01
    with OffscreenRenderer(REST, config, 160, 120, fine=False) as renderer:
        still = renderer.draw(np.concatenate([before[:9], before[n:]]))
    assert (np.abs(still.astype(int) - first) > 40).mean() < 0.01
