from dataclasses import dataclass, fields

import numpy as np
import pytest
from learning_tasks import (
    PLANAR_FILE,
    needs_reference,
    reaching_demonstrations,
    reaching_situation,
)

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    METHODS,
    AugmentOptions,
    Frame,
    TimeTPGMM,
    TrajectoryTPGMM,
    augment,
)
from dressing_sim.learning.demonstrations import SyntheticDemonstration
from dressing_sim.planar.files import load
from dressing_sim.planar.study import StudyConfig, run_study

EXPERTS = reaching_demonstrations(2, seed=4)
FRESH = reaching_demonstrations(2, seed=40)
OPTION_NAMES = {field.name for field in fields(AugmentOptions)}
ALL_METHODS = pytest.mark.parametrize("method", METHODS)


def run(method="rf", seed=0, **settings):
    given = {name: settings.pop(name) for name in OPTION_NAMES & set(settings)}
    options = AugmentOptions(method, **{"max_demonstrations": 5, "max_iterations": 15, **given})
    return augment(EXPERTS, rng=np.random.default_rng(seed), options=options, **settings)


@ALL_METHODS
def test_the_history_is_the_whole_story(method):
    result = run(method)
    cost, count = result.initial_cost, len(EXPERTS)
    for number, candidate in enumerate(result.history, start=1):
        assert candidate.iteration == number
        assert candidate.accepted == (candidate.cost < cost)
        if candidate.accepted:
            cost, count = candidate.cost, count + 1
            assert candidate.policy.cost(EXPERTS) == candidate.cost
        else:
            assert candidate.policy is None
        assert candidate.n_demonstrations == count
    assert result.cost == cost == result.policy.cost(EXPERTS)
    assert result.demonstrations[:2] == tuple(EXPERTS)
    assert result.demonstrations[2:] == tuple(c.demonstration for c in result.accepted)


@ALL_METHODS
def test_the_same_seed_gives_the_same_bits(method):
    a, b, c = run(method, 1), run(method, 1), run(method, 2)
    assert [x.cost for x in a.history] == [x.cost for x in b.history]
    assert [x.cost for x in a.history] != [x.cost for x in c.history]
    frames = reaching_situation(np.random.default_rng(5))
    np.testing.assert_array_equal(
        a.policy.generate(frames, frames[0].b), b.policy.generate(frames, frames[0].b)
    )


def test_the_policy_given_is_not_changed():
    policy = TimeTPGMM(4)
    result = run(policy=policy)
    assert policy.model.mixture is None
    assert isinstance(result.policy, TimeTPGMM)


def test_it_ends_at_the_first_of_the_two_limits():
    by_iterations = run(max_demonstrations=100, max_iterations=4)
    assert len(by_iterations.history) == 4
    by_size = run("noise", max_demonstrations=3, max_iterations=500, snr_db=45)
    assert len(by_size.demonstrations) == 3
    assert by_size.history[-1].accepted
    assert run(max_demonstrations=2).history == ()
    assert run(max_iterations=0).history == ()


def test_as_printed_it_ends_once_both_limits_are_reached_or_it_gives_up():
    both = run("noise", max_demonstrations=3, max_iterations=6, snr_db=45, termination="both")
    assert len(both.history) >= 6
    assert len(both.demonstrations) >= 3
    hopeless = run("noise", max_iterations=2, snr_db=-40, termination="both")
    assert len(hopeless.history) == 40


def test_generalisation_selection_looks_at_the_validation_set():
    result = run(validation=FRESH, max_iterations=25)
    assert result.initial_cost == result.initial_policy.cost(FRESH)
    assert result.cost == result.policy.cost(FRESH) <= result.initial_cost


def test_noise_keeps_the_situation_and_random_frames_do_not():
    expert_frames = {demonstration.frames for demonstration in EXPERTS}
    noise, rf = run("noise"), run("rf")
    assert {c.demonstration.frames for c in noise.history} <= expert_frames
    assert not {c.demonstration.frames for c in rf.history} & expert_frames


def test_copies_are_the_experts_themselves():
    paths = {one.positions.tobytes() for one in map(_kept, EXPERTS)}
    assert {c.demonstration.positions.tobytes() for c in run("copies").history} <= paths


def _kept(expert):
    return SyntheticDemonstration(expert.positions, expert.dt, expert.frames)


def test_copies_gain_by_expectation_maximisation_going_on():
    again = run("copies", max_iterations=1)
    first = again.history[0]
    policy = again.initial_policy.refit((*EXPERTS, first.demonstration))
    assert first.cost == policy.cost(EXPERTS)


def test_noise_is_added_to_what_the_random_frames_give():
    def roughness(result):
        paths = [c.demonstration.positions for c in result.history]
        return np.mean([np.abs(np.diff(path, 3, axis=0)).mean() for path in paths])

    assert roughness(run("rf+noise")) > 10 * roughness(run("rf"))


@dataclass
class OneSituation:
    """A sampler that a task would bring."""

    frames: tuple

    def sample(self, rng):
        return self.frames


def test_a_tasks_own_sampler_decides_the_situations():
    frames = reaching_situation(np.random.default_rng(77))
    result = run(sampler=OneSituation(frames))
    assert {c.demonstration.frames for c in result.history} == {frames}


def test_a_candidate_that_fails_is_recorded_and_refused():
    mixed = EXPERTS[0].frames[:1]
    result = run(sampler=OneSituation(mixed), max_iterations=3)
    assert len(result.history) == 3
    for candidate in result.history:
        assert not candidate.accepted
        assert candidate.cost == np.inf
        assert "frames" in candidate.fault


def test_cold_retraining_starts_afresh():
    cold = run("noise", retrain="cold", max_iterations=4)
    first = cold.history[0]
    policy = TrajectoryTPGMM().fit(EXPERTS)
    assert policy.refit((*EXPERTS, first.demonstration), warm=False).cost(EXPERTS) == first.cost
    assert first.cost != run("noise", max_iterations=4).history[0].cost


def test_progress_is_told_of_every_candidate():
    seen = []
    result = run(on_iteration=seen.append)
    assert tuple(seen) == result.history


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"method": "dream"}, "noise, rf"),
        ({"termination": "never"}, "first, both"),
        ({"retrain": "hot"}, "warm, cold"),
        ({"noise_reference": "moon"}, "centred, world"),
        ({"max_iterations": -1}, "max_iterations"),
    ],
)
def test_unusable_settings_are_errors(arguments, message):
    with pytest.raises(InvalidInputError, match=message):
        run(**arguments)


@needs_reference
@pytest.mark.parametrize(
    ("method", "best", "mean", "sd"),
    [
        ("noise", 1.991, 2.015, 0.012),
        ("rf", 2.076, 2.119, 0.026),
        ("rf+noise", 2.035, 2.099, 0.030),
    ],
)
def test_the_papers_planar_runs(method, best, mean, sd):
    study = run_study(load(PLANAR_FILE), StudyConfig(methods=(method,)))
    costs = np.array([r.training_cost for r in study.of(method, "original")])
    assert len(costs) == 20
    assert costs.min() == pytest.approx(best, rel=0.015)
    assert costs.mean() == pytest.approx(mean, rel=0.015)
    assert costs.std(ddof=1) == pytest.approx(sd, rel=0.9)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("snr_db", np.nan),
        ("snr_db", np.inf),
        ("max_demonstrations", np.nan),
        ("max_iterations", -1),
    ],
)
def test_a_setting_out_of_range_is_an_error_that_names_it(name, value):
    with pytest.raises(InvalidInputError, match=name):
        run("noise", **{name: value})


def test_noise_needs_no_situations():
    """In one dimension there are no rotations to draw."""
    line = np.linspace(0.0, 1.0, 40)[:, None] ** 1.5
    frames = Frame(np.eye(1), [0.0]), Frame(np.eye(1), [1.0])
    experts = [SyntheticDemonstration(scale * line, 0.1, frames) for scale in (1.0, 1.1)]
    result = augment(
        experts, rng=np.random.default_rng(0), options=AugmentOptions("noise", max_iterations=3)
    )
    assert len(result.history) > 0
    assert all(candidate.fault is None for candidate in result.history)


@pytest.mark.parametrize(
    ("termination", "count", "iteration", "expected"),
    [
        ("first", 4, 9, True),
        ("first", 5, 9, False),
        ("first", 4, 10, False),
        ("both", 5, 10, False),
        ("both", 4, 10, True),
        ("both", 5, 9, True),
        ("both", 4, 199, True),
        ("both", 4, 200, False),
        ("both", 5, 0, True),
    ],
)
def test_the_loop_goes_on_up_to_its_limits(termination, count, iteration, expected):
    options = AugmentOptions(max_demonstrations=5, max_iterations=10, termination=termination)
    assert options.goes_on(count, iteration) is expected


def test_the_published_settings_are_the_defaults():
    options = AugmentOptions()
    assert (options.method, options.noise_reference) == ("rf", "centred")
    assert (options.max_demonstrations, options.max_iterations, options.snr_db) == (7, 100, 30.0)
    assert (options.termination, options.retrain) == ("first", "warm")
    assert AugmentOptions(max_demonstrations=0, max_iterations=0).goes_on(0, 0) is False


def test_noise_has_the_ratio_asked_for_against_the_demonstration_it_is_added_to():
    for snr_db in (20.0, 40.0):
        for candidate in run("noise", snr_db=snr_db, max_iterations=6).history:
            made = candidate.demonstration
            (expert,) = [e for e in EXPERTS if e.frames == made.frames]
            noise = made.positions - expert.positions
            power = np.mean((expert.positions - expert.positions.mean(axis=0)) ** 2)
            assert made.dt == expert.dt
            assert 10 * np.log10(power / np.mean(noise**2)) == pytest.approx(snr_db, abs=1.0)
