import json
from dataclasses import replace

import pytest
from fake_benchmark import FakePolicy, Threads, fake_work, tries, write_suite

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run import runner
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import demonstration_seed, fitting_seed, make_plan
from dressing_sim.benchmark.run.runner import Work
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.benchmark.studies.convergence_trials import Trial
from dressing_sim.benchmark.studies.cost import CostRun
from dressing_sim.benchmark.studies.study import line_of, read_results, result_of, run_jobs
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.benchmark.studies.tuning import Screening
from dressing_sim.benchmark.studies.tuning_paths import PathMetrics
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.policies.hosted import Guarded
from dressing_sim.policies.registry import EXPERT
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.sleeve import SleeveConfig

ENTRIES = (Entry("tp-gmm", "case_a"), Entry(EXPERT), Entry("tp-gmm", "case_b"))


@pytest.fixture
def protocol(tmp_path):
    return Protocol("tiny", write_suite(tmp_path / "suite.json", 4), ENTRIES)


def run(folder, plan, resume=False, workers=None, **settings):
    work = settings.pop("work", fake_work(folder))
    with workers or Threads(1) as crew, open_run(folder / "run", plan, resume) as opened:
        return run_jobs(Success(work), opened, crew, **settings)


def files(folder):
    names = ("episodes.jsonl", "config.json")
    return [(folder / "run" / name).read_bytes() for name in names]


def test_results_are_one_a_row_and_posture_in_their_order(tmp_path, protocol):
    plan = make_plan(protocol, seed=5)
    results = run(tmp_path, plan)
    assert [(r.index, r.entry, r.posture, r.seed) for r in results] == [
        (job.index, job.entry, job.posture, job.seed) for job in plan.jobs
    ]
    assert results == read_results(Success(), load_run(tmp_path / "run"))
    assert {r.outcome.success for r in results} == {True, False}


@pytest.mark.parametrize("sets", [1, 2])
def test_results_do_not_depend_on_the_number_of_workers(tmp_path, protocol, sets):
    plan = make_plan(replace(protocol, demonstration_sets=sets))
    contents = []
    for count in (1, 2):
        folder = tmp_path / str(count)
        folder.mkdir()
        run(folder, plan, workers=Processes(count))
        contents.append(files(folder))
    assert contents[0] == contents[1]


def test_each_policy_learns_from_its_demonstrations_and_dresses_its_part(tmp_path, protocol):
    plan = make_plan(replace(protocol, demonstration_sets=2), seed=5)
    dressed = {}

    def dress(source, job, config):
        dressed[job.index] = source
        return runner.job_result(job, job.posture, {}, Outcome(True))

    run(tmp_path, plan, work=replace(fake_work(tmp_path), dress=dress))
    for job in plan.jobs:
        source, shown, number = dressed[job.index], job.entry.demonstrations, job.demonstration_set
        if shown is None:
            assert isinstance(source, Guarded)
            assert source.name == EXPERT
            continue
        assert isinstance(source, FakePolicy)
        name, seed, learned = source.learned
        assert (name, seed) == ("tp-gmm", fitting_seed(5, job.entry, number))
        assert learned == [
            (p.name, demonstration_seed(5, p, number, 0)) for p in plan.demonstrated[shown]
        ]
    fitted = {id(source) for source in dressed.values() if isinstance(source, FakePolicy)}
    assert len(fitted) == len(tries(tmp_path, "policy-tp-gmm")) == 4


def test_a_posture_in_two_suites_is_demonstrated_once(tmp_path, protocol):
    shown = write_suite(tmp_path / "shown.json", 3)
    entries = (Entry("tp-gmm", shown), Entry("tp-gmm", f"{shown}:2"))
    run(tmp_path, make_plan(replace(protocol, entries=entries)))
    assert all(len(tries(tmp_path, f"demonstration-arm{i}")) == 1 for i in range(3))


def test_progress_counts_demonstrations_policies_and_episodes(tmp_path, protocol):
    told = []
    results = run(tmp_path, make_plan(protocol), progress=lambda *now: told.append(now))
    assert told[:-13] == [
        *(("demonstrations", done, 4, "") for done in range(5)),
        *(("policies", done, 2, "") for done in range(3)),
    ]
    assert [now[:3] for now in told[-13:]] == [("episodes", done, 12) for done in range(13)]
    dressed = sum(result.outcome.success for result in results)
    assert told[-13][3] == ""
    assert told[-1][3] == f"{dressed} of 12 dressed ({100 * dressed / 12:.0f} %)"


class Stop(Exception):
    pass


@pytest.mark.parametrize(
    ("stage", "count"), [("demonstrations", 1), ("policies", 1), ("episodes", 0), ("episodes", 5)]
)
def test_a_run_that_stopped_anywhere_goes_on_and_ends_with_the_same_bytes(
    tmp_path, protocol, stage, count
):
    plan = make_plan(protocol)
    for name in ("whole", "stopped"):
        (tmp_path / name).mkdir()
    run(tmp_path / "whole", plan)

    def stop(now, done, total, note):
        if (now, done) == (stage, count):
            raise Stop

    with pytest.raises(Stop):
        run(tmp_path / "stopped", plan, progress=stop)
    begun = load_run(tmp_path / "stopped" / "run").finished
    kept = {path.name for path in (tmp_path / "stopped/run").glob("demonstrations/*")}
    told = []
    run(tmp_path / "stopped", plan, resume=True, progress=lambda *now: told.append(now[:3]))
    assert files(tmp_path / "stopped") == files(tmp_path / "whole")
    assert told[0] == ("demonstrations", len(kept), 4)
    assert ("episodes", len(begun), 12) in told
    assert all(len(tries(tmp_path / "stopped", index)) == 1 for index in begun)


def test_a_finished_run_repeats_nothing(tmp_path, protocol):
    plan = make_plan(protocol)
    results = run(tmp_path, plan)
    nothing = Work(None, None, None)
    assert run(tmp_path, plan, resume=True, work=nothing) == results


def test_an_episode_that_kills_its_worker_twice_is_void_and_stays_so(tmp_path, protocol):
    plan = make_plan(protocol)
    (tmp_path / "deadly-5").touch()
    (tmp_path / "kill-2").touch()
    results = run(tmp_path, plan, workers=Processes(2))
    assert [r.index for r in results if r.outcome.invalid] == [5]
    assert results[5].outcome == Outcome(False, invalid="worker died twice")
    assert results[5].posture == plan.jobs[5].posture
    assert run(tmp_path, plan, resume=True, work=Work(None, None, None)) == results


@pytest.mark.parametrize(
    ("command", "part"),
    [
        ("deadly-demonstration-bent5", "demonstrating on posture 'bent5'"),
        ("deadly-policy-tp-gmm", "fitting policy 'tp-gmm'"),
    ],
)
def test_without_its_demonstrations_or_policies_nothing_runs(tmp_path, protocol, command, part):
    plan = make_plan(protocol)
    name = plan.demonstrated["case_a"][0].name
    (tmp_path / command.replace("bent5", name)).touch()
    with pytest.raises(DressingSimError, match=part.replace("bent5", name) + ".*died twice"):
        run(tmp_path, plan, workers=Processes(1))
    assert load_run(tmp_path / "run").finished == frozenset()


def test_an_error_in_a_worker_reaches_whoever_asked_and_leaves_the_rest(tmp_path, protocol):
    plan = make_plan(protocol)
    work = fake_work(tmp_path)

    def dress(source, job, config):
        if job.index == 3:
            raise InvalidInputError("policy mine: returned nonsense")
        return work.dress(source, job, config)

    with pytest.raises(InvalidInputError, match="nonsense"):
        run(tmp_path, plan, work=replace(work, dress=dress))
    assert 3 not in load_run(tmp_path / "run").finished
    assert {0, 1, 2} <= load_run(tmp_path / "run").finished


#: A coarse sleeve and rules that forgive all: quick, and every demonstration can be learned from.
QUICK = EpisodeConfig(
    world=WorldConfig(sleeve=SleeveConfig(edge=0.05)),
    thresholds=replace(Thresholds(), armscye_s=-9.0, strain=9.0, grip_force=1e3, link_force=1e3),
    hold=0.2,
)


def test_with_physics_one_worker_and_two_leave_the_same_bytes(tmp_path):
    arm = {"flexion_deg": 75, "abduction_deg": 20, "rotation_deg": 40}
    for name, elbow in (("test", 10), ("shown", 15)):
        content = {"postures": [{"name": name, "elbow_deg": elbow, **arm}]}
        (tmp_path / f"{name}.json").write_text(json.dumps(content))
    entries = (Entry("tp-gmm", str(tmp_path / "shown.json")), Entry(EXPERT))
    plan = make_plan(Protocol("tiny", str(tmp_path / "test.json"), entries), 3, QUICK)
    contents = []
    for count in (1, 2):
        folder = tmp_path / str(count)
        results = run(folder, plan, workers=Processes(count), work=Work())
        assert all(result.outcome.metrics for result in results)
        contents.append(files(folder))
    assert contents[0] == contents[1]


STUCK = Outcome(False, (Failure("stuck", "at the elbow", 7.0, 1.0),), {"strain": 0.1}, None)


@pytest.mark.parametrize(
    "result",
    [
        CostRun(3, ENTRIES[0], 1, (0.25, 0.125), (0, 4), 2.5),
        Trial(5, "finest", "expert", "p", STUCK, 1.5),
        Screening(7, ENTRIES[0], 2, (PathMetrics(0.1, 0.2, 0.3, 0.4, 0.5, 0.6),)),
    ],
    ids=lambda result: type(result).__name__,
)
def test_a_result_is_read_from_its_line_as_it_was(result):
    line = json.loads(json.dumps(line_of(result)))
    assert next(iter(line)) == "index"
    assert list(line)[-1] == "versions"
    assert result_of(type(result), line) == result
    for name in set(line) - {"index", "versions"}:
        with pytest.raises(InvalidInputError, match=f"not a {type(result).__name__}"):
            result_of(type(result), {k: v for k, v in line.items() if k != name})
