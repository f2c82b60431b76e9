"""The two refinements of Algorithm 1: a mixture that grows, and use of what was discarded."""

import numpy as np
import pytest
from learning_tasks import reaching_demonstrations, reaching_situation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import AugmentOptions, TrajectoryTPGMM, augment
from dressing_sim.learning.augmented import AugmentedTPGMM
from dressing_sim.learning.components import bic
from dressing_sim.learning.refinements import discarded_weights, grown, with_discarded

EXPERTS = reaching_demonstrations(2, seed=4)
OTHERS = reaching_demonstrations(3, seed=5)


def run(policy=None, **options):
    few = {"max_demonstrations": 5, "max_iterations": 15}
    chosen = AugmentOptions("rf+noise", **few, **options)
    return augment(EXPERTS, rng=np.random.default_rng(0), options=chosen, policy=policy)


def test_a_policy_grows_where_both_measures_say_so():
    few = TrajectoryTPGMM(1).fit(EXPERTS)
    larger = few.larger(EXPERTS)
    assert larger.model.n_components == 2
    assert few.model.n_components == 1
    assert bic(larger.model, EXPERTS) < bic(few.model, EXPERTS)
    cost, costs = larger.cost(EXPERTS), few.cost(EXPERTS)
    policy, told = grown(few, costs, EXPERTS, EXPERTS)
    assert told == min(cost, costs)
    assert policy.model.n_components == (2 if cost <= costs else 1)
    # The cost may not rise.
    assert grown(few, 0.0, EXPERTS, EXPERTS) == (few, 0.0)


def test_a_policy_that_describes_all_it_can_does_not_grow():
    many = TrajectoryTPGMM(1).fit(EXPERTS)
    while (larger := many.larger(EXPERTS)) is not None:
        many = larger
    assert 1 < many.model.n_components < 60
    cost = many.cost(EXPERTS)
    assert grown(many, cost, EXPERTS, EXPERTS) == (many, cost)


def test_too_few_samples_do_not_carry_another_component():
    policy = TrajectoryTPGMM(2, samples=6).fit(EXPERTS[:1])
    with pytest.raises(InvalidInputError):
        policy.larger(EXPERTS[:1])
    assert grown(policy, 1.0, EXPERTS[:1], EXPERTS) == (policy, 1.0)


def test_algorithm_1_grows_as_it_keeps():
    plain, growing = run(TrajectoryTPGMM(1)), run(TrajectoryTPGMM(1), grow=True)
    assert growing.initial_cost == plain.initial_cost
    assert plain.policy.model.n_components == 1
    assert 1 < growing.policy.model.n_components <= 1 + len(growing.accepted)
    costs = [growing.initial_cost, *(one.cost for one in growing.accepted)]
    assert costs == sorted(costs, reverse=True)
    assert growing.cost == costs[-1] == growing.policy.cost(EXPERTS)


def test_what_harmed_less_counts_more_whatever_the_unit():
    weights = discarded_weights([1.0, 1.5, 3.0], 1.0, 2.0)
    assert weights.sum() == pytest.approx(2.0)
    # The mean excess is 2.5 / 3.
    np.testing.assert_allclose(weights / weights[0], np.exp([0.0, -0.6, -2.4]), rtol=1e-12)
    np.testing.assert_allclose(discarded_weights([1e3, 1.5e3, 3e3], 1e3, 2.0), weights, rtol=1e-12)
    np.testing.assert_allclose(discarded_weights([1.0, 1.0], 1.0, 3.0), 1.5)


def test_the_discarded_count_as_much_as_is_said():
    """With all of the same cost they are one demonstration of that weight, were they alike."""
    policy = TrajectoryTPGMM(3).fit(EXPERTS)
    same = [(OTHERS[0], 2.0)] * 4
    learned, cost = with_discarded(policy, 1e9, EXPERTS, same, 0.5, EXPERTS)
    once = policy.refit((*EXPERTS, OTHERS[0]), weights=[1.0, 1.0, 1.0])
    assert cost == learned.cost(EXPERTS)
    np.testing.assert_allclose(
        learned.model.mixture.means, once.model.mixture.means, rtol=0, atol=1e-6
    )


def test_the_discarded_are_used_only_where_the_cost_falls():
    policy = TrajectoryTPGMM(3).fit(EXPERTS)
    told = [(one, 2.0) for one in OTHERS]
    assert with_discarded(policy, 0.0, EXPERTS, told, 0.5, EXPERTS) == (policy, 0.0)
    assert with_discarded(policy, 1.0, EXPERTS, [], 0.5, EXPERTS) == (policy, 1.0)
    learned, cost = with_discarded(policy, 1e9, EXPERTS, told, 0.5, EXPERTS)
    assert cost < 1e9
    assert learned is not policy


def test_algorithm_1_is_the_same_until_its_end():
    plain, using = run(), run(discarded=0.5)
    assert [one.cost for one in using.history] == [one.cost for one in plain.history]
    assert using.cost <= plain.cost
    assert using.cost == using.policy.cost(EXPERTS)


def test_a_policy_with_both_is_saved_and_read(tmp_path):
    options = AugmentOptions("rf", max_iterations=8, grow=True, discarded=0.3)
    policy = AugmentedTPGMM(options, policy=TrajectoryTPGMM(2)).fit(EXPERTS)
    again = AugmentedTPGMM.from_state(*policy.state())
    frames = reaching_situation(np.random.default_rng(3))
    start = frames[0].b
    np.testing.assert_array_equal(again.generate(frames, start), policy.generate(frames, start))
    assert again.options == options


def test_a_policy_that_cannot_grow_is_refused():
    class Plain:
        fit = refit = synthesise = cost = generate = lambda *_: None

    for options in ({"grow": True}, {"discarded": 0.1}):
        with pytest.raises(InvalidInputError, match="larger"):
            run(Plain(), **options)


@pytest.mark.parametrize("options", [{"grow": 1}, {"discarded": -0.1}, {"discarded": np.nan}])
def test_options_that_make_no_sense_are_refused(options):
    with pytest.raises(InvalidInputError):
        AugmentOptions(**options)
