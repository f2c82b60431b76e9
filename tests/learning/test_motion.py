import numpy as np
import pytest
from learning_tasks import reaching_demonstrations, reaching_situation
from scipy.stats import multivariate_normal

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import AugmentOptions, TimeTPGMM, TrajectoryTPGMM
from dressing_sim.learning.augmented import AugmentedTPGMM

FRAMES = reaching_situation(np.random.default_rng(8))
START = FRAMES[0].b
DEMONSTRATIONS = reaching_demonstrations(5)


@pytest.fixture(scope="module")
def policy():
    return TrajectoryTPGMM().fit(DEMONSTRATIONS)


def test_a_motion_is_the_generated_path_and_says_that_it_reached_the_end(policy):
    for demonstration in DEMONSTRATIONS:
        start = demonstration.positions[0]
        motion = policy.motion(demonstration.frames, start)
        np.testing.assert_array_equal(
            motion.positions, policy.generate(demonstration.frames, start)
        )
        assert (motion.ended, motion.dt) == ("end", policy.dt)
        assert motion.deviations.shape == (len(motion.positions),)
        assert motion.deviations.max() < 5.0


def test_a_motion_that_slows_down_comes_to_rest():
    policy = TrajectoryTPGMM(end_radius=0.0, rest_speed=0.3).fit(DEMONSTRATIONS)
    motion = policy.motion(FRAMES, START)
    assert motion.ended == "rest"
    assert len(motion.positions) < policy.max_samples
    always = TrajectoryTPGMM(end_radius=0.0, rest_speed=0.3, outside=0.0).fit(DEMONSTRATIONS)
    assert always.motion(FRAMES, START).ended == "left"


def test_a_motion_that_nothing_ends_says_that_its_time_is_over():
    settings = {"end_radius": 0.0, "rest_speed": 0.0}
    policy = TrajectoryTPGMM(**settings, step_limit=1.0, outside=1e6).fit(DEMONSTRATIONS)
    motion = policy.motion(FRAMES, START)
    assert motion.ended == "time"
    assert len(motion.positions) == policy.max_samples


def test_a_motion_from_far_away_has_left_the_data_and_can_be_stopped():
    settings = {"end_radius": 0.0, "rest_speed": 0.0, "position_floor": 1e-3}
    policy = TrajectoryTPGMM(**settings).fit(DEMONSTRATIONS)
    far = START + np.array([0.0, 0.0, 50.0])
    motion = policy.motion(FRAMES, far)
    assert motion.deviations[0] > 8.0
    assert (motion.ended == "left") is bool(motion.deviations[-1] > 8.0)
    stopped = TrajectoryTPGMM(**settings, stop_outside=True).fit(DEMONSTRATIONS)
    ended = stopped.motion(FRAMES, far)
    assert (ended.ended, len(ended.positions)) == ("left", 1)
    np.testing.assert_array_equal(ended.positions, stopped.generate(FRAMES, far))


def test_the_density_is_high_on_demonstrations_and_falls_away_from_them(policy):
    for demonstration in DEMONSTRATIONS:
        path = demonstration.positions
        near = policy.log_density(demonstration.frames, path)
        densities = [
            policy.log_density(demonstration.frames, path + [0.0, 0.0, offset]).mean()
            for offset in (0.0, 0.3, 1.0, 3.0)
        ]
        assert near.shape == (len(path),)
        assert (np.diff(densities) < 0.0).all()


def test_a_drawn_path_s_first_steps_have_the_moments_of_the_regression():
    policy = TrajectoryTPGMM(samples=10).fit(DEMONSTRATIONS)
    paths = policy.sample(FRAMES, START, np.random.default_rng(0), 4000)
    assert paths.shape == (4000, len(policy.generate(FRAMES, START)), 3)
    regression = policy.model.regression(FRAMES, policy.fusion, shared=policy.shared)
    mean, covariance = regression(START[None])
    steps = paths[:, 1] - paths[:, 0]
    np.testing.assert_array_equal(paths[:, 0], np.tile(START, (4000, 1)))
    spread = np.sqrt(np.trace(covariance[0]))
    np.testing.assert_allclose(steps.mean(axis=0), mean[0], atol=0.1 * spread)
    np.testing.assert_allclose(np.cov(steps.T), covariance[0], atol=0.1 * spread**2)
    again = policy.sample(FRAMES, START, np.random.default_rng(0), 4000)
    np.testing.assert_array_equal(again, paths)


def test_a_timed_policy_is_drawn_from_and_asked_at_its_times():
    policy = TimeTPGMM(5).fit(DEMONSTRATIONS)
    path = policy.generate(FRAMES)
    times = np.arange(len(path)) * policy.dt
    means, covariances = policy.at_times(FRAMES, times)
    paths = policy.sample(FRAMES, np.random.default_rng(0), 3000)
    for row in (0, 60, -1):
        scale = np.sqrt(np.trace(covariances[row]))
        np.testing.assert_allclose(paths[:, row].mean(axis=0), means[row], atol=0.1 * scale)
        np.testing.assert_allclose(np.cov(paths[:, row].T), covariances[row], atol=0.1 * scale**2)
    # Smooth as the mean is: no noise from one sample to the next.
    rough = np.abs(np.diff(paths[:20], n=2, axis=1)).max()
    assert rough < 20 * np.abs(np.diff(path, n=2, axis=0)).max()
    points = path + 0.01
    expected = [
        multivariate_normal(m, c).logpdf(x)
        for m, c, x in zip(means, covariances, points, strict=True)
    ]
    np.testing.assert_allclose(policy.log_density(FRAMES, times, points), expected, atol=1e-6)
    motion = policy.motion(FRAMES, START)
    np.testing.assert_array_equal(motion.positions, policy.generate(FRAMES, START))
    assert motion.ended == "time"
    assert motion.deviations[-1] == pytest.approx(0.0, abs=1e-9)
    assert motion.deviations[0] > 0.0


def test_an_augmented_policy_answers_as_the_one_it_ended_with():
    augmented = AugmentedTPGMM(AugmentOptions("noise", max_iterations=2)).fit(DEMONSTRATIONS)
    motion = augmented.motion(FRAMES, START)
    np.testing.assert_array_equal(motion.positions, augmented.generate(FRAMES, START))
    np.testing.assert_array_equal(
        augmented.log_density(FRAMES, motion.positions),
        augmented.policy.log_density(FRAMES, motion.positions),
    )
    drawn = augmented.sample(FRAMES, START, np.random.default_rng(0), 2)
    assert drawn.shape == (2, *motion.positions.shape)


def test_unusable_questions_are_errors(policy):
    timed = TimeTPGMM(3).fit(DEMONSTRATIONS)
    with pytest.raises(InvalidInputError, match="rng"):
        policy.sample(FRAMES, START, None)
    with pytest.raises(InvalidInputError, match="number of paths"):
        timed.sample(FRAMES, np.random.default_rng(0), 0)
    with pytest.raises(InvalidInputError, match="points"):
        timed.log_density(FRAMES, [0.0, 1.0], np.zeros((3, 3)))
    with pytest.raises(InvalidInputError, match="points"):
        policy.log_density(FRAMES, np.zeros((3, 2)))
    for settings in ({"outside": -1.0}, {"stop_outside": 1}):
        with pytest.raises(InvalidInputError, match="outside"):
            TrajectoryTPGMM(**settings)
