"""Rewards are made of signed margins."""

from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.envs.reward import arrival_margins, harshness, progress, ramp
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.thresholds import Thresholds

THRESHOLDS = Thresholds()
SHOULDER = np.array([0.5, -0.2, 0.3])


@pytest.fixture(scope="module")
def row(posture):
    """What hangs still pulls and stretches little."""
    return Dressing(posture).reset()


def at(row, offset, s):
    return replace(row, tcp=SHOULDER + offset, armscye_s=s)


def test_the_ramp_is_the_linear_tolerance_of_dm_control():
    rewards = pytest.importorskip("dm_control.utils.rewards")
    for margin in np.linspace(-2.0, 1.0, 31):
        expected = rewards.tolerance(
            margin, bounds=(0.0, np.inf), margin=0.7, sigmoid="linear", value_at_margin=0.0
        )
        assert ramp(margin, 0.7) == pytest.approx(float(expected), abs=1e-12)


def test_who_has_arrived_has_all_progress_and_both_margins(row):
    there = at(row, [0.0, 0.0, 0.09], 1.95)
    assert min(arrival_margins(there, SHOULDER, THRESHOLDS)) > 0.0
    assert progress(there, True, SHOULDER, THRESHOLDS) == 1.0


def test_below_the_shoulder_or_too_far_is_not_arrived(row):
    for offset in ([0.0, 0.0, -0.05], [0.0, 0.2, 0.05]):
        assert arrival_margins(at(row, offset, 1.95), SHOULDER, THRESHOLDS)[0] < 0.0


def test_a_sleeve_beside_the_arm_achieves_nothing(row):
    near = at(row, [0.0, 0.0, 0.09], 1.5)
    gains = [progress(near, on, SHOULDER, THRESHOLDS) for on in (False, True)]
    assert gains[0] == 0.5
    assert gains[1] == pytest.approx(0.5 + 0.5 * 1.5 / THRESHOLDS.armscye_s)


def test_progress_grows_along_the_arm(row):
    way = [
        progress(at(row, [0.0, 0.6 - 0.3 * s, 0.09], s), True, SHOULDER, THRESHOLDS)
        for s in np.linspace(0.0, 2.0, 21)
    ]
    assert np.all(np.diff(way) >= 0.0)
    assert way[-1] > way[0] + 0.5


@pytest.mark.parametrize("name", ["strain", "grip_force"])
def test_half_of_a_limit_is_free_and_all_of_it_costs_one(row, name):
    limit = getattr(THRESHOLDS, name)
    soft = replace(row, strain=0.0, grip_force=0.0)
    costs = [harshness(replace(soft, **{name: f * limit}), THRESHOLDS) for f in (0.5, 0.75, 1, 9)]
    np.testing.assert_allclose(costs, [0.0, 0.5, 1.0, 1.0], atol=1e-12)


def test_an_infinite_limit_costs_nothing(row):
    free = replace(THRESHOLDS, strain=np.inf, grip_force=np.inf, link_force=np.inf)
    assert harshness(replace(row, strain=5.0), free) == 0.0
