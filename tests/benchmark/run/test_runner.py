from dataclasses import replace

import numpy as np
import pytest
from fake_benchmark import Threads, write_suite

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run import runner
from dressing_sim.benchmark.run.cache import VARIABLE
from dressing_sim.benchmark.run.plan import (
    demonstration_seed,
    make_plan,
    posture_seed,
)
from dressing_sim.benchmark.run.runner import (
    ATTEMPTS,
    dress_job,
    record_demonstration,
    record_demonstrations,
    repeated_demonstrations,
)
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.demonstration import Demonstration
from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.episode.recording import Recording
from dressing_sim.errors import DressingSimError


@pytest.fixture
def protocol(tmp_path):
    return Protocol("tiny", write_suite(tmp_path / "suite.json", 4), (Entry("tp-gmm", "case_a"),))


@pytest.fixture
def attempts(monkeypatch):
    """The operator fails but for the last of the outcomes; the seeds of its attempts are noted."""
    # No cache answers for an operator that is made up, nor keeps what it made up for other tests.
    monkeypatch.setenv(VARIABLE, "")
    seeds = []
    outcomes = [
        Outcome(False, (Failure("stuck", "at the elbow"),)),
        Outcome(False, invalid="broken"),
    ]

    def set_failures(count):
        def demonstrate(posture, seed, operator, config):
            seeds.append(seed)
            line = np.linspace(posture.wrist, posture.shoulder, 30)
            done = len(seeds) > count
            outcome = Outcome(True) if done else outcomes[(len(seeds) - 1) % 2]
            return Demonstration(line, 0.05, posture, seed, np.zeros((30, 7)), outcome=outcome)

        monkeypatch.setattr(runner, "demonstrate", demonstrate)
        return seeds

    return set_failures


def test_a_demonstration_that_fails_is_tried_again_with_another_seed(posture, attempts):
    seeds = attempts(ATTEMPTS - 1)
    found = record_demonstration(3, posture, 1, EpisodeConfig())
    assert seeds == [demonstration_seed(3, posture, 1, n) for n in range(ATTEMPTS)]
    assert found.seed == seeds[-1]
    assert len(set(seeds)) == ATTEMPTS


def test_the_first_attempt_of_the_first_set_has_the_postures_seed(posture, attempts):
    attempts(0)
    assert record_demonstration(3, posture, 0, EpisodeConfig()).seed == posture_seed(3, posture)


def test_a_demonstration_that_never_succeeds_is_an_error_that_names_it(posture, attempts):
    attempts(99)
    with pytest.raises(
        DressingSimError, match=f"'{posture.name}' with seed 7 failed 5 times: at the elbow"
    ):
        record_demonstration(7, posture, 0, EpisodeConfig())


def test_repeated_demonstrations_are_told_of_also_when_they_were_loaded(
    tmp_path, protocol, attempts
):
    attempts(2)
    plan = make_plan(replace(protocol, demonstration_sets=2))
    for _ in range(2):
        with Threads(1) as crew, open_run(tmp_path / "run", plan, resume=True) as opened:
            record_demonstrations(opened, crew)
            told = repeated_demonstrations(opened)
        first = plan.demonstrated["case_a"][0]
        assert told == [{"posture": first.name, "demonstration_set": 0, "attempts": 3}]


def test_an_episode_is_run_as_it_was_varied(posture, protocol, monkeypatch):
    job = make_plan(protocol).jobs[0]
    config = EpisodeConfig()
    varied = replace(config, hold=9.0)
    bent = replace(job.posture, elbow_deg=44.0)
    monkeypatch.setattr(
        type(job), "situation", lambda *_: (bent, varied, {"fabric": "wool", "arm": [1.0]})
    )

    def record(source, posture, seed, config, observer):
        assert (source, posture, seed, config) == ("source", bent, job.seed, varied)
        return Recording(Outcome(True), None, None, None)

    monkeypatch.setattr(runner, "record", record)
    result = dress_job("source", job, config)
    assert (result.posture, result.variation) == (bent, {"fabric": "wool", "arm": [1.0]})
