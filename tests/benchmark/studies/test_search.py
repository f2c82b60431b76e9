"""The search for hyper-parameters, with dressings whose outcome they decide."""

import json
from pathlib import Path

import numpy as np
import pytest
from fake_benchmark import FakePolicy, Threads, steady_demonstrate

from dressing_sim.benchmark.records import Entry, EpisodeResult
from dressing_sim.benchmark.report.markdown import markdown
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.studies import STUDIES
from dressing_sim.benchmark.studies.search import (
    SCREENED,
    SCREENED_POSTURES,
    Search,
    SearchStudy,
    Trial,
    best,
    score,
)
from dressing_sim.benchmark.studies.search_document import trials_table
from dressing_sim.benchmark.studies.study import run_study
from dressing_sim.benchmark.studies.tuning_paths import tried
from dressing_sim.cli import main
from dressing_sim.config import to_plain
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import InvalidInputError
from dressing_sim.policies import rivals
from dressing_sim.policies.registry import DEFAULT, make_policy
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
    study = SearchStudy(Work(steady_demonstrate, fit, dress))
    return what, run_study(study, what.plan(), workers, out), out


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


@pytest.mark.parametrize("policy", rivals.POLICIES)
def test_a_rival_as_it_is_lies_within_its_ranges(policy):
    for name, one in SPACES.get(policy, {}).items():
        value = getattr(rivals.POLICIES[policy].method, name)
        if isinstance(one, Span):
            assert one.low <= value <= one.high
        else:
            assert str(value).lower() in one.values


# A network of the largest size takes long to learn.
@pytest.mark.parametrize("policy", sorted(set(SPACES) & set(rivals.POLICIES) - {"cnmp"}))
@pytest.mark.parametrize("share", [0.0, 1.0 - 1e-12])
def test_a_rival_at_the_corners_of_its_space_learns_and_answers(policy, share):
    space = space_of(policy)
    name = named(policy, space, [share] * len(space))
    ((_, path, _, _),) = tried(name, load_suite("case_a"), [POSTURE], seed=0)
    assert len(path) > 1  # a policy without an answer stays where it is
    assert np.isfinite(path).all()


def test_shares_are_even_in_their_scale():
    assert Span(0.0, 4.0).at(0.25) == "1"
    assert Span(1e-3, 1e-1, log=True).at(0.5) == "0.01"
    whole = [int(Span(2, 5, whole=True).at(s)) for s in np.linspace(0.0, 1.0, 4000)]
    counts = np.bincount(whole)[2:]
    np.testing.assert_allclose(counts, 1000, atol=1)
    assert [Choice(("a", "b")).at(s) for s in (0.0, 0.49, 0.51, 1.0)] == ["a", "a", "b", "b"]


def test_the_better_quarter_goes_on_and_the_best_is_chosen(found):
    what, done, _ = found
    told, trials = done.summary, done.summary["trials"]
    assert [t["policy"] for t in trials] == what.names()
    assert [sum(t["rung"] >= rung for t in trials) for rung in range(3)] == [20, 5, 1]
    assert told["chosen"] == min(what.names(), key=pull_of)
    assert {t["n_episodes"] for t in trials if t["rung"] == 2} == {2 * 5}
    assert told["n_episodes"] == len(done.results) == 2 * (20 * 2 + 5 * 1 + 1 * 2)
    assert told["best_so_far"] == sorted(told["best_so_far"])
    assert len(told["best_so_far"]) == 20
    first = score(episode(outcome(0.8)))
    assert told["best_so_far"][0] == pytest.approx(first)
    assert told["search"] == {
        "policy": "tp-gmm",
        "trials": 20,
        "seed": 0,
        "cases": ["case_a", "case_b"],
        "postures": [2, 3, 5],
        "screened": [],
        "path_scores": [],
    }


def test_the_table_has_the_best_trials_and_the_policy_as_it_is(found):
    what, done, _ = found
    heading, *rows = trials_table(done.summary, most=3)
    assert heading == ["hyper-parameters", "dressed", "score", "rung"]
    assert what.policy + "?" + rows[0][0] == done.summary["chosen"]
    assert [row[0] for row in rows[1:]].count("as it is") == 1
    assert len(rows) == 4
    assert rows[0][1] == "10 / 10"
    everything = trials_table(done.summary, most=100)
    assert len(everything) == 1 + len(what.names())


def test_a_rung_dresses_what_the_rungs_before_have_not(found):
    what, done, _ = found
    plan = what.plan()
    assert list(plan.tested) == load_suite("val50")[:5]
    assert Search.of(plan) == what
    dressed = {}
    for result in done.results:
        dressed.setdefault(result.entry, []).append(result.posture)
    rungs = {t["policy"]: t["rung"] for t in done.summary["trials"]}
    for entry, postures in dressed.items():
        assert postures == list(plan.tested[: what.postures[rungs[entry.policy]]])


def test_a_search_does_not_depend_on_when_it_was_cut_short(tmp_path):
    what, left = Search("tp-gmm", trials=8, postures=(1, 2)), [0]

    class Stop(Exception):
        pass

    def some(*arguments):
        left[0] -= 1
        if left[0] < 0:
            raise Stop
        return dress(*arguments)

    def run(n, folder, resume=False):
        left[0] = n
        study = SearchStudy(Work(steady_demonstrate, fit, some))
        return run_study(study, what.plan(), Threads(1), tmp_path / folder, resume=resume)

    whole = run(20, "whole")
    assert len(whole.results) == 2 * (8 + 2)
    for n, resume in ((10, False), (6, True), (1, True)):  # in a rung, between two, in the next
        with pytest.raises(Stop):
            run(n, "parts", resume)
    parts = run(20, "parts", True)
    assert parts.results == whole.results
    assert parts.summary == whole.summary


def test_a_finished_search_goes_on_without_dressing_again(found):
    what, done, out = found

    def never(*_):
        raise AssertionError("dressed again")

    again = SearchStudy(Work(steady_demonstrate, fit, never))
    assert run_study(again, what.plan(), Threads(1), out, resume=True).summary == done.summary


def test_the_command_says_how_an_interrupted_search_goes_on(tmp_path, monkeypatch, capsys):
    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setitem(STUDIES, "search", lambda: SearchStudy(Work(interrupt, fit, dress)))
    monkeypatch.setattr("dressing_sim.commands.studies.Processes", Threads)
    monkeypatch.setattr("sys.argv", ["dressing-sim", "tune", "tp-gmm", "--trials", "2"])
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SystemExit) as stopped:
        main(["tune", "tp-gmm", "--trials", "2", "--workers", "1"])
    assert stopped.value.code == 130
    assert "to continue: dressing-sim tune tp-gmm --trials 2 --resume" in capsys.readouterr().err


def test_the_report_names_what_was_chosen(found):
    text = markdown(found[1].document)
    assert found[1].summary["chosen"] in text
    assert "20 trials" in text


def screening(what, scores):
    """A summary of the study of tuning: each trial scores alike from both cases."""
    return {
        "rows": [
            {"policy": n, "score": s}
            for n, s in zip(what.design(), scores, strict=True)
            for _ in "ab"
        ]
    }


def test_of_screened_trials_the_best_dress_and_the_policy_as_it_is():
    what = Search("tp-gmm", trials=20)
    scores = np.random.default_rng(0).permutation(20) / 20.0
    scores[0] = -1.0  # the policy as it is draws the worst paths of all
    after = what.after(screening(what, scores))
    ranked = [what.design()[place] for place in np.argsort(-scores)]
    assert list(after.screened) == ranked
    np.testing.assert_allclose(after.path_scores, np.sort(scores)[::-1])
    assert after.names() == ["tp-gmm", *ranked[: SCREENED - 1]]
    plan = after.plan()
    assert {entry.policy for entry in plan.protocol.entries} == set(after.names())
    assert len(plan.tested) == SCREENED_POSTURES[-1]
    assert Search.of(plan) == after
    plan = what.screening()
    assert plan.protocol.study == "tuning"
    assert [entry.policy for entry in plan.protocol.entries][::2] == what.design()
    assert list(plan.tested) == load_suite("val50")


def test_the_command_screens_by_paths_before_anything_dresses(tmp_path, monkeypatch, capsys):
    monkeypatch.setitem(
        STUDIES, "search", lambda: SearchStudy(Work(steady_demonstrate, fit, dress))
    )
    monkeypatch.setattr("dressing_sim.commands.studies.Processes", Threads)
    monkeypatch.chdir(tmp_path)
    command = ["tune", "tp-gmr", "--trials", "12", "--screened", "--workers", "1", "--out", "found"]
    main([*command, "--json"])
    found = json.loads(capsys.readouterr().out)
    paths = json.loads(Path("found-screening/summary.json").read_text())
    what = Search("tp-gmr", trials=12)
    assert list(map(tuple, found["search"].items())) == list(to_plain(what.after(paths)).items())
    assert sorted(found["search"]["screened"]) == sorted(what.design())
    assert found["search"]["path_scores"] == sorted(found["search"]["path_scores"], reverse=True)
    assert len(found["trials"]) == SCREENED
    assert found["n_episodes"] == 2 * (SCREENED * 8 + 2 * 42)
    assert "12 trials of `tp-gmr` drew paths" in Path("found/report.md").read_text()
    # The same command goes on: nothing is drawn or dressed again.
    monkeypatch.setitem(STUDIES, "search", lambda: SearchStudy(Work(steady_demonstrate, fit, None)))
    main([*command, "--json", "--resume"])
    assert json.loads(capsys.readouterr().out) == found


def test_a_score_rises_with_success_and_with_the_smallest_margin():
    scores = [score(episode(outcome(pull))) for pull in (0.2, 0.6, 0.99, 1.01, 1.5, 5.0)]
    assert scores == sorted(scores, reverse=True)
    assert scores[2] - scores[3] == pytest.approx(0.5, abs=0.01)  # success itself
    assert scores[0] - scores[1] == pytest.approx(0.25 * 0.4)
    assert 0.0 <= scores[-1] < scores[0] <= 1.0
    # Nothing measured is as bad as can be.
    assert score(episode(Outcome(False, (Failure("policy_error", "raised"),)))) == 0.0


def test_the_default_is_searched_by_that_name_too(monkeypatch):
    seen = []
    monkeypatch.setattr(
        "dressing_sim.commands.studies.carry_out", lambda plan, *_, **options: seen.append(plan)
    )
    main(["tune", "default"])
    assert Search.of(seen[0]).policy == DEFAULT


def test_of_equals_those_tried_first_go_on():
    trials = [
        Trial(name, 0, 1, 1, value) for name, value in zip("abc", (0.5, 0.7, 0.7), strict=True)
    ]
    assert [trial.policy for trial in best(trials)] == ["b", "c", "a"]


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
