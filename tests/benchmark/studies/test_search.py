"""The search for hyper-parameters, with dressings whose outcome they decide."""

import numpy as np
import pytest
from fake_benchmark import FakePolicy, Threads, steady_demonstrate

from dressing_sim.benchmark.records import Entry, EpisodeResult
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.studies.search import Search, Trial, best, score, search
from dressing_sim.benchmark.studies.search_document import search_document
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.cli import main
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.search_spaces import SPACES, Choice, Span, named, space_of
from dressing_sim.suites.suites import load_suite

LIMITS = Thresholds()
POSTURE = load_suite("val50")[0]


def outcome(pull, success=None):
    """Of an episode with a pull, as a share of its limit."""
    figures = {
        "grip_force": pull * LIMITS.grip_force,
        "strain": 0.1 * LIMITS.strain,
        "armscye_s": 2.0,
    }
    dressed = pull < 1.0 if success is None else success
    return Outcome(dressed, () if dressed else (Failure("over_force", "pulled"),), figures)


def episode(what):
    return EpisodeResult(0, Entry("tp-gmm", "case_a"), POSTURE, 0, 0, {}, what)


def fit(name, seed, demonstrations, limits, log):
    return FakePolicy(name, seed, demonstrations)


def pull_of(name):
    """Least, 0.3 of the limit, with an end radius of 0.1; 0.8 of the policy as it is."""
    text = name.partition("end_radius=")[2].partition("&")[0]
    return 0.8 if not text else 0.3 + 4.0 * abs(float(text) - 0.1)


def dress(source, job, config, observer=None):
    told = outcome(pull_of(job.entry.policy))
    return EpisodeResult(
        job.index, job.entry, job.posture, job.demonstration_set, job.seed, {}, told
    )


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    what = Search("tp-gmm", trials=20, postures=(2, 3, 5))
    workers, out = Threads(2), tmp_path_factory.mktemp("search")
    study = Success(Work(steady_demonstrate, fit, dress))
    return what, search(what, workers, out, study=study), out, study


@pytest.mark.parametrize("policy", SPACES)
def test_every_trial_is_a_policy_and_the_first_is_the_policy_as_it_is(policy):
    names = Search(policy, trials=9).names()
    assert names[0] == policy
    assert len(set(names)) == 9
    for name in names:
        make_policy(name)
    assert names == Search(policy, trials=9).names()
    assert names[1:] != Search(policy, trials=9, seed=1).names()[1:]
    # More trials are the same ones and more.
    assert Search(policy, trials=13).names()[:9] == names


@pytest.mark.parametrize("policy", SPACES)
def test_the_corners_of_a_space_are_policies_too(policy):
    space = space_of(policy)
    for share in (0.0, 1.0 - 1e-12):
        make_policy(named(policy, space, [share] * len(space)))


def test_shares_are_even_in_their_scale():
    assert Span(0.0, 4.0).at(0.25) == "1"
    assert Span(1e-3, 1e-1, log=True).at(0.5) == "0.01"
    whole = [int(Span(2, 5, whole=True).at(s)) for s in np.linspace(0.0, 1.0, 4000)]
    counts = np.bincount(whole)[2:]
    np.testing.assert_allclose(counts, 1000, atol=1)
    assert [Choice(("a", "b")).at(s) for s in (0.0, 0.49, 0.51, 1.0)] == ["a", "a", "b", "b"]


def test_the_better_quarter_goes_on_and_the_best_is_chosen(found):
    what, told, _, _ = found
    trials = told["trials"]
    assert [sum(t["rung"] >= rung for t in trials) for rung in range(3)] == [20, 5, 1]
    assert told["chosen"] == min(what.names(), key=pull_of)
    assert {t["n_episodes"] for t in trials if t["rung"] == 2} == {2 * 5}
    assert told["n_episodes"] == 2 * (20 * 2 + 5 * 1 + 1 * 2)
    assert told["best_so_far"] == sorted(told["best_so_far"])
    assert len(told["best_so_far"]) == 20
    first = score(episode(outcome(0.8)))
    assert told["best_so_far"][0] == pytest.approx(first)


def test_a_rung_dresses_what_the_rungs_before_have_not(found):
    what, *_ = found
    tested = [what.plan(["tp-gmm"], rung).tested for rung in range(3)]
    assert [arm for rung in tested for arm in rung] == load_suite("val50")[:5]


def test_a_finished_search_goes_on_without_dressing_again(found):
    what, told, out, _study = found

    def never(*_):
        raise AssertionError("dressed again")

    again = Success(Work(steady_demonstrate, fit, never))
    assert search(what, Threads(1), out, resume=True, study=again) == told


def test_the_report_names_what_was_chosen(found):
    text = markdown(search_document(found[1], "dressing-sim tune tp-gmm"))
    assert found[1]["chosen"] in text
    assert "20 trials" in text


def test_a_score_rises_with_success_and_with_the_smallest_margin():
    scores = [score(episode(outcome(pull))) for pull in (0.2, 0.6, 0.99, 1.01, 1.5, 5.0)]
    assert scores == sorted(scores, reverse=True)
    assert scores[2] - scores[3] == pytest.approx(0.5, abs=0.01)  # success itself
    assert scores[0] - scores[1] == pytest.approx(0.25 * 0.4)
    assert 0.0 <= scores[-1] < scores[0] <= 1.0
    # Nothing measured is as bad as can be.
    assert score(episode(Outcome(False, (Failure("policy_error", "raised"),)))) == 0.0


def test_of_equals_those_tried_first_go_on():
    trials = {
        name: Trial(name, 0, 1, 1, value)
        for name, value in zip("abc", (0.5, 0.7, 0.7), strict=False)
    }
    assert best(["a", "b", "c"], trials, 2) == ["b", "c"]


def test_an_unknown_policy_is_one_line_before_anything_runs(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        main(["tune", "expert"])
    assert stopped.value.code == 2
    assert "policy 'expert' has no ranges to search in; valid is one of tp-gmm" in (
        capsys.readouterr().err
    )
    assert not list(tmp_path.iterdir())
    with pytest.raises(InvalidInputError, match="trials is 0"):
        Search("tp-gmm", trials=0)
