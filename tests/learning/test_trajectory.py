import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from learning_tasks import (
    moved,
    moved_frames,
    reaching,
    reaching_demonstrations,
    reaching_situation,
    rebased,
    rebased_frames,
)

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    Frame,
    Policy,
    SyntheticDemonstration,
    TrajectoryTPGMM,
    dtw_distance,
    rotation,
)

FUSION = pytest.mark.parametrize("fusion", ["regression-then-product", "product-then-regression"])


@pytest.fixture(scope="module")
def policy():
    return TrajectoryTPGMM().fit(reaching_demonstrations(5))


def test_it_is_a_policy(policy):
    assert isinstance(policy, Policy)


@FUSION
def test_it_reaches_in_new_situations_as_an_expert_would(fusion):
    # Low floors: six clean demonstrations say how far to trust each frame.
    policy = TrajectoryTPGMM(fusion=fusion, position_floor=0.01, displacement_floor=0.01)
    policy.fit(reaching_demonstrations(6, seed=3))
    rng = np.random.default_rng(100)
    misses, distances = [], []
    for _ in range(20):
        frames = reaching_situation(rng)
        expert = reaching(frames, rng, wobble=0.0)
        path = policy.generate(frames, frames[0].b)
        misses.append(np.linalg.norm(path[-1] - frames[1].b))
        distances.append(dtw_distance(path, expert.positions))
    # The way is 0.6 m long, and the two ends lie up to 0.35 m apart between situations.
    assert np.median(misses) < 0.06
    assert np.median(distances) < 0.04


def test_a_path_starts_exactly_where_it_is_told(policy):
    frames = reaching_situation(np.random.default_rng(3))
    start = frames[0].b + np.array([0.01, -0.02, 0.03])
    np.testing.assert_array_equal(policy.generate(frames, start)[0], start)


def test_the_same_question_has_the_same_answer_bit_for_bit(policy):
    frames = reaching_situation(np.random.default_rng(3))
    a, b = policy.generate(frames, frames[0].b), policy.generate(frames, frames[0].b)
    np.testing.assert_array_equal(a, b)


@FUSION
@pytest.mark.parametrize("shared", [False, True])
def test_the_motion_turns_and_shifts_with_the_world(fusion, shared):
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    demonstrations = reaching_demonstrations(3)
    frames = reaching_situation(np.random.default_rng(8))
    start = frames[0].b + 0.01
    policy = TrajectoryTPGMM(fusion=fusion, shared=shared)
    path = policy.fit(demonstrations).generate(frames, start)
    policy.fit([moved(d, turn, shift) for d in demonstrations])
    other = policy.generate(moved_frames(frames, turn, shift), turn @ start + shift)
    np.testing.assert_allclose(other, path @ turn.T + shift, atol=1e-6)


def test_scaled_and_mirrored_frames_give_the_same_motion():
    changes = (0.3 * rotation([1.0, 0.0, 0.5]), np.diag([-1.0, 1.0, 1.0]))
    demonstrations = reaching_demonstrations(3)
    frames = reaching_situation(np.random.default_rng(8))
    path = TrajectoryTPGMM().fit(demonstrations).generate(frames, frames[0].b)
    policy = TrajectoryTPGMM().fit([rebased(d, changes) for d in demonstrations])
    other = policy.generate(rebased_frames(frames, changes), frames[0].b)
    np.testing.assert_allclose(other, path, atol=1e-6)


def test_the_unit_of_length_does_not_matter():
    demonstrations = reaching_demonstrations(3)
    frames = reaching_situation(np.random.default_rng(8))
    path = TrajectoryTPGMM().fit(demonstrations).generate(frames, frames[0].b)

    def in_millimetres(frames):
        return tuple(Frame(frame.A, 1000 * frame.b) for frame in frames)

    scaled = [
        SyntheticDemonstration(1000 * d.positions, d.dt, in_millimetres(d.frames))
        for d in demonstrations
    ]
    other = TrajectoryTPGMM().fit(scaled).generate(in_millimetres(frames), 1000 * frames[0].b)
    np.testing.assert_allclose(other, 1000 * path, atol=1e-2)


@settings(max_examples=60, deadline=None)
@given(
    seed=st.integers(0, 2**32 - 1),
    reach=st.floats(0.0, 1e4),
    fusion=st.sampled_from(["regression-then-product", "product-then-regression"]),
    floor=st.sampled_from([1e-8, 1e-3, 1.0]),
)
def test_no_situation_makes_a_path_that_is_not_finite(seed, reach, fusion, floor):
    rng = np.random.default_rng(seed)
    demonstrations = reaching_demonstrations(2, seed=1)
    policy = TrajectoryTPGMM(fusion=fusion, position_floor=floor, displacement_floor=floor)
    policy.fit(demonstrations)
    frames = tuple(
        Frame(rotation(rng.uniform(-3, 3, 3)), rng.normal(0, 1 + reach, 3)) for _ in range(2)
    )
    path = policy.generate(frames, rng.normal(0, 1 + reach, 3))
    assert np.isfinite(path).all()
    assert 1 <= len(path) <= policy.max_samples
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    longest = max(
        np.linalg.norm(np.diff(d.positions, axis=0), axis=1).max() * policy.dt / d.dt
        for d in demonstrations
    )
    assert steps.max(initial=0.0) <= longest * (1 + 1e-6) + 1e-9 * reach


def test_a_demonstrated_rest_is_where_the_path_ends(policy):
    for demonstration in reaching_demonstrations(5):
        path = policy.generate(demonstration.frames, demonstration.positions[0])
        assert len(path) < policy.max_samples
        assert np.linalg.norm(path[-1] - demonstration.positions[-1]) < 0.1


def test_without_an_end_radius_the_path_still_ends():
    policy = TrajectoryTPGMM(end_radius=0.0).fit(reaching_demonstrations(5))
    frames = reaching_situation(np.random.default_rng(3))
    assert len(policy.generate(frames, frames[0].b)) <= policy.max_samples


def test_demonstrations_of_unequal_length_and_sampling():
    demonstrations = [
        *reaching_demonstrations(2, seed=0, samples=60, dt=0.1),
        *reaching_demonstrations(2, seed=1, samples=250, dt=0.02),
    ]
    policy = TrajectoryTPGMM().fit(demonstrations)
    durations = [(len(d.positions) - 1) * d.dt for d in demonstrations]
    assert policy.dt == pytest.approx(np.mean(durations) / 199)
    assert policy.cost(demonstrations) < 0.05


def test_the_path_moves_at_about_the_demonstrated_speed(policy):
    demonstration = reaching_demonstrations(1)[0]
    path = policy.generate(demonstration.frames, demonstration.positions[0])
    length = np.linalg.norm(np.diff(path, axis=0), axis=1).sum()
    expert = np.linalg.norm(np.diff(demonstration.positions, axis=0), axis=1).sum()
    speed = length / (policy.dt * (len(path) - 1))
    expert_speed = expert / (demonstration.dt * (len(demonstration.positions) - 1))
    assert 0.5 < speed / expert_speed < 2.0


def test_refitting_leaves_the_policy_as_it_is_and_keeps_its_time(policy):
    frames = reaching_situation(np.random.default_rng(3))
    before = policy.generate(frames, frames[0].b)
    other = policy.refit(reaching_demonstrations(3, seed=7, dt=0.02))
    np.testing.assert_array_equal(policy.generate(frames, frames[0].b), before)
    assert other.dt == policy.dt
    assert not np.array_equal(other.model.fitted().means, policy.model.fitted().means)


def test_a_synthetic_motion_starts_where_the_situation_says(policy):
    frames = reaching_situation(np.random.default_rng(3))
    made = policy.synthesise(frames)
    assert made.dt == policy.dt
    assert np.linalg.norm(made.positions[0] - frames[0].b) < 0.05
    for demonstration in reaching_demonstrations(5):
        assert not np.array_equal(made.positions[0], demonstration.positions[0])


def test_one_demonstration_and_doubled_ones_give_sound_models():
    one = reaching_demonstrations(1)
    for demonstrations in (one, one * 3):
        path = TrajectoryTPGMM().fit(demonstrations).generate(one[0].frames, one[0].positions[0])
        assert np.isfinite(path).all()
        assert dtw_distance(path, one[0].positions) < 0.03


@pytest.mark.parametrize(
    "arguments", [{"samples": 1}, {"step_limit": 0.5}, {"rest_speed": -1}, {"fusion": "neither"}]
)
def test_unusable_settings_are_errors(arguments):
    with pytest.raises(InvalidInputError):
        TrajectoryTPGMM(**arguments)


def test_unusable_questions_are_errors(policy):
    frames = reaching_situation(np.random.default_rng(3))
    with pytest.raises(InvalidInputError, match="start"):
        policy.generate(frames, [0, 0])
    with pytest.raises(InvalidInputError, match="start"):
        policy.generate(frames, [0, 0, np.nan])
    with pytest.raises(InvalidInputError, match="frames"):
        policy.generate(frames[:1], frames[0].b)
    with pytest.raises(InvalidInputError, match="fit"):
        TrajectoryTPGMM().generate(frames, frames[0].b)


@pytest.mark.parametrize("fusion", ["regression-then-product", "product-then-regression"])
@pytest.mark.parametrize("count", [1, 2])
def test_no_floor_at_all_is_a_clear_error_or_a_sound_path(fusion, count):
    line = np.linspace([0.0, 0, 0], [1.0, 0, 0], 50)
    frames = (Frame(np.eye(3), np.zeros(3)), Frame(np.eye(3), [1.0, 0, 0]))
    straight = SyntheticDemonstration(line, 0.1, frames)
    policy = TrajectoryTPGMM(fusion=fusion, position_floor=0.0, displacement_floor=0.0)
    for demonstrations in ([straight] * count, reaching_demonstrations(count)):
        fault, path = "covariance floor", np.zeros(3)
        try:
            path = policy.fit(demonstrations).generate(demonstrations[0].frames, np.zeros(3))
        except InvalidInputError as error:
            fault = str(error)
        assert "covariance floor" in fault
        assert np.isfinite(path).all()


def test_components_that_split_by_demonstration_do_no_harm_in_the_default_order():
    """Clean demonstrations that differ get components of their own; each frame alone sees which."""

    def frames(goal):
        return Frame(np.eye(3), np.zeros(3)), Frame(np.eye(3), goal)

    way = np.linspace(0.0, 1.0, 100)[:, None]
    demonstrations = [
        SyntheticDemonstration(way ** [1, bend, 3] * goal, 0.05, frames(goal))
        for goal, bend in (([0.5, 0.3, 0.2], 1.5), ([0.3, -0.3, 0.4], 3))
    ]
    assert TrajectoryTPGMM().fit(demonstrations).cost(demonstrations) < 0.01


@pytest.mark.parametrize(
    "name", ["samples", "end_radius", "rest_speed", "rest_count", "step_limit"]
)
@pytest.mark.parametrize("value", [np.nan, np.inf, -1.0])
def test_settings_that_no_policy_can_have_are_errors(name, value):
    with pytest.raises(InvalidInputError, match=name):
        TrajectoryTPGMM(**{name: value})


@pytest.mark.parametrize(
    ("settings", "cost", "points"),
    [
        (
            {},
            0.0251973,
            [(0.324133, 0.112922, 0.487962), (0.519154, 0.207003, 0.464338)],
        ),
        (
            {"position_floor": 1e-4, "displacement_floor": 1e-4, "relative_floor": False},
            0.0100566,
            [(0.4493, 0.18654, 0.517612), (0.674146, 0.208248, 0.577797)],
        ),
        (
            {"fusion": "product-then-regression"},
            0.0206183,
            [(0.34465, 0.119235, 0.526772), (0.642497, 0.251172, 0.534059)],
        ),
        (
            {"shrinkage": True},
            0.0284152,
            [(0.233673, 0.060048, 0.406534), (0.61587, 0.276268, 0.605148)],
        ),
        (
            {"end_radius": 0.0, "rest_speed": 0.1},
            0.0395747,
            [(0.324133, 0.112922, 0.487962), (0.519154, 0.207003, 0.464338)],
        ),
    ],
)
def test_a_policy_generates_what_it_always_has(settings, cost, points):
    """Fit, floors, fusion, shrinkage and the end of a motion, as published results have them."""
    demonstrations = reaching_demonstrations(3)
    frames = reaching_situation(np.random.default_rng(3))
    policy = TrajectoryTPGMM(**settings).fit(demonstrations)
    path = policy.generate(frames, frames[0].b)
    places = [int(share * (len(path) - 1)) for share in (0.3, 1.0)]
    np.testing.assert_allclose(path[places], points, atol=1e-4)
    assert policy.cost(demonstrations) == pytest.approx(cost, rel=1e-3)


def test_a_synthetic_motion_starts_where_the_demonstrations_say():
    frames = reaching_situation(np.random.default_rng(3))
    made = TrajectoryTPGMM().fit(reaching_demonstrations(3)).synthesise(frames)
    expected = [(-0.008894, -0.071994, 0.047743), (0.520354, 0.206426, 0.472628)]
    np.testing.assert_allclose(made.positions[[0, -1]], expected, atol=1e-4)


def test_the_least_settings_that_make_sense_are_allowed():
    TrajectoryTPGMM(samples=3, rest_count=1, step_limit=1, rest_speed=0, end_radius=0)
    for arguments in (
        {"samples": 2},
        {"samples": 60.5},
        {"rest_count": 0},
        {"rest_count": 5.5},
        {"step_limit": 0.99},
    ):
        with pytest.raises(InvalidInputError):
            TrajectoryTPGMM(**arguments)


@pytest.mark.parametrize("limit", [1.0, 2.0, 2.5])
def test_a_path_that_does_not_end_has_so_many_times_the_longest_demonstrations_samples(limit):
    demonstrations = [
        *reaching_demonstrations(1, seed=0, samples=61, dt=0.1),
        *reaching_demonstrations(1, seed=1, samples=41, dt=0.1),
    ]
    settings = {"samples": 51, "end_radius": 0.0, "rest_speed": 0.0}
    policy = TrajectoryTPGMM(step_limit=limit, **settings).fit(demonstrations)
    assert policy.dt == pytest.approx(0.1)
    assert policy.max_samples == round(60 * limit) + 1
    frames = demonstrations[0].frames
    assert len(policy.generate(frames, frames[0].b)) == policy.max_samples


def test_it_does_not_end_before_half_of_the_shortest_demonstration():
    demonstrations = [
        *reaching_demonstrations(1, seed=0, samples=61, dt=0.1),
        *reaching_demonstrations(1, seed=1, samples=41, dt=0.1),
    ]
    policy = TrajectoryTPGMM(samples=51, rest_speed=1e3, rest_count=1).fit(demonstrations)
    frames = demonstrations[0].frames
    # All of it is slow: half of the forty steps is the least.
    assert len(policy.generate(frames, frames[0].b)) in (20, 21)


@pytest.mark.parametrize("warm", [True, False])
def test_a_refit_starts_from_the_mixture_or_afresh(policy, warm):
    others = reaching_demonstrations(3, seed=7)
    refitted = (policy.refit(others) if warm else policy.refit(others, False)).model.fitted()
    fresh = TrajectoryTPGMM().model
    fresh.dt = policy.dt
    fresh.fit(others, policy.model.fitted() if warm else None)
    np.testing.assert_array_equal(refitted.means, fresh.fitted().means)


def test_one_frame_is_enough():
    demonstrations = [
        SyntheticDemonstration(d.positions, d.dt, d.frames[1:]) for d in reaching_demonstrations(3)
    ]
    policy = TrajectoryTPGMM().fit(demonstrations)
    frames = demonstrations[0].frames
    path = policy.generate(frames, demonstrations[0].positions[0])
    assert np.linalg.norm(path[-1] - frames[0].b) < 0.1
    assert policy.cost(demonstrations) < 0.1
    with pytest.raises(InvalidInputError, match="start must be 3"):
        policy.generate(frames, np.zeros(4))


def test_a_heavy_demonstration_is_reproduced_better():
    demonstrations = reaching_demonstrations(3, wobble=0.03)
    asked = demonstrations[0]

    def error(weights):
        policy = TrajectoryTPGMM().fit(demonstrations, weights)
        return dtw_distance(policy.generate(asked.frames, asked.positions[0]), asked.positions)

    assert error([20.0, 1.0, 1.0]) < 0.8 * error(None)
    assert error([1.0, 1.0, 1.0]) == pytest.approx(error(None))
