from dataclasses import fields, replace

import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.episode.operator import COMMAND_PERIOD, Operator, OperatorConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Policy
from dressing_sim.path import policy_path
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import load_suite, suite_names
from dressing_sim.world.scene import WorldConfig, grip_start

POSTURES = [posture for suite in suite_names() for posture in load_suite(suite)]
BENT = Posture("bent", 66, 30, 48, 65)


def path(posture, seed=0, config=None):
    start = grip_start(posture, WorldConfig().sleeve)
    return Operator(config).path(posture, start, np.random.default_rng(seed))


def steady(**changes):
    """An operator without any variability."""
    still = {f.name: 0.0 for f in fields(OperatorConfig) if f.name.endswith("variation")}
    return replace(OperatorConfig(), sway=0.0, tremor=0.0, **still, **changes)


def distance_to_arm(points, posture):
    """Smallest distance of any point to the axis of the arm."""
    distances = []
    for a, b in ((posture.wrist, posture.elbow), (posture.elbow, posture.shoulder)):
        share = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        distances.append(np.linalg.norm(points - (a + share[:, None] * (b - a)), axis=1))
    return np.min(distances)


def test_a_seed_makes_the_path():
    np.testing.assert_array_equal(path(BENT, 3), path(BENT, 3))
    one, other = path(BENT, 3), path(BENT, 4)
    assert one.shape != other.shape or not np.allclose(one, other, atol=1e-3)


def test_without_variability_all_seeds_make_the_same_path():
    np.testing.assert_array_equal(path(BENT, 3, steady()), path(BENT, 4, steady()))


@pytest.mark.parametrize("posture", POSTURES, ids=lambda posture: posture.name)
def test_a_path_leads_from_where_the_sleeve_is_held_over_the_arm_to_above_the_shoulder(posture):
    points = path(posture)
    assert np.isfinite(points).all()
    np.testing.assert_allclose(points[0], grip_start(posture, WorldConfig().sleeve), atol=1e-12)
    config = OperatorConfig()
    assert points[-1][2] > posture.shoulder[2]
    off = np.linalg.norm(points[-1] - posture.shoulder) - config.shoulder_height
    assert abs(off) < 4 * (config.height_variation + config.waypoint_variation)
    assert distance_to_arm(points, posture) > posture.arm_size.upper_arm_radius


@pytest.mark.parametrize("posture", POSTURES[:3], ids=lambda posture: posture.name)
def test_steps_are_even_and_slow_enough_to_be_human(posture):
    config = OperatorConfig()
    speeds = np.linalg.norm(np.diff(path(posture), axis=0), axis=1) / config.dt
    assert speeds.max() < 4 * config.speed


def test_the_speed_is_the_one_asked_for():
    slow, fast = (path(BENT, 0, steady(speed=speed)) for speed in (0.05, 0.2))
    length = np.linalg.norm(np.diff(slow, axis=0), axis=1).sum()
    for points, speed in ((slow, 0.05), (fast, 0.2)):
        duration = (len(points) - 1) * OperatorConfig().dt
        assert duration == pytest.approx(length / speed, rel=0.1)


def test_a_higher_variation_spreads_the_paths():
    def spread(config):
        ends = [path(BENT, seed, config)[-1] for seed in range(20)]
        return np.std(ends, axis=0).max()

    assert spread(steady()) < 1e-12
    calm, wild = (replace(steady(), waypoint_variation=deviation) for deviation in (0.002, 0.02))
    assert spread(calm) == pytest.approx(0.002, rel=0.6)
    assert spread(wild) == pytest.approx(0.02, rel=0.6)


def test_the_elbow_is_passed_on_its_outside():
    points = path(BENT, 0, steady())
    forearm = BENT.elbow - BENT.wrist
    upper = (BENT.shoulder - BENT.elbow) / BENT.arm_size.upper_arm_length
    outside = forearm - (forearm @ upper) * upper
    outside /= np.linalg.norm(outside)
    assert ((points - BENT.elbow) @ outside).max() > 0.05


@pytest.mark.parametrize("elbow", [0.0, 1e-6, 150.0])
def test_a_straight_and_a_folded_arm_have_a_path_too(elbow):
    assert np.isfinite(path(Posture("extreme", 80, 20, 40, elbow))).all()


@pytest.mark.parametrize(
    "angles",
    [
        (0, 0, 0, 0),
        (30, 0, 0, 150),
        (90, 0, 0, 90),
        (45, 0, 0, 135),
        (60, 0, 0, 120),
        (0, 0, 0, 90),
    ],
)
def test_a_vertical_forearm_or_upper_arm_has_a_path_that_rounding_does_not_turn(angles):
    points = path(Posture("vertical", *angles), config=steady())
    nudged = path(Posture("nudged", *angles[:3], abs(angles[3] - 1e-10)), config=steady())
    assert np.isfinite(points).all()
    np.testing.assert_allclose(nudged, points, atol=1e-6)


def test_the_operator_leads_as_always():
    """Every published number depends on its waypoints, speed and shaking."""
    points = path(BENT)
    assert len(points) == 378
    expected = [
        (0.424588287, 0.072782107, 0.259768823),
        (0.366668081, -0.066687116, 0.236555398),
        (0.293979298, -0.20221406, 0.171945201),
        (0.409963902, -0.190282207, 0.274949349),
        (0.502093709, -0.238035174, 0.321773348),
    ]
    places = [int(share * (len(points) - 1)) for share in (0.2, 0.4, 0.6, 0.8, 1.0)]
    np.testing.assert_allclose(points[places], expected, atol=1e-8)


def test_it_is_a_policy_of_class_posture_that_learns_nothing():
    operator = Operator()
    assert isinstance(operator, Policy)
    assert operator.inputs == "posture"
    assert operator.fit([]) is operator
    start = grip_start(BENT, WorldConfig().sleeve)
    made = operator.generate(BENT, start, seed=3)
    np.testing.assert_array_equal(made.positions, path(BENT, 3))
    assert made.dt == operator.dt == OperatorConfig().dt


def test_an_episode_s_seed_is_its_own():
    """So the expert in a test does what it does in a demonstration with the same seed."""
    start = grip_start(BENT, WorldConfig().sleeve)
    asked = policy_path(Operator(), BENT, start, 3, 0.05, 30.0)
    np.testing.assert_array_equal(asked.positions, path(BENT, 3))
    assert asked.dt == OperatorConfig().dt


def test_a_disturbance_leaves_the_way_that_is_meant_as_it_is():
    """Noise in the commands is drawn last: what is added does not depend on the posture."""
    errors = []
    for posture in (BENT, POSTURES[0]):
        clean, led = path(posture, 5), path(posture, 5, OperatorConfig(disturbance=0.01))
        assert clean.shape == led.shape
        np.testing.assert_array_equal(led[0], clean[0])
        errors.append(led - clean)
    n = min(map(len, errors)) - 20
    np.testing.assert_allclose(errors[0][:n], errors[1][:n], atol=1e-12)


@pytest.mark.parametrize("correction", [0.2, 1.0])
def test_a_disturbance_is_as_large_as_it_says_and_is_corrected_in_time(correction):
    config = OperatorConfig(speed=0.001, disturbance=0.01, correction=correction)
    error = path(BENT, 0, config) - path(BENT, 0, replace(config, disturbance=0.0))
    at_commands = error[:: round(COMMAND_PERIOD / config.dt)][50:]
    assert at_commands.std() == pytest.approx(0.01, rel=0.1)
    kept = np.mean(at_commands[1:] * at_commands[:-1]) / at_commands.var()
    assert kept == pytest.approx(np.exp(-COMMAND_PERIOD / correction), abs=0.06)


def test_a_disturbed_operator_can_be_asked_for_by_name():
    teacher = make_policy("expert?disturbance=0.008&correction=0.3")
    assert (teacher.config.disturbance, teacher.config.correction) == (0.008, 0.3)
    with pytest.raises(InvalidInputError, match="disturbance is -1"):
        make_policy("expert?disturbance=-1")
