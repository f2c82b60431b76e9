"""Policies learn from a file of the user's, which the run keeps a copy of."""

import json
from dataclasses import replace

import pytest

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.executors import Processes
from dressing_sim.benchmark.run.plan import Plan, make_plan
from dressing_sim.benchmark.run.progress import silent
from dressing_sim.benchmark.run.runner import Work, learned_by, learned_source, learned_sources
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.episode.demonstration import save_demonstrations
from dressing_sim.errors import InvalidInputError

PROTOCOL = Protocol(
    "p",
    "case_b",
    (Entry("expert"), Entry("tp-gmm", "case_a"), Entry("tp-gmm", "case_b")),
    demonstration_sets=3,
)


@pytest.fixture
def file(tmp_path, demonstration):
    # Two on one posture: what is in a file need not be a suite.
    save_demonstrations(tmp_path / "mine.h5", [demonstration, replace(demonstration, seed=8)])
    return tmp_path / "mine.h5"


def test_every_policy_learns_from_the_file_alone(file):
    plan = make_plan(PROTOCOL, demonstrations=file)
    names = [entry.demonstrations for entry in plan.protocol.entries]
    assert names[0] is None
    assert len(names) == 2
    assert names[1].startswith("mine@")
    assert plan.protocol.demonstration_sets == 1
    assert len(plan.demonstrated[names[1]]) == 2
    assert Plan.from_dict(json.loads(json.dumps(plan.to_dict()))) == plan


def test_the_name_says_the_content_and_not_the_place(file, tmp_path, demonstration):
    (tmp_path / "elsewhere").mkdir()
    other = tmp_path / "elsewhere" / "mine.h5"
    other.write_bytes(file.read_bytes())
    assert make_plan(PROTOCOL, demonstrations=other) == make_plan(PROTOCOL, demonstrations=file)
    save_demonstrations(other, [demonstration])
    assert make_plan(PROTOCOL, demonstrations=other) != make_plan(PROTOCOL, demonstrations=file)


def test_the_run_has_a_copy_and_needs_the_file_no_more(file, tmp_path, demonstration):
    plan = make_plan(PROTOCOL, demonstrations=file)
    jobs = plan.jobs
    with Processes(1) as workers, open_run(tmp_path / "run", plan) as folder:
        sources = learned_sources(folder, jobs, workers, silent, Work())
    file.unlink()
    job = jobs[-1]
    start = demonstration.positions[0]
    frames = job.posture.frames()
    again = learned_source(load_run(tmp_path / "run"), job).generate(frames, start)
    before = sources[learned_by(job)].generate(frames, start)
    assert again.positions.tobytes() == before.positions.tobytes()


def test_a_file_that_is_none_is_named(tmp_path):
    with pytest.raises(InvalidInputError, match=r"none\.h5"):
        make_plan(PROTOCOL, demonstrations=tmp_path / "none.h5")


@pytest.mark.parametrize("more", [{}, {"force": True}, {"resume": True}])
def test_a_file_in_the_run_s_own_folder_is_refused_and_left_alone(tmp_path, file, more):
    inside = tmp_path / "run" / "demonstrations" / "own-12345678.h5"
    inside.parent.mkdir(parents=True)
    inside.write_bytes(file.read_bytes())
    plan = make_plan(PROTOCOL, demonstrations=inside)
    with (
        pytest.raises(InvalidInputError, match=r"own-12345678\.h5: is read"),
        open_run(tmp_path / "run", plan, **more),
    ):
        pass
    assert inside.read_bytes() == file.read_bytes()
