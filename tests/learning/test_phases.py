import numpy as np
import pytest
from learning_tasks import (
    moved,
    moved_frames,
    reaching_demonstrations,
    reaching_situation,
)

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    TPGMM,
    Alignment,
    AugmentOptions,
    Clock,
    SyntheticDemonstration,
    TimeTPGMM,
    TrajectoryTPGMM,
    load_model,
    rotation,
    save_model,
)
from dressing_sim.learning.augmented import AugmentedTPGMM

FRAMES = reaching_situation(np.random.default_rng(8))
FIRST, SECOND = reaching_demonstrations(2)


def timed(alignment):
    return TimeTPGMM(5, floor=0.01, ridge=0.01, relative_floor=True, alignment=alignment)


def trajectory(alignment):
    return TrajectoryTPGMM(alignment=alignment)


MODELS = pytest.mark.parametrize("make", [timed, trajectory])


def with_path(demonstration, positions, dt=None):
    return SyntheticDemonstration(positions, dt or demonstration.dt, demonstration.frames)


def path_of(make, demonstrations, alignment):
    return make(alignment).fit(demonstrations).generate(FRAMES, FRAMES[0].b)


def apart(one, other):
    """The largest distance between two paths of the same length, or infinity."""
    return np.abs(one - other).max() if one.shape == other.shape else np.inf


def slower(demonstration):
    return with_path(demonstration, demonstration.positions, 2.0 * demonstration.dt)


def at_a_kilohertz(demonstration):
    path = demonstration.positions
    times = np.arange(len(path)) * demonstration.dt
    fine = np.arange(round(times[-1] / 1e-3) + 1) * 1e-3
    return with_path(demonstration, np.stack([np.interp(fine, times, c) for c in path.T], 1), 1e-3)


def resting(before, after):
    def rests(demonstration):
        path = demonstration.positions
        first = np.repeat(path[:1], round(before / demonstration.dt), axis=0)
        last = np.repeat(path[-1:], round(after / demonstration.dt), axis=0)
        return with_path(demonstration, np.concatenate([first, path, last]))

    return rests


@MODELS
@pytest.mark.parametrize(
    ("change", "apart_without"),
    [(slower, 0.005), (at_a_kilohertz, 0.002), (resting(10, 0), 0.01), (resting(5, 5), 0.01)],
    ids=["half as fast", "1 kHz", "10 s of rest", "5 s at both ends"],
)
def test_on_one_clock_neither_speed_nor_sampling_nor_rest_moves_the_path(
    make, change, apart_without
):
    pair = [FIRST, change(SECOND)]
    plain = path_of(make, [FIRST, SECOND], Alignment())
    # Rounding alone, and half a millimetre where a path is sampled anew.
    assert apart(path_of(make, pair, Alignment()), plain) < 5e-4
    without = apart(path_of(make, pair, None), path_of(make, [FIRST, SECOND], None))
    # A model of displacements samples anew in any case: only the sampling rate does it no harm.
    assert without > apart_without or (make is trajectory and change is at_a_kilohertz)


def test_the_common_duration_is_the_geometric_mean_and_the_samples_are_as_many_as_asked_for():
    pair = [FIRST, slower(SECOND)]
    clock = Clock.of(pair, Alignment(still=0.0, samples=50))
    assert clock.times[-1] == pytest.approx(np.sqrt(2.0) * 119 * 0.05)
    for one in clock.align(pair):
        assert one.positions.shape == (50, 3)
        assert one.dt == clock.dt == pytest.approx(clock.times[-1] / 49)
    policy = TimeTPGMM(5, alignment=Alignment(samples=50)).fit(pair)
    assert len(policy.generate(FRAMES)) == 50


def test_a_demonstration_alone_keeps_its_own_time():
    clock = Clock.of([FIRST], Alignment(still=0.0, samples=239))
    (one,) = clock.align([FIRST])
    np.testing.assert_allclose(one.positions[::2], FIRST.positions, atol=1e-9)


def test_the_same_motion_at_another_rhythm_passes_each_place_at_the_same_time():
    """Slow at first and fast at last, and the reverse, of the same path: both end up alike."""
    times = np.linspace(0.0, 1.0, 120)
    own = np.arange(120) / 119.0
    paths = [
        np.stack([np.interp(times**power, own, c) for c in FIRST.positions.T], 1)
        for power in (0.6, 1.7)
    ]
    pair = [with_path(FIRST, path) for path in paths]
    assert np.abs(paths[0] - paths[1]).max() > 0.2
    one, other = Clock.of(pair, Alignment()).align(pair)
    assert np.abs(one.positions - other.positions).max() < 0.01


def test_the_clock_turns_and_shifts_with_the_world_and_has_no_unit():
    turn, shift = rotation([0.4, -1.1, 2.0]), np.array([1e3, -2.0, 0.5])
    pair = [FIRST, slower(SECOND)]
    plain = Clock.of(pair, Alignment()).align(pair)
    other = [moved(one, turn, shift) for one in pair]
    for a, b in zip(plain, Clock.of(other, Alignment()).align(other), strict=True):
        np.testing.assert_allclose(b.positions, a.positions @ turn.T + shift, atol=1e-6)
        assert b.dt == pytest.approx(a.dt)
    # A path found in one world is the one found in the other.
    path = path_of(timed, pair, Alignment())
    policy = timed(Alignment()).fit(other)
    asked = moved_frames(FRAMES, turn, shift)
    found = policy.generate(asked, turn @ FRAMES[0].b + shift)
    np.testing.assert_allclose(found, path @ turn.T + shift, atol=1e-5)


@pytest.mark.parametrize("keep", [slice(0, 60), slice(55, None)], ids=["end", "start"])
def test_a_demonstration_cut_short_is_an_error_that_names_it_or_taken_as_it_is(keep):
    part = with_path(SECOND, SECOND.positions[keep])
    with pytest.raises(InvalidInputError, match=r"demonstration 1 .*least_share=0"):
        Clock.of([FIRST, part], Alignment())
    assert len(Clock.of([FIRST, part], Alignment(least_share=0.0)).align([part])) == 1


@pytest.mark.parametrize("encoding", ["time", "trajectory"])
def test_the_bare_model_has_the_option_too(encoding):
    pair = [FIRST, slower(SECOND)]
    model = TPGMM(4, encoding=encoding, floor=1e-4, alignment=Alignment(samples=60)).fit(pair)
    _, lengths = model.samples([slower(FIRST), SECOND, SECOND])
    assert lengths == [60 if encoding == "time" else 59] * 3
    assert model.log_likelihood(pair) == pytest.approx(model.log_likelihood([FIRST, SECOND]))
    if encoding == "trajectory":
        assert model.step_time == model.clock.dt


@MODELS
def test_a_refit_and_costs_keep_the_clock(make):
    policy = make(Alignment()).fit([FIRST, slower(SECOND)])
    other = policy.refit([FIRST, at_a_kilohertz(SECOND)])
    assert other.clock is policy.clock
    assert other.dt == policy.dt
    costs = [policy.cost([change(SECOND)]) for change in (slower, resting(3, 0), lambda one: one)]
    assert np.ptp(costs) < 1e-3 * np.mean(costs)
    assert make(None).fit([FIRST, SECOND]).clock is None


@MODELS
def test_a_saved_policy_keeps_its_clock(make, tmp_path):
    policy = make(Alignment(samples=80, width=0.1)).fit([FIRST, SECOND])
    other = load_model(save_model(policy, tmp_path / "policy.npz"))
    np.testing.assert_array_equal(
        other.generate(FRAMES, FRAMES[0].b), policy.generate(FRAMES, FRAMES[0].b)
    )
    assert other.alignment == policy.alignment
    assert other.cost([slower(FIRST)]) == policy.cost([slower(FIRST)])


def test_algorithm_1_runs_on_the_clock():
    options = AugmentOptions("rf", max_iterations=3)
    policy = AugmentedTPGMM(options, policy=trajectory(Alignment(samples=60)))
    policy.fit([FIRST, slower(SECOND)])
    assert policy.policy.clock is not None
    assert np.isfinite(policy.generate(FRAMES, FRAMES[0].b)).all()


@pytest.mark.parametrize(
    "settings",
    [{"still": -1.0}, {"still": np.nan}, {"samples": 3}, {"width": 0.0}, {"least_share": 2.0}],
)
def test_unusable_alignments_are_errors(settings):
    with pytest.raises(InvalidInputError, match=next(iter(settings))):
        Alignment(**settings)
    with pytest.raises(InvalidInputError, match="alignment"):
        TimeTPGMM(alignment=True)
