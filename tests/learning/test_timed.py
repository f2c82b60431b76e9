import numpy as np
import pytest
from learning_tasks import (
    PLANAR_FILE,
    moved,
    moved_frames,
    needs_reference,
    reaching_demonstrations,
    reaching_situation,
    rebased,
    rebased_frames,
)

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import Frame, Policy, SyntheticDemonstration, TimeTPGMM, rotation
from dressing_sim.planar.files import load


@needs_reference
@pytest.mark.parametrize(
    ("fusion", "cost"),
    [("regression-then-product", 2.1695696), ("product-then-regression", 1.48576)],
)
def test_the_papers_initial_training_cost(fusion, cost):
    demonstrations = load(PLANAR_FILE).training
    policy = TimeTPGMM(8, fusion=fusion).fit(demonstrations)
    assert policy.model.record.n_steps == 81
    assert policy.model.record.log_likelihoods[-1] == pytest.approx(5.592, abs=5e-4)
    digits = 5e-8 if cost > 2 else 5e-6
    assert policy.cost(demonstrations) == pytest.approx(cost, abs=digits)


@pytest.mark.parametrize("fusion", ["regression-then-product", "product-then-regression"])
def test_the_motion_turns_and_shifts_with_the_world(fusion):
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    demonstrations = reaching_demonstrations(3)
    frames = reaching_situation(np.random.default_rng(8))
    policy = TimeTPGMM(6, fusion=fusion)
    path = policy.fit(demonstrations).generate(frames)
    policy.fit([moved(d, turn, shift) for d in demonstrations])
    other = policy.generate(moved_frames(frames, turn, shift))
    np.testing.assert_allclose(other, path @ turn.T + shift, atol=1e-7)


def test_a_given_start_is_met_exactly_and_forgotten_later():
    policy = TimeTPGMM(5).fit(reaching_demonstrations(4))
    assert isinstance(policy, Policy)
    frames = reaching_situation(np.random.default_rng(8))
    free = policy.generate(frames)
    start = free[0] + np.array([0.1, 0.0, -0.1])
    path = policy.generate(frames, start)
    np.testing.assert_array_equal(path[0], start)
    quarter = len(path) // 4 + 1
    np.testing.assert_allclose(path[quarter:], free[quarter:], atol=1e-12)
    assert np.linalg.norm(np.diff(path, axis=0), axis=1).max() < 0.05


def test_covariances_are_positive_definite():
    policy = TimeTPGMM(5).fit(reaching_demonstrations(4))
    _, covariances = policy.at_times(reaching_situation(np.random.default_rng(8)), np.arange(0, 6))
    assert np.linalg.eigvalsh(covariances).min() > 0


def test_unequal_lengths_are_reproduced_at_their_own_times():
    demonstrations = [
        *reaching_demonstrations(2, seed=0, samples=110, dt=0.05),
        *reaching_demonstrations(2, seed=1, samples=250, dt=0.02),
    ]
    policy = TimeTPGMM(6, time_scale=0.01, floor=1e-5).fit(demonstrations)
    assert [len(policy.reproduce(d).positions) for d in demonstrations] == [110, 110, 250, 250]
    assert policy.dt == 0.02
    assert np.isfinite(policy.cost(demonstrations))


def test_unusable_settings_and_questions_are_errors():
    for arguments in ({"ridge": -1.0}, {"blend": 0.0}, {"blend": 2.0}):
        with pytest.raises(InvalidInputError):
            TimeTPGMM(**arguments)
    policy = TimeTPGMM(3)
    frames = reaching_situation(np.random.default_rng(8))
    with pytest.raises(InvalidInputError, match="fit"):
        policy.generate(frames)
    policy.fit(reaching_demonstrations(2))
    with pytest.raises(InvalidInputError, match="start"):
        policy.generate(frames, [0.0])


def test_a_timed_policy_generates_what_it_always_has():
    frames = reaching_situation(np.random.default_rng(3))
    policy = TimeTPGMM(4, ridge=1e-4, blend=0.5).fit(reaching_demonstrations(3))
    path = policy.generate(frames, frames[0].b)
    assert len(path) == 120
    expected = [(0.056319, 0.072691, -0.036655), (0.42202, 0.216864, 0.328032)]
    np.testing.assert_allclose(path[[35, -1]], expected, atol=1e-4)
    assert policy.cost(reaching_demonstrations(3)) == pytest.approx(0.2047821, rel=1e-3)


@pytest.mark.parametrize("blend", [0.25, 0.5, 1.0])
def test_the_offset_of_a_start_fades_by_a_minimum_jerk(blend):
    policy = TimeTPGMM(5, blend=blend).fit(reaching_demonstrations(4))
    frames = reaching_situation(np.random.default_rng(8))
    free, offset = policy.generate(frames), np.array([0.1, -0.2, 0.3])
    bent = policy.generate(frames, free[0] + offset)
    phase = np.minimum(np.linspace(0.0, 1.0, len(free)) / blend, 1.0)
    # The integral of 30 s^2 (1 - s)^2: at rest, and without acceleration, at both its ends.
    left = 1.0 - (10 * phase**3 - 15 * phase**4 + 6 * phase**5)
    np.testing.assert_allclose(bent - free, left[:, None] * offset, atol=1e-9)


def test_the_default_blend_is_a_quarter_and_time_runs_at_the_demonstrated_rate():
    policy = TimeTPGMM(5).fit(reaching_demonstrations(3, samples=81, dt=0.1))
    frames = reaching_situation(np.random.default_rng(8))
    assert (policy.dt, policy.duration) == (0.1, pytest.approx(8.0))
    free = policy.generate(frames)
    assert len(free) == 81
    moved_by = policy.generate(frames, free[0] + 0.1) - free
    assert np.abs(moved_by[20:]).max() < 1e-9
    assert np.abs(moved_by[19]).max() > 1e-6
    made = policy.synthesise(frames)
    np.testing.assert_array_equal(made.positions, free)
    assert made.dt == policy.dt


def test_the_edges_of_the_settings_are_allowed_and_nan_is_not():
    assert TimeTPGMM(ridge=0.0, blend=1.0).blend == 1.0
    for arguments in ({"ridge": np.nan}, {"blend": np.nan}):
        with pytest.raises(InvalidInputError):
            TimeTPGMM(**arguments)
    policy = TimeTPGMM(3).fit(reaching_demonstrations(2))
    with pytest.raises(InvalidInputError, match="start"):
        policy.generate(reaching_situation(np.random.default_rng(8)), [0.0, np.inf, 0.0])


@pytest.mark.parametrize("warm", [True, False])
def test_a_refit_starts_from_the_mixture_or_afresh(warm):
    policy = TimeTPGMM(4).fit(reaching_demonstrations(3))
    others = reaching_demonstrations(3, seed=5)
    refitted = (policy.refit(others) if warm else policy.refit(others, False)).model.fitted()
    model = TimeTPGMM(4).model.fit(others, policy.model.fitted() if warm else None)
    np.testing.assert_array_equal(refitted.means, model.fitted().means)


def in_unit(demonstration, factor):
    """The same demonstration in another unit of length."""
    frames = tuple(Frame(frame.A, factor * frame.b) for frame in demonstration.frames)
    return SyntheticDemonstration(factor * demonstration.positions, demonstration.dt, frames)


@pytest.mark.parametrize("fusion", ["regression-then-product", "product-then-regression"])
def test_what_is_relative_does_not_depend_on_the_unit_of_length(fusion):
    demonstrations = reaching_demonstrations(3)
    asked = reaching_demonstrations(1, seed=8)[0]
    settings = {"fusion": fusion, "floor": 0.01, "ridge": 0.01, "relative_floor": True}
    times = np.linspace(0, 5, 20)
    policy = TimeTPGMM(5, **settings).fit(demonstrations)
    means, covariances = policy.at_times(asked.frames, times)
    for factor in (1e3, 1e-3):
        other = TimeTPGMM(5, **settings).fit([in_unit(d, factor) for d in demonstrations])
        found = other.at_times(in_unit(asked, factor).frames, times)
        np.testing.assert_allclose(found[0], factor * means, atol=1e-7 * factor)
        np.testing.assert_allclose(found[1], factor**2 * covariances, atol=1e-7 * factor**2)


@pytest.mark.parametrize("fusion", ["regression-then-product", "product-then-regression"])
def test_a_relative_ridge_turns_with_the_world_and_its_frames(fusion):
    demonstrations = reaching_demonstrations(3)
    frames = reaching_situation(np.random.default_rng(8))
    settings = {"fusion": fusion, "floor": 0.01, "ridge": 0.1, "relative_floor": True}
    means, covariances = TimeTPGMM(5, **settings).fit(demonstrations).at_times(frames, [1.0, 4.0])
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([3.0, -2.0, 0.5])
    changes = (0.3 * rotation([1.0, 0.0, 0.5]), np.diag([-1.0, 1.0, 1.0]))
    other = [rebased(moved(d, turn, shift), changes) for d in demonstrations]
    asked = rebased_frames(moved_frames(frames, turn, shift), changes)
    found = TimeTPGMM(5, **settings).fit(other).at_times(asked, [1.0, 4.0])
    np.testing.assert_allclose(found[0], means @ turn.T + shift, atol=1e-7)
    np.testing.assert_allclose(found[1], turn @ covariances @ turn.T, atol=1e-7)


def test_the_least_variance_of_a_relative_ridge_is_its_share_of_the_data_s():
    demonstrations = reaching_demonstrations(3)
    one = [SyntheticDemonstration(d.positions, d.dt, d.frames[:1]) for d in demonstrations]
    plain = TimeTPGMM(5, relative_floor=True, ridge=0.0).fit(one)
    ridged = TimeTPGMM(5, relative_floor=True, ridge=0.2).fit(one)
    local = np.concatenate([d.frames[0].to_local(d.positions) for d in one])
    added = ridged.at_times(one[0].frames, [2.0])[1] - plain.at_times(one[0].frames, [2.0])[1]
    np.testing.assert_allclose(added[0], 0.2 * local.var(axis=0).mean() * np.eye(3), atol=1e-9)


def test_a_heavy_demonstration_is_reproduced_better():
    demonstrations = reaching_demonstrations(3, wobble=0.03)
    light, heavy = (TimeTPGMM().fit(demonstrations, w) for w in (None, [20.0, 1.0, 1.0]))
    assert heavy.cost(demonstrations[:1]) < 0.8 * light.cost(demonstrations[:1])


def at_places(frames, places):
    return [tuple(Frame(f.A, f.b + place) for f in frames) for place in places]


def test_frames_that_stand_still_are_a_situation():
    policy = TimeTPGMM().fit(reaching_demonstrations(3))
    frames = reaching_situation(np.random.default_rng(9))
    path = policy.generate(frames)
    followed = policy.follow([frames] * len(path))
    np.testing.assert_array_equal(followed, path)
    np.testing.assert_array_equal(
        policy.follow([frames] * len(path), start=[0, 0, 0]), policy.generate(frames, [0, 0, 0])
    )


def test_frames_that_move_together_carry_the_path_along(rng):
    policy = TimeTPGMM().fit(reaching_demonstrations(3))
    frames = reaching_situation(np.random.default_rng(9))
    path = policy.generate(frames)
    places = np.cumsum(0.01 * rng.standard_normal(path.shape), axis=0)
    followed = policy.follow(at_places(frames, places))
    np.testing.assert_allclose(followed, path + places, atol=1e-9)


def test_a_path_ends_where_the_last_frame_has_gone_and_knows_no_later_place():
    policy = TimeTPGMM().fit(reaching_demonstrations(3))
    start, end = reaching_situation(np.random.default_rng(9))
    still = policy.generate((start, end))
    shifts = np.linspace([0, 0, 0], [0.1, 0.0, -0.1], len(still))
    followed = policy.follow([(start, Frame(end.A, end.b + shift)) for shift in shifts])
    at_the_end = policy.generate((start, Frame(end.A, end.b + shifts[-1])))
    np.testing.assert_allclose(followed[-1], at_the_end[-1], atol=1e-9)
    half = len(still) // 2
    halted = [(start, Frame(end.A, end.b + shift)) for shift in shifts[:half]]
    np.testing.assert_array_equal(policy.follow(halted), followed[:half])


def test_frames_at_no_time_are_an_error():
    policy = TimeTPGMM().fit(reaching_demonstrations(2))
    with pytest.raises(InvalidInputError, match="situations"):
        policy.follow([])
