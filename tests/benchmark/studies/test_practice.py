"""Practice, with dressings whose margins are a bowl over the parameters."""

import numpy as np
import pytest
from fake_benchmark import FakePolicy, Threads, steady_demonstrate

from dressing_sim.benchmark.records import Entry, EpisodeResult
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.studies.practice import SPACES, Generation, Practice, practise
from dressing_sim.benchmark.studies.practice_document import practice_document
from dressing_sim.benchmark.studies.search import smallest_margin
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.search_spaces import named
from dressing_sim.policies.transported import ELBOW_OFFSETS
from dressing_sim.suites.suites import load_suite

LIMITS = Thresholds()
BEST = {"elbow_out": 0.1, "elbow_along": -0.05, "elbow_up": 0.0}
WHAT = Practice(postures=4, generations=8, population=8, demonstration_sets=1)


def fit(name, seed, demonstrations, limits, log):
    return FakePolicy(name, seed, demonstrations)


def offsets_of(name):
    given = dict(part.split("=") for part in name.partition("?")[2].split("&") if part)
    return np.array([float(given.get(key, 0.0)) for key in ELBOW_OFFSETS])


def pull_of(name):
    away = offsets_of(name) - list(BEST.values())
    return 0.4 + 20.0 * float(away @ away)


def outcome(pull, reason="over_force", success=None):
    metrics = {
        "grip_force": pull * LIMITS.grip_force,
        "strain": 0.1 * LIMITS.strain,
        "armscye_s": 2.0,
    }
    dressed = pull < 1.0 if success is None else success
    return Outcome(dressed, () if dressed else (Failure(reason, "why"),), metrics)


def dress(source, job, config, observer=None):
    told = outcome(pull_of(job.entry.policy))
    return EpisodeResult(
        job.index, job.entry, job.posture, job.demonstration_set, job.seed, {}, told
    )


@pytest.fixture(scope="module")
def practised(tmp_path_factory):
    out = tmp_path_factory.mktemp("practice")
    study = Generation(Work(steady_demonstrate, fit, dress))
    return practise(WHAT, Threads(2), out, study=study), out


def test_it_finds_where_margins_are_widest(practised):
    told, _ = practised
    assert told["before"]["policy"] == "transport"
    assert told["before"]["margin"] == pytest.approx(1.0 - pull_of("transport"))
    np.testing.assert_allclose(offsets_of(told["chosen"]), list(BEST.values()), atol=0.03)
    assert told["after"]["margin"] > told["before"]["margin"]
    means = [one["mean"] for one in told["generations"]]
    assert means[-1] > means[0]
    assert told["after"]["margin"] == max(one["best"] for one in told["generations"])


def test_the_practised_policy_is_a_name_like_any_other(practised):
    made = make_policy(practised[0]["chosen"])
    found = [getattr(made.config, name) for name in ELBOW_OFFSETS]
    np.testing.assert_allclose(found, offsets_of(practised[0]["chosen"]))


def test_the_report_names_the_practised_policy(practised):
    text = markdown(practice_document(practised[0], "dressing-sim practise"))
    assert practised[0]["chosen"] in text
    assert f"{practised[0]['n_episodes']} simulated episodes" in text


def test_hyper_parameters_that_are_given_stay():
    given = Practice(policy="transport?hand=0.3", postures=2)
    name = named(given.policy, given.space, [0.5, 0.5, 0.5])
    assert make_policy(name).config.hand == 0.3


def test_every_simulated_episode_is_counted(practised):
    told, _ = practised
    assert told["n_episodes"] == WHAT.postures * (1 + WHAT.generations * WHAT.population)


def test_it_goes_on_where_it_was_cut_short(practised):
    told, out = practised

    def never(*_):
        raise AssertionError("dressed again")

    again = Generation(Work(steady_demonstrate, fit, never))
    assert practise(WHAT, Threads(1), out, resume=True, study=again) == told


def test_arms_are_of_no_suite_and_every_second_one_is_bent():
    arms = WHAT.arms()
    assert arms == WHAT.arms()
    assert arms != Practice(postures=4, seed=1).arms()
    assert len({arm.name for arm in arms}) == 4
    assert all(60.0 <= arm.elbow_deg <= 90.0 for arm in arms[1::2])
    known = {
        arm.elbow_deg
        for suite in ("val50", "test200", "hard_elbow", "random:6")
        for arm in load_suite(suite)
    }
    assert not known & {arm.elbow_deg for arm in arms}


def test_an_odd_number_of_arms_is_had_too():
    assert len(Practice(postures=5).arms()) == 5


@pytest.mark.parametrize("policy", SPACES)
def test_practice_begins_with_the_policy_as_it_is(policy):
    for name, span in SPACES[policy].items():
        assert float(span.at(0.5)) == getattr(make_policy(policy).config, name)


def test_a_failure_that_is_not_the_cloth_s_has_the_worst_margin():
    def margin(what):
        return smallest_margin(
            EpisodeResult(0, Entry("transport", "case_a"), load_suite("val50")[0], 0, 0, {}, what)
        )

    assert margin(outcome(0.3)) == pytest.approx(0.7)
    assert margin(outcome(1.2)) == pytest.approx(-0.2)
    assert margin(outcome(0.3, "hit", success=False)) == -1.0
    assert margin(Outcome(False, (Failure("policy_error", "raised"),))) == -1.0


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"policy": "tp-gmm"}, "nothing to practise; valid is transport"),
        ({"population": 3}, "population"),
        ({"generations": 0}, "generations"),
        ({"postures": 1.5}, "postures"),
    ],
)
def test_what_cannot_be_practised_is_named(change, told):
    with pytest.raises(InvalidInputError, match=told):
        Practice(**change).check()
