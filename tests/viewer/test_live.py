"""What the page shows is the command line's episode, to the bit, wherever it is interrupted."""

from dataclasses import replace

import numpy as np
import pytest

from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record, replay
from dressing_sim.errors import InvalidInputError
from dressing_sim.motion import Drift, Motion
from dressing_sim.path import Path
from dressing_sim.viewer.lessons import Lessons, demonstration_of
from dressing_sim.viewer.live import Live


@pytest.fixture(scope="module")
def recording(posture):
    return record(Operator(), posture, seed=0)


@pytest.fixture(scope="module")
def live(posture):
    live = Live.of_policy(Operator(), posture, 0, EpisodeConfig())
    for _ in live.steps():
        pass
    return live


def test_it_is_the_recorded_episode_to_the_bit(live, recording):
    assert live.outcome.to_dict() == recording.outcome.to_dict()
    places = [live.dressing.start, *(moment.row.tcp for moment in live.moments[1:])]
    assert np.array_equal(places, recording.positions)


def test_each_moment_knows_where_the_arm_is_even_if_it_moves(live, posture):
    assert all(moment.arm is posture for moment in live.moments)
    drift = Motion(drift=(Drift("elbow_deg", 10.0, 0.0, 1.0),))
    moving = Live.of_policy(Operator(), replace(posture, motion=drift), 0, EpisodeConfig())
    for _ in range(60):
        moving.step()
    elbows = [moment.arm.elbow_deg - posture.elbow_deg for moment in moving.moments]
    assert elbows[0] == pytest.approx(0.0, abs=1e-9)
    assert elbows[-1] == pytest.approx(10.0, abs=0.05)
    assert (np.diff(elbows) > -1e-9).all()


def test_it_goes_on_from_any_moment_with_the_same_bits(posture, live, recording):
    again = Live.of_policy(Operator(), posture, 0, EpisodeConfig())
    for _ in range(130):
        again.step()
    again.back_to(61)
    assert (again.n_steps, len(again.moments)) == (61, 62)
    for _ in again.steps():
        pass
    assert again.outcome.to_dict() == recording.outcome.to_dict()
    assert np.array_equal(again.moments[-1].cloth, live.moments[-1].cloth)


def test_a_path_beyond_reach_has_a_verdict_without_moving(posture):
    far = Path(np.array([[0.5, 0.0, 0.5], [1.4, 0.0, 0.5]]), 0.05)
    live = Live.of_policy(far, posture, 0, EpisodeConfig())
    assert live.outcome.reasons == ("ik_unreachable",)
    assert not live.step()


def led(posture, path):
    """A dressing by hand along a path, as somebody would drag the gripper."""
    live = Live.by_hand(posture, EpisodeConfig())
    for place in path:
        live.leader.target = place
        while not live.waits and not live.over:
            live.step()
    live.let_go()
    for _ in live.steps():
        pass
    return live


@pytest.fixture(scope="module")
def take(posture, recording):
    return led(posture, recording.trajectory.targets[::10])


def test_by_hand_time_stands_still_while_the_gripper_is_where_it_should_be(posture):
    live = Live.by_hand(posture, EpisodeConfig())
    assert live.waits
    live.leader.target = live.dressing.start + [0.0, 0.0, 0.01]
    assert not live.waits


def test_a_take_by_hand_dresses_and_is_a_demonstration_that_can_be_replayed(take, tmp_path):
    assert take.outcome.success
    lessons = Lessons(tmp_path / "takes.h5")
    lessons.keep(demonstration_of(take))
    (kept,) = Lessons(tmp_path / "takes.h5").takes
    again = replay(kept)
    assert again.outcome.success
    n = len(kept.positions)
    assert np.array_equal(again.positions[:n], kept.positions)


def test_what_does_not_dress_is_no_demonstration(posture):
    failed = led(posture, [])
    assert not failed.outcome.success
    with pytest.raises(InvalidInputError, match="nothing to learn from"):
        demonstration_of(failed)


def test_a_policy_takes_over_what_a_hand_began(posture, recording):
    live = Live.by_hand(posture, EpisodeConfig())
    for place in recording.trajectory.targets[:100:10]:
        live.leader.target = place
        while not live.waits:
            live.step()
    before = live.n_steps
    live.hand_over(Path(recording.trajectory.targets, recording.trajectory.dt))
    for _ in live.steps():
        pass
    assert live.outcome.success
    assert live.n_steps > before
