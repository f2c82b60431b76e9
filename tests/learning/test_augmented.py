from dataclasses import replace

import numpy as np
import pytest
from learning_tasks import reaching_demonstrations, reaching_situation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    AugmentOptions,
    BoundsSampler,
    Policy,
    TimeTPGMM,
    TrajectoryTPGMM,
    augment,
)
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.learning.demonstrations import SyntheticDemonstration
from dressing_sim.learning.frame import Frame
from dressing_sim.learning.storage import Storable

START = np.zeros(3)
RF = AugmentOptions("rf", max_iterations=30)


@pytest.fixture(scope="module")
def experts():
    return reaching_demonstrations(2)


@pytest.fixture(scope="module")
def fitted(experts):
    return AugmentedTPGMM(RF, seed=1).fit(experts)


@pytest.fixture
def situation(rng):
    return reaching_situation(rng)


def test_it_is_a_policy_that_can_be_stored(fitted):
    assert isinstance(fitted, Policy)
    assert isinstance(fitted, Storable)
    assert fitted.dt == fitted.policy.dt


def test_it_does_what_algorithm_1_ends_with(experts, fitted, situation):
    result = augment(experts, rng=np.random.default_rng(1), options=RF)
    expected = result.policy.generate(situation, START)
    np.testing.assert_array_equal(fitted.generate(situation, START), expected)
    assert fitted.costs[0] == result.initial_cost
    assert fitted.costs[-1] == result.cost
    assert len(fitted.costs) == len(fitted.tried) == 1 + len(result.accepted)


def test_costs_fall_and_candidates_count_up(fitted):
    assert len(fitted.costs) > 1, "no candidate was accepted: the test says nothing"
    assert (np.diff(fitted.costs) < 0).all()
    assert (np.diff(fitted.tried) > 0).all()
    assert fitted.tried[0] == 0


def test_it_is_fitted_afresh_each_time(experts, fitted, situation):
    others = reaching_demonstrations(2, seed=9)
    policy = AugmentedTPGMM(RF, seed=1).fit(others).fit(experts)
    path = policy.generate(situation, START)
    np.testing.assert_array_equal(path, fitted.generate(situation, START))
    assert policy.costs == fitted.costs


def test_the_seed_makes_a_difference(experts, fitted):
    other = AugmentedTPGMM(RF, seed=2).fit(experts)
    assert other.costs[0] == fitted.costs[0]
    assert other.costs[1:] != fitted.costs[1:]


def test_what_is_given_is_used_and_stays_as_it_is(experts):
    class Fixed:
        def sample(self, rng):
            asked.append(1)
            return experts[0].frames

    asked = []
    base = TrajectoryTPGMM(n_components=3)
    policy = AugmentedTPGMM(
        replace(RF, max_iterations=4), policy=base, sampler=lambda shown: Fixed()
    )
    policy.fit(experts)
    assert len(asked) == 4
    assert policy.policy.model.n_components == 3
    assert base.dt is None


def test_with_as_many_demonstrations_as_it_may_have_it_is_the_initial_policy(experts, situation):
    policy = AugmentedTPGMM(AugmentOptions("rf", max_demonstrations=2)).fit(experts)
    initial = TrajectoryTPGMM().fit(experts)
    path = policy.generate(situation, START)
    np.testing.assert_array_equal(path, initial.generate(situation, START))
    assert policy.costs == (initial.cost(experts),)


def test_it_comes_back_from_its_state(fitted, situation):
    copy = AugmentedTPGMM.from_state(*fitted.state())
    path = copy.generate(situation, START)
    np.testing.assert_array_equal(path, fitted.generate(situation, START))
    assert (copy.costs, copy.tried, copy.seed) == (fitted.costs, fitted.tried, fitted.seed)
    assert copy.options == fitted.options


def test_a_file_of_before_there_were_more_options_is_read(fitted):
    settings, arrays = fitted.state()
    for later in ("termination", "retrain"):
        del settings["settings"][later]
    assert AugmentedTPGMM.from_state(settings, arrays).options == fitted.options
    del settings["settings"]["snr_db"]
    with pytest.raises(KeyError):
        AugmentedTPGMM.from_state(settings, arrays)


def test_it_must_be_fitted_first(situation):
    with pytest.raises(InvalidInputError, match="fit"):
        AugmentedTPGMM().generate(situation, START)


def test_an_unknown_method_is_an_error():
    with pytest.raises(InvalidInputError, match=r"noise, rf, rf\+noise"):
        AugmentOptions("magic")


def test_bounds_around_the_demonstrations_are_the_default(experts):
    drawn = AugmentedTPGMM().sampler(experts).sample(np.random.default_rng(0))
    expected = BoundsSampler.around(experts).sample(np.random.default_rng(0))
    for frame, other in zip(drawn, expected, strict=True):
        np.testing.assert_array_equal(frame.A, other.A)
        np.testing.assert_array_equal(frame.b, other.b)


def test_every_fit_starts_from_the_policy_that_was_given(experts, situation):
    policy = TrajectoryTPGMM(initialisation="k-means", rng=np.random.default_rng(4))
    augmented = AugmentedTPGMM(replace(RF, max_iterations=5), policy=policy)
    once = augmented.fit(experts).generate(situation, START)
    np.testing.assert_array_equal(augmented.fit(experts).generate(situation, START), once)


def test_a_policy_of_another_kind_is_an_error_at_once():
    with pytest.raises(InvalidInputError, match="TimeTPGMM, valid is a TrajectoryTPGMM"):
        AugmentedTPGMM(policy=TimeTPGMM(4))


def test_noise_needs_no_situations():
    """In one dimension there are no rotations to draw."""
    line = np.linspace(0.0, 1.0, 40)[:, None] ** 1.5
    frames = Frame(np.eye(1), [0.0]), Frame(np.eye(1), [1.0])
    experts = [SyntheticDemonstration(scale * line, 0.1, frames) for scale in (1.0, 1.1)]
    policy = AugmentedTPGMM(AugmentOptions("noise", max_iterations=3)).fit(experts)
    assert np.isfinite(policy.generate(frames, [0.0])).all()
