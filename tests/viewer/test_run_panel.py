"""The map of a run, and the colours of its postures."""

import re

import pytest
from fake_benchmark import write_suite

from dressing_sim.benchmark.records import Entry, EpisodeResult, Protocol
from dressing_sim.benchmark.run.lines import episode_values
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.runner import job_result
from dressing_sim.benchmark.run.store import open_run
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.outcome import Outcome
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.robots import with_robot
from dressing_sim.suites.suites import load_suite
from dressing_sim.viewer.past import Past, verdict_of
from dressing_sim.viewer.run_panel import _rgb, failure_map

EPISODES = [
    EpisodeResult(number, Entry("tp-gmm", "case_a"), posture, 0, 0, {}, Outcome(True))
    for number, posture in enumerate(load_suite("paper5"))
]


def test_the_chosen_posture_has_a_ring_and_no_other():
    for chosen, rings in ((EPISODES[2].posture.name, 1), ("nobody", 0)):
        circles = re.findall(r"<circle[^>]*><title>[^:]*", failure_map(EPISODES, chosen))
        assert len(circles) == 5
        ringed = [circle for circle in circles if "stroke=" in circle]
        assert len(ringed) == rings
        assert all(circle.endswith(chosen) for circle in ringed)


def test_a_colour_as_light_is_darker_but_for_black_and_white():
    assert _rgb("#000000") == (0, 0, 0)
    assert _rgb("#ffffff") == (255, 255, 255)
    assert _rgb("#808080") == (55, 55, 55)


def test_an_episode_that_was_not_tried_is_told_as_that():
    assert verdict_of(Outcome(False, abstained="too bent")) == "abstained"
    assert verdict_of(Outcome(False, invalid="the cloth broke")) == "void: the cloth broke"


def test_a_run_of_another_robot_is_one_line(tmp_path):
    suite = write_suite(tmp_path / "suite.json", 1)
    config = with_robot(EpisodeConfig(), "ur10")
    plan = make_plan(Protocol("p", suite, (Entry("expert"),)), 0, config)
    with open_run(tmp_path / "run", plan) as run:
        run.append(
            episode_values(plan, job_result(plan.jobs[0], plan.tested[0], {}, Outcome(True)))
        )
    with pytest.raises(InvalidInputError, match="UR10 dressed; valid is a run of the panda"):
        Past(tmp_path / "run")
