"""The study of a change of the simulation."""

import json

import numpy as np
import pytest

from dressing_sim.benchmark.studies import find_study
from dressing_sim.benchmark.studies.agreement import DECIDED, REFERENCE, SECONDS
from dressing_sim.benchmark.studies.change import Change, change_plan, dress_changed, with_change
from dressing_sim.cli import main
from dressing_sim.config import to_plain
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.errors import InvalidInputError

LEFT_OUT = ("bending", "self_contact", "robot_contact", "air_drag")


class StaysBriefly:
    """Stays where the gripper is."""

    def generate(self, frames, start):
        return np.tile(start, (6, 1))


@pytest.mark.parametrize("what", LEFT_OUT)
def test_what_is_left_out_by_default_can_be_put_in_alone(what):
    default, other = EpisodeConfig().world.sleeve, with_change(EpisodeConfig(), f"{what}=true")
    assert not any(getattr(default, name) for name in LEFT_OUT)
    assert [name for name in LEFT_OUT if getattr(other.world.sleeve, name)] == [what]


def test_a_change_is_of_the_world_alone():
    default = EpisodeConfig()
    other = with_change(default, "edge=0.035&timestep=0.005")
    assert other.world.sleeve.edge == 0.035
    assert other.world.solver.timestep == 0.005
    was, now = (to_plain(one) for one in (default, other))
    was["world"].pop("sleeve"), now["world"].pop("sleeve")
    was["world"].pop("solver"), now["world"].pop("solver")
    assert was == now


@pytest.mark.parametrize("what", LEFT_OUT)
def test_the_same_commands_are_played_in_both_worlds(what):
    plan = change_plan(f"{what}=true", "val50", 1)
    assert isinstance(find_study(plan.protocol.study), Change)
    done = dress_changed(f"{what}=true", StaysBriefly(), plan.jobs[0], plan.config)
    assert done.extra[DECIDED]
    assert len(done.extra[SECONDS]) == 2
    here, there = done.outcome, done.extra[REFERENCE]
    assert not here.success
    assert not there["success"]
    # The robot does the same; its servos feel little of the cloth.
    assert there["figures"]["tracking_error"] == pytest.approx(
        here.metrics["tracking_error"], abs=2e-3
    )


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ("wind=3", "unknown setting 'wind'; valid is name=value&..., of edge, grip_width"),
        ("garment=gown", "unknown setting 'garment'"),
        ("", "unknown setting ''"),
        ("edge", "'edge' is no"),
        ("edge=long", "edge is 'long'"),
        ("timestep=0.5", "timestep is 0.5, valid is"),
        ("bending=false", "valid is what the default is not"),
    ],
)
def test_what_cannot_be_changed_is_refused_in_a_line(change, told, tmp_path, capsys):
    with pytest.raises(InvalidInputError, match=told):
        change_plan(change)
    with pytest.raises(SystemExit) as left:
        main(["validate", "--change", change, "--out", str(tmp_path / "out")])
    errors = capsys.readouterr().err
    assert left.value.code == 2
    assert errors.count("\n") == 1
    assert told in errors
    assert not (tmp_path / "out").exists()


def test_a_run_can_be_resumed_and_replayed(tmp_path, capsys):
    out = tmp_path / "drag"
    command = ["validate", "--suite", "val50", "--postures", "1", "--change", "air_drag=true"]
    assert main([*command, "--out", str(out)]) in (None, 0, 1)
    summary = json.loads((out / "summary.json").read_text())
    assert summary["change"] == "air_drag=true"
    assert summary["config"]["reference"]["world"]["sleeve"]["air_drag"]
    assert "air_drag" not in summary["config"]["episode"]["world"]["sleeve"]
    assert summary["policies"]["n_episodes"] + summary["policies"]["n_void"] == 5
    assert "has air_drag=true" in (out / "report.md").read_text()
    capsys.readouterr()
    assert main(["replay", str(out), "0"]) in (None, 0)
    assert "identical to the recorded episode" in "".join(capsys.readouterr())
