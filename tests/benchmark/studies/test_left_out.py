"""The study of what is left out of the simulation."""

import json

import numpy as np
import pytest

from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.agreement import DECIDED, REFERENCE, SECONDS
from dressing_sim.benchmark.studies.left_out import (
    LEFT_OUT,
    LeftOut,
    dress_with_it,
    left_out_plan,
    with_it,
)
from dressing_sim.cli import main
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError


class StaysBriefly:
    """Stays where the gripper is."""

    def generate(self, frames, start):
        return np.tile(start, (6, 1))


@pytest.mark.parametrize("what", LEFT_OUT)
def test_each_is_out_of_the_default_world_and_alone_in_the_other(what):
    default, other = EpisodeConfig().world.sleeve, with_it(EpisodeConfig(), what).world.sleeve
    put_in = {name: getattr(other, name) for name in LEFT_OUT.values()}
    assert not any(getattr(default, name) for name in put_in)
    assert [name for name, there in put_in.items() if there] == [LEFT_OUT[what]]


@pytest.mark.parametrize("what", LEFT_OUT)
def test_the_same_commands_are_played_in_both_worlds(what):
    plan = left_out_plan(what, "val50", 1)
    assert isinstance(find_study(plan.protocol.study), LeftOut)
    done = dress_with_it(what, StaysBriefly(), plan.jobs[0], plan.config)
    assert done.extra[DECIDED]
    assert len(done.extra[SECONDS]) == 2
    here, there = done.outcome, done.extra[REFERENCE]
    assert not here.success
    assert not there["success"]
    # The robot does the same; its servos feel little of the cloth.
    assert there["figures"]["tracking_error"] == pytest.approx(
        here.metrics["tracking_error"], abs=2e-3
    )


def test_what_is_not_left_out_is_refused():
    with pytest.raises(InvalidInputError, match=r"'wind', valid is one of bending, self-contact"):
        left_out_plan("wind")


def test_a_run_can_be_resumed_and_replayed(tmp_path, capsys):
    out = tmp_path / "drag"
    command = ["validate", "--suite", "val50", "--postures", "1", "--left-out", "air-drag"]
    assert main([*command, "--out", str(out)]) in (None, 0, 1)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["left_out"] == "air-drag"
    assert summary["config"]["reference"]["world"]["sleeve"]["air_drag"]
    assert "air_drag" not in summary["config"]["episode"]["world"]["sleeve"]
    assert summary["policies"]["n_episodes"] + summary["policies"]["n_void"] == 5
    assert "has air-drag" in (out / "report.md").read_text()
    capsys.readouterr()
    assert main(["replay", str(out), "0"]) in (None, 0)
    assert "identical to the recorded episode" in "".join(capsys.readouterr())
