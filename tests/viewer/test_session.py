"""A page's state without a browser."""

import socket
from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.commands.dress import _source
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.record import record
from dressing_sim.errors import InvalidInputError
from dressing_sim.viewer.choices import TAKES, Choices
from dressing_sim.viewer.lessons import Lessons
from dressing_sim.viewer.session import Session

LONG = 300.0


@pytest.fixture
def session(tmp_path):
    session = Session(Lessons(tmp_path / "takes.h5"))
    session.set_speed(0.0)
    yield session
    session.close()


def dressed(session):
    assert session.wait(lambda: session.live is not None and session.live.over, LONG)
    assert session.error == ""
    return session.live.outcome


def test_a_dressing_of_the_page_is_that_of_the_command_line_to_the_bit(session):
    session.dress()
    outcome = dressed(session)
    config = EpisodeConfig()
    policy = _source("default", "case_a", 0, config)[0]
    expected = record(policy, Choices().posture, 0, config).outcome
    assert outcome.to_dict() == expected.to_dict()


def test_it_is_paused_looked_back_at_and_gone_on_with(session):
    session.choose(replace(session.choices, policy="expert"))
    session.dress()
    assert session.wait(lambda: session.live is not None and session.live.n_steps > 40, LONG)
    session.pause()
    assert session.wait(lambda: not session.running, LONG)
    steps = session.live.n_steps
    session.step_once()
    assert session.wait(lambda: session.live.n_steps == steps + 1, LONG)
    session.look_at(10)
    assert session.moment() is session.live.moments[10]
    session.take_over()
    assert session.wait(lambda: session.by_hand and session.live.n_steps == 10, LONG)
    session.lead(session.live.dressing.target + [0.0, 0.0, 0.02])
    assert session.wait(lambda: session.live.n_steps > 14, LONG)


def test_the_path_follows_the_choices_and_the_last_one_wins(session):
    session.choose(replace(session.choices, policy="expert"))
    for angle in range(30, 60):
        session.choose(session.choices.bent(elbow_deg=float(angle)))
    last = session.choices
    assert session.wait(
        lambda: session.preview is not None and session.preview.choices is last, LONG
    )
    assert session.preview.why == ""
    assert np.allclose(session.preview.path.positions[0], session.preview.start, atol=1e-3)


def test_another_arm_ends_the_dressing_that_is_looked_at(session):
    session.choose(replace(session.choices, policy="expert"))
    session.dress()
    assert session.wait(lambda: session.running and session.live.n_steps > 3, LONG)
    session.choose(session.choices.bent(elbow_deg=20.0))
    assert session.wait(lambda: not session.running, LONG)
    assert not session.showing


def test_what_goes_wrong_is_told_in_one_line(session):
    session.choose(replace(session.choices, demonstrations=TAKES))
    assert session.wait(lambda: session.error != "", LONG)
    assert "no takes yet" in session.error
    assert "\n" not in session.error
    with pytest.raises(InvalidInputError, match="lead the gripper by hand"):
        session.keep_take()
    with pytest.raises(InvalidInputError, match="no run is open"):
        session.replay("tp-gmm", "bent40")


def test_a_taken_port_is_one_line_and_exit_code_2(tmp_path, monkeypatch, capsys):
    pytest.importorskip("viser")
    from dressing_sim.cli import main

    monkeypatch.chdir(tmp_path)
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(SystemExit) as end:
            main(["view", "--port", str(port)])
    assert end.value.code == 2
    told = capsys.readouterr().err
    assert told.count("\n") == 1
    assert f"port {port}" in told
