"""A policy has the same verdicts in the benchmark's table, through Gymnasium and through dm_env."""

import json

import pytest

from dressing_sim.benchmark.run.runner import learned_source
from dressing_sim.benchmark.run.store import load_run
from dressing_sim.benchmark.studies.evaluate import evaluate
from dressing_sim.envs import GYMNASIUM_ID
from dressing_sim.episode.demonstration import save_demonstrations
from dressing_sim.suites.suites import load_suite

gymnasium = pytest.importorskip("gymnasium")


@pytest.fixture(scope="module")
def run(tmp_path_factory, demonstration):
    """An expert and a policy that learned from one demonstration, on two arms."""
    folder = tmp_path_factory.mktemp("verdicts")
    save_demonstrations(folder / "one.h5", [demonstration])
    arms = [one.to_dict() for one in load_suite("paper5")[2::2]]
    (folder / "two.json").write_text(json.dumps({"postures": arms}))
    evaluate(
        "expert,tp-gmm",
        suite=str(folder / "two.json"),
        demonstrations=folder / "one.h5",
        workers=1,
        out=folder / "run",
    )
    return load_run(folder / "run")


def through_gymnasium(posture, config, source, seed):
    env = gymnasium.make(GYMNASIUM_ID, posture=posture, control="target", episode=config)
    env.reset()
    for action in env.unwrapped.actions(source, seed):
        *_, terminated, truncated, _ = env.step(action)
        if terminated or truncated:
            return env.unwrapped.recording().outcome
    raise AssertionError("the episode did not end")


def through_dm_env(posture, config, source, seed):
    dm = pytest.importorskip("dressing_sim.envs.dm")
    environment = dm.load(posture, control="target", episode=config)
    environment.reset()
    for action in environment.physics.task.actions(source, seed):
        if environment.step(action).last():
            return environment.physics.task.recording().outcome
    raise AssertionError("the episode did not end")


@pytest.mark.parametrize("through", [through_gymnasium, through_dm_env])
def test_every_line_of_a_run_is_what_the_environment_says(run, through):
    lines = [run.line(index) for index in range(len(run.plan.jobs))]
    assert len(lines) == 4
    for job, line in zip(run.plan.jobs, lines, strict=True):
        posture, config, _ = job.situation(run.plan.config)
        outcome = through(posture, config, learned_source(run, job), job.seed)
        again = json.loads(json.dumps(outcome.to_dict()))
        assert {name: line[name] for name in again} == again
