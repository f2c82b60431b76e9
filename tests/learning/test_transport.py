import numpy as np
import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import rotation
from dressing_sim.learning.carried import CarriedDemonstrations
from dressing_sim.learning.registration import Phased, by_length, in_phase, moving
from dressing_sim.learning.transport import Transport, rigid_motion

LANDMARKS = np.random.default_rng(7).uniform(-1.0, 1.0, (12, 3))
TURN, SHIFT = rotation([0.4, -0.8, 2.0]), np.array([0.3, -1.0, 2.0])


def motion(points):
    return points @ TURN.T + SHIFT


def wave(phase):
    return np.column_stack([phase, 0.2 * np.sin(3.0 * phase), 0.1 * phase**2])


def carried(features=(0.2, 0.9), slope_to_noise=5.0, spread=0.01, count=2):
    """Demonstrations of one wave whose situations differ by a motion, and whose heights by more."""
    path, heights = wave(np.linspace(0.0, 1.0, 50)), spread * np.arange(count)
    points = np.stack([path + [0.0, 0.0, height] for height in heights])
    times = np.tile(np.linspace(0.0, 4.0, 50), (count, 1))
    landmarks = np.stack([LANDMARKS] * count)
    return CarriedDemonstrations(
        points, times, landmarks, np.array(features[:count]), 0.5, 0.05, slope_to_noise
    )


def test_the_rigid_motion_is_found_and_is_no_reflection(rng):
    turn, shift = rigid_motion(LANDMARKS, motion(LANDMARKS))
    np.testing.assert_allclose(turn, TURN, atol=1e-12)
    np.testing.assert_allclose(shift, SHIFT, atol=1e-12)
    turn, _ = rigid_motion(LANDMARKS, LANDMARKS * [1.0, 1.0, -1.0])
    assert np.linalg.det(turn) == pytest.approx(1.0)


def test_a_rigid_move_is_exact_everywhere_and_certain():
    transport = Transport.between(LANDMARKS, motion(LANDMARKS), 0.4, 0.05)
    far = 10.0 * LANDMARKS
    np.testing.assert_allclose(transport(far), motion(far), atol=1e-9)
    assert transport.deviation(far).max() < 1e-9


def test_landmarks_go_to_landmarks_up_to_the_noise(rng):
    targets = motion(LANDMARKS) + 0.1 * rng.standard_normal(LANDMARKS.shape)
    for noise, error in ((1e-4, 1e-5), (0.3, 0.1)):
        transport = Transport.between(LANDMARKS, targets, 0.4, noise)
        np.testing.assert_allclose(transport(LANDMARKS), targets, atol=error)


def test_far_from_landmarks_the_rigid_motion_remains_and_is_uncertain(rng):
    targets = LANDMARKS + 0.1 * rng.standard_normal(LANDMARKS.shape)
    transport = Transport.between(LANDMARKS, targets, 0.3, 0.05)
    turn, shift = rigid_motion(LANDMARKS, targets)
    far = np.array([[30.0, -20.0, 10.0]])
    np.testing.assert_allclose(transport(far), far @ turn.T + shift, atol=1e-12)
    assert transport.deviation(far)[0] == pytest.approx(transport.amplitude)
    assert transport.deviation(LANDMARKS).max() < 0.2 * transport.amplitude
    assert 0.05 < transport.amplitude < 0.2


def test_transport_moves_along_with_both_situations_and_with_units(rng):
    targets = LANDMARKS + 0.1 * rng.standard_normal(LANDMARKS.shape)
    points = rng.uniform(-1.0, 1.0, (20, 3))
    here = Transport.between(LANDMARKS, targets, 0.4, 0.05)
    there = Transport.between(LANDMARKS, motion(targets), 0.4, 0.05)
    np.testing.assert_allclose(there(points), motion(here(points)), atol=1e-9)
    from_there = Transport.between(motion(LANDMARKS), targets, 0.4, 0.05)
    np.testing.assert_allclose(from_there(motion(points)), here(points), atol=1e-9)
    in_mm = Transport.between(1e3 * LANDMARKS, 1e3 * targets, 400.0, 0.05)
    np.testing.assert_allclose(in_mm(1e3 * points), 1e3 * here(points), atol=1e-6)
    np.testing.assert_allclose(in_mm.deviation(1e3 * points), 1e3 * here.deviation(points))


@pytest.mark.parametrize(("length", "noise"), [(0.0, 0.1), (1.0, 0.0), (np.nan, 0.1)])
def test_transport_refuses_what_means_nothing(length, noise):
    with pytest.raises(InvalidInputError):
        Transport.between(LANDMARKS, LANDMARKS, length, noise)
    with pytest.raises(InvalidInputError, match="landmarks"):
        Transport.between(LANDMARKS, LANDMARKS[:-1], 1.0, 0.1)


def test_standing_still_is_trimmed_at_both_ends():
    path = wave(np.linspace(0.0, 1.0, 100))
    still = np.concatenate([np.tile(path[0], (300, 1)), path, np.tile(path[-1], (50, 1))])
    rows = moving(still, 2e-3)
    assert 295 <= rows.start <= 300
    assert 400 <= rows.stop <= 405
    assert moving(np.zeros((5, 3)), 2e-3) == slice(0, 5)


def test_pieces_are_even_in_length_and_know_their_times():
    time = np.linspace(0.0, 1.0, 201)
    path = np.column_stack([time**2, np.zeros(201)])
    phased = by_length(path, 0.01, [100], 11)
    np.testing.assert_allclose(phased.points[[0, 10, 20], 0], [0.0, 0.25, 1.0], atol=1e-6)
    np.testing.assert_allclose(np.diff(phased.points[:11, 0]), 0.025, atol=1e-6)
    np.testing.assert_allclose(phased.times[[0, 10, 20]], [0.0, 1.0, 2.0], atol=1e-6)
    with pytest.raises(InvalidInputError, match="cuts"):
        by_length(path, 0.01, [200], 11)


def test_paths_that_dwell_elsewhere_are_brought_into_phase():
    """One path twice, at other speeds and with a detour: alike places get alike phases."""
    even = np.linspace(0.0, 1.0, 400)
    first = wave(even)
    second = wave(even) + np.column_stack(
        [0 * even, 0 * even, 0.15 * np.exp(-(((even - 0.3) / 0.05) ** 2))]
    )
    apart = [by_length(path, 0.01, [200], 60) for path in (first, second)]
    together = in_phase(apart, [LANDMARKS, LANDMARKS], 0.5, 0.05, 0.05)

    def off(paths):
        return np.abs(paths[0].points[:, 0] - paths[1].points[:, 0]).max()

    assert off(together) < 0.6 * off(apart)
    for path in together:
        assert np.all(np.diff(path.times) >= 0.0)
    np.testing.assert_array_equal(together[1].points[[0, -1]], apart[1].points[[0, -1]])


def test_alignment_of_a_path_with_itself_changes_nothing():
    path = by_length(wave(np.linspace(0.0, 1.0, 100)), 0.01, [40], 30)
    again = in_phase(
        [path, Phased(motion(path.points), path.times, path.cuts)],
        [LANDMARKS, motion(LANDMARKS)],
        0.5,
        0.05,
        0.05,
    )
    np.testing.assert_allclose(again[1].points, motion(path.points), atol=1e-9)


def test_one_demonstration_is_carried_as_it_is():
    answer = carried(count=1).answer(motion(LANDMARKS), 0.9)
    np.testing.assert_allclose(answer.points, motion(wave(np.linspace(0.0, 1.0, 50))), atol=1e-9)
    assert answer.deviation.max() < 1e-9


def test_alike_situations_give_the_mean_and_no_slope_gives_it_everywhere():
    for model in (carried(features=(0.5, 0.5)), carried(slope_to_noise=0.0)):
        answer = model.answer(LANDMARKS, 1.0)
        np.testing.assert_allclose(answer.points, model.points.mean(axis=0), atol=1e-9)


def test_a_strong_belief_in_the_slope_draws_the_line_through_both():
    model = carried(slope_to_noise=1e4)
    for feature, height in ((0.2, 0.0), (0.9, 0.01), (1.6, 0.02)):
        answer = model.answer(LANDMARKS, feature)
        np.testing.assert_allclose(
            answer.points - model.points[0], [[0, 0, height]] * 50, atol=1e-6
        )


def test_the_regression_is_that_of_a_gaussian_process_with_the_same_prior():
    """The closed form against a linear-kernel Gaussian process with a nearly flat prior of c."""
    ratio, features, height = 3.0, np.array([0.2, 0.9, 0.5]), np.array([0.0, 0.01, 0.02])
    model = carried(features=features, slope_to_noise=ratio, count=3)
    centred, asked = features - features.mean(), 1.4 - features.mean()
    flat = 1e6
    kernel = flat + ratio**2 * np.outer(centred, centred) + np.eye(3)
    across = flat + ratio**2 * centred * asked
    expected = across @ np.linalg.solve(kernel, height)
    answer = model.answer(LANDMARKS, 1.4)
    found = (answer.points - model.points[0])[:, 2]
    np.testing.assert_allclose(found, expected, atol=1e-6)
    variance = flat + (ratio * asked) ** 2 - across @ np.linalg.solve(kernel, across)
    at_mean = model.answer(LANDMARKS, float(features.mean()))
    share = answer.deviation[0] ** 2 / at_mean.deviation[0] ** 2
    assert share == pytest.approx((1.0 + variance) / (1.0 + 1.0 / 3.0), rel=1e-3)


def test_the_deviation_is_that_of_demonstrations(rng):
    """Drawn from the model, nine of ten demonstrations are within 1.64 deviations."""
    inside = []
    for _ in range(100):
        features, slope = rng.uniform(0.0, 1.0, 5), 0.05 * rng.standard_normal((50, 3))
        base, z = wave(np.linspace(0.0, 1.0, 50)), features - 0.5
        paths = base + z[:, None, None] * slope + 0.01 * rng.standard_normal((5, 50, 3))
        model = CarriedDemonstrations(
            paths[:4],
            np.tile(np.linspace(0.0, 4.0, 50), (4, 1)),
            np.stack([LANDMARKS] * 4),
            features[:4],
            0.5,
            0.05,
            5.0,
        )
        answer = model.answer(LANDMARKS, features[4])
        inside.append(np.abs(answer.points - paths[4]) < 1.645 * answer.deviation[:, None])
    assert 0.87 < np.mean(inside) < 0.93


def test_the_duration_follows_the_demonstrations_and_the_length():
    model = carried()
    assert model.answer(LANDMARKS, 0.5).times[-1] == pytest.approx(4.0, rel=0.02)
    twice = carried()
    slow = CarriedDemonstrations(
        twice.points,
        twice.times * np.array([[1.0], [4.0]]),
        twice.landmarks,
        twice.features,
        0.5,
        0.05,
        5.0,
    )
    assert slow.answer(LANDMARKS, 0.5).times[-1] == pytest.approx(8.0, rel=0.02)
