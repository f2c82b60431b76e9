"""A dressing advanced by hand: the same bits as a path that is played, from any moment again."""

import subprocess
import sys
from dataclasses import fields, replace

import numpy as np
import pytest

from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import record
from dressing_sim.episode.rollout import follow
from dressing_sim.errors import InvalidInputError

BRIEF = EpisodeConfig(hold=0.1, time_limit=0.2)


@pytest.fixture(scope="module")
def recorded(posture):
    return record(Operator(), posture, seed=0)


@pytest.fixture
def dressing(posture):
    made = Dressing(posture)
    made.reset()
    return made


def begun(posture, recorded, steps):
    """A dressing led along the recorded targets for so many steps."""
    trajectory = recorded.trajectory
    made = Dressing(posture)
    made.reset(trajectory.positions[0], trajectory.targets[0])
    for target in trajectory.targets[1 : steps + 1]:
        made.step(target)
    return made


def go_on(dressing, recorded, first, steps):
    return [dressing.step(t) for t in recorded.trajectory.targets[first + 1 : first + 1 + steps]]


def same_rows(one, other):
    for a, b in zip(one, other, strict=True):
        for field in fields(Row):
            np.testing.assert_array_equal(getattr(a, field.name), getattr(b, field.name))


def test_stepping_through_a_path_is_playing_it(posture, recorded):
    made = begun(posture, recorded, len(recorded.trajectory.targets) - 1)
    trace, whole = made.trace(), recorded.trace
    for column in ("tcp", "joint_position", "torque", "strain", "grip_force", "wound", "hit_by"):
        np.testing.assert_array_equal(getattr(trace, column), getattr(whole, column)[: len(trace)])
    # What is left of the recording is the final hold.
    last = recorded.trajectory
    while len(made.trace()) < len(whole):
        made.step_joints(last.positions[-1], last.targets[-1])
    assert made.done is False
    assert made.outcome() == recorded.outcome


def test_rows_are_those_of_the_trace(posture, recorded):
    made = Dressing(posture)
    trajectory = recorded.trajectory
    made.reset(trajectory.positions[0], trajectory.targets[0])
    rows = go_on(made, recorded, 0, 60)
    trace = made.trace()
    assert len(trace) == 60
    for number, row in enumerate(rows):
        assert row.time == pytest.approx((number + 1) * trace.dt)
        for name in ("tcp", "grip_force", "link_force", "strain", "holding", "tracking_error"):
            np.testing.assert_array_equal(getattr(row, name), getattr(trace, name)[number])
        assert row.armscye_s == pytest.approx(trace.armscye_s[number], abs=1e-12)
        assert row.hem_s == pytest.approx(trace.hem_s[number], abs=1e-12)
    assert [row.limited() for row in rows] == list(trace.limited())


@pytest.mark.parametrize("steps", [1, 77, 200])
def test_a_restored_snapshot_goes_on_with_the_same_bits(posture, recorded, steps):
    one = begun(posture, recorded, steps)
    moment, now = one.snapshot(), one.row
    expected = go_on(one, recorded, steps, 40)
    other = Dressing(posture)
    same_rows([other.restore(moment), one.restore(moment)], [now, now])
    same_rows(go_on(other, recorded, steps, 40), expected)
    # And again, from where it has gone to.
    other.restore(moment)
    same_rows(go_on(other, recorded, steps, 40), expected)


def test_branches_do_not_disturb_each_other(posture, recorded):
    trunk = begun(posture, recorded, 100)
    moment = trunk.snapshot()
    straight = go_on(trunk, recorded, 100, 20)
    trunk.restore(moment)
    for _ in range(20):
        aside = trunk.step(np.add(trunk.target, [0.004, 0.0, 0.0]))
    assert np.linalg.norm(aside.tcp - straight[-1].tcp) > 0.02
    trunk.restore(moment)
    same_rows(go_on(trunk, recorded, 100, 20), straight)


def test_a_snapshot_taken_of_a_restored_dressing_is_the_same_bytes(posture, recorded):
    moment = begun(posture, recorded, 50).snapshot()
    other = Dressing(posture)
    other.restore(moment)
    assert other.snapshot() == moment


def test_another_process_goes_on_with_the_same_bits(posture, recorded, tmp_path):
    one = begun(posture, recorded, 120)
    (tmp_path / "moment").write_bytes(one.snapshot())
    np.save(tmp_path / "targets.npy", recorded.trajectory.targets[121:141])
    code = (
        "import sys, numpy as np; from dressing_sim.suites.suites import load_suite\n"
        "from dressing_sim.episode.dressing import Dressing\n"
        "d = Dressing(load_suite('paper5')[1]); d.restore(open('moment', 'rb').read())\n"
        "rows = [d.step(t) for t in np.load('targets.npy')]\n"
        "sys.stdout.write(rows[-1].tcp.tobytes().hex() + d.snapshot().hex())"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True
    )
    row = go_on(one, recorded, 120, 20)[-1]
    assert done.stdout == row.tcp.tobytes().hex() + one.snapshot().hex()


def test_a_damaged_or_foreign_snapshot_is_refused_and_changes_nothing(posture, dressing):
    dressing.step(dressing.start)
    moment = dressing.snapshot()
    flipped = bytearray(moment)
    flipped[len(moment) // 2] ^= 1
    another = Dressing(replace(posture, elbow_deg=31.0))
    another.reset()
    for bad in (b"", b"x", moment[:-1], moment[:100], bytes(flipped), another.snapshot(), "text"):
        with pytest.raises(InvalidInputError, match="snapshot"):
            dressing.restore(bad)
    later = moment[:7] + bytes([99]) + moment[8:]
    with pytest.raises(InvalidInputError, match="version 99"):
        dressing.restore(later)
    assert dressing.snapshot() == moment


@pytest.mark.parametrize(
    "target", [np.full(3, np.nan), [0.1, np.inf, 0.2], [0.1, 0.2], "up", None, np.zeros((3, 1))]
)
def test_a_target_that_is_none_is_refused_and_nothing_moves(dressing, target):
    before = dressing.snapshot()
    with pytest.raises(InvalidInputError, match="target"):
        dressing.step(target)
    assert dressing.snapshot() == before


def test_joint_commands_are_checked_too(dressing):
    for command in (np.full(7, np.nan), np.zeros(6)):
        with pytest.raises(InvalidInputError, match="joint command"):
            dressing.step_joints(command)


def test_a_target_far_away_is_a_direction(dressing):
    start = dressing.row.tcp
    rows = [dressing.step(np.add(start, [0.0, 0.5, 0.0])) for _ in range(50)]
    speed = np.linalg.norm(np.diff([row.tcp for row in rows], axis=0), axis=1) / 0.02
    assert 0.1 < speed.max() <= dressing.config.tracking.max_speed * 1.05


def test_the_hand_turns_as_it_is_told(dressing):
    from dressing_sim.control import RobotKinematics

    angle = np.deg2rad(15.0)
    turn = np.array(
        [[np.cos(angle), np.sin(angle), 0], [np.sin(angle), -np.cos(angle), 0], [0, 0, -1.0]]
    )
    for _ in range(60):
        row = dressing.step(dressing.start, turn)
    reached = RobotKinematics().tcp_pose(row.joint_position)[1]
    assert np.arccos(np.clip((np.trace(reached.T @ turn) - 1) / 2, -1, 1)) < np.deg2rad(3.0)


def test_a_dressing_ends_at_its_time_limit_and_not_before(posture):
    made = Dressing(posture, BRIEF)
    made.reset()
    steps = 0
    while not made.done:
        made.step(made.start)
        steps += 1
    assert steps == round(BRIEF.time_limit / BRIEF.tracking.dt)
    assert "timeout" in made.outcome().reasons
    assert "timeout" not in made.outcome(finished=True).reasons
    with pytest.raises(InvalidInputError, match="over"):
        made.step(made.start)
    made.reset()
    assert not made.done


def test_what_has_not_begun_says_so(posture):
    made = Dressing(posture)
    assert not made.done
    for ask in (lambda: made.step(made.start), made.trace, made.snapshot, lambda: made.world):
        with pytest.raises(InvalidInputError, match=r"reset\(\)"):
            ask()
    made.reset()
    with pytest.raises(InvalidInputError, match="nothing was measured"):
        made.trace()


def test_resetting_begins_with_the_same_bits(posture, dressing):
    first = [dressing.step(np.add(dressing.start, [0, 0, 0.01])) for _ in range(5)]
    dressing.reset()
    same_rows([dressing.step(np.add(dressing.start, [0, 0, 0.01])) for _ in range(5)], first)


def test_a_world_that_breaks_down_is_done_and_invalid(dressing, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    row = dressing.step(dressing.start)
    dressing.world.data.qvel[-1] = np.nan
    assert dressing.step(dressing.start) is row
    assert dressing.done
    assert dressing.outcome().invalid is not None
    # A snapshot of the broken world is still broken.
    moment = dressing.snapshot()
    dressing.reset()
    dressing.restore(moment)
    assert dressing.done
    assert dressing.outcome().invalid is not None


def test_a_stop_that_builds_up_is_part_of_a_snapshot(posture):
    """The robot may pull too hard for a moment; how long it already has must not be forgotten."""
    bent = replace(posture, name="bent", elbow_deg=65.0)
    end = np.add(bent.shoulder, [0.0, 0.0, 0.09])
    path = np.linspace(Dressing(bent).start, end, 90)
    made = Dressing(bent)

    whole = follow(made, path, 0.05)
    assert "over_force" in whole.outcome.reasons or "over_strain" in whole.outcome.reasons
    n = len(whole.trace)
    again = Dressing(bent)
    again.reset(whole.trajectory.positions[0], whole.trajectory.targets[0])
    steps = list(zip(whole.trajectory.positions, whole.trajectory.targets, strict=True))[1:]
    for command, target in steps[: n - 4]:
        again.step_joints(command, target)
    moment = again.snapshot()
    other = Dressing(bent)
    other.restore(moment)
    for command, target in steps[n - 4 : n]:
        assert not other.done
        other.step_joints(command, target)
    assert other.done
    assert other.stopped
    assert other.outcome() == whole.outcome
