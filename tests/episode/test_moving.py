"""Dressing a person who moves: everything that looks at the arm follows it."""

from dataclasses import fields, replace

import numpy as np
import pytest

from dressing_sim.episode.capture import CaptureConfig
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.meter import Row
from dressing_sim.episode.rollout import begin
from dressing_sim.motion import UNITS, Compliance, Drift, Motion, Sway
from dressing_sim.world.dressed import ArmAxis

EXACT = CaptureConfig(rate=25.0, latency=0.1, position_noise=0.0, angle_noise=0.0)
BRIEF = EpisodeConfig(hold=0.1, time_limit=1.0, capture=EXACT)
SWAY = Motion(
    (Sway("flexion_deg", 5.0, 0.8, 60.0), Sway("shoulder_z", 0.02, 0.5)),
    (Drift("elbow_deg", 8.0, 0.0, 1.0),),
    ease=0.2,
)
DT = BRIEF.tracking.dt
STEPS = 25


def upwards(dressing, steps=STEPS):
    return [dressing.step(np.add(dressing.start, [0.0, 0.0, 1e-3 * n])) for n in range(steps)]


def arm_at(posture, time):
    """The still posture where the motion has the arm so long after the start [s]."""
    return posture.at(posture.coordinates + posture.motion.offsets(time) / UNITS)


@pytest.fixture(scope="module")
def swaying(posture):
    moving = replace(posture, name="swaying", motion=SWAY)
    dressing = Dressing(moving, BRIEF)
    dressing.reset()
    rows, seen, cloths, shoulders = [], [], [], []
    for n in range(STEPS):
        rows.append(dressing.step(np.add(dressing.start, [0.0, 0.0, 1e-3 * n])))
        seen.append(dressing.seen)
        cloths.append(dressing.world.cloth)
        shoulders.append(dressing.shoulder)
    return moving, dressing, rows, seen, cloths, shoulders


def test_a_still_arm_is_the_same_object_to_whoever_looks(posture):
    dressing = Dressing(posture, BRIEF)
    dressing.reset()
    upwards(dressing, 3)
    assert dressing.seen is posture
    assert dressing.trace().arm is None


def test_a_still_arm_may_be_measured_once_with_noise(posture):
    seen = []
    for noise in (0.0, 0.01, 0.02):
        capture = CaptureConfig(position_noise=noise, angle_noise=noise, still=True)
        dressing = Dressing(posture, replace(BRIEF, capture=capture))
        before = dressing.seen
        dressing.reset()
        begun = dressing.seen
        upwards(dressing, 10)
        assert dressing.seen is begun
        assert begun == before
        seen.append(before.coordinates * UNITS)
    exact = posture.coordinates * UNITS
    np.testing.assert_allclose(seen[0], exact, atol=1e-12)
    np.testing.assert_allclose(seen[2] - exact, 2.0 * (seen[1] - exact), atol=1e-12)
    assert np.all(seen[1] != exact)


def test_a_motion_of_nothing_is_a_still_arm(posture):
    """Other bits, for its solver has seven unknowns more; the same dressing."""
    traces = []
    for motion in (None, Motion()):
        dressing = Dressing(replace(posture, motion=motion), BRIEF)
        dressing.reset()
        upwards(dressing)
        traces.append(dressing.trace())
    still, moving = traces
    for name, near in (("tcp", 2e-5), ("clearance", 2e-5), ("armscye_s", 5e-3), ("strain", 1e-3)):
        np.testing.assert_allclose(getattr(moving, name), getattr(still, name), atol=near)
    np.testing.assert_array_equal(moving.wound, still.wound)
    np.testing.assert_allclose(moving.grip_force, still.grip_force, atol=5e-3)


def test_the_trace_says_where_the_arm_was(swaying):
    moving, dressing, *_, shoulders = swaying
    trace, lag = dressing.trace(), dressing.world.model.opt.timestep
    for row, arm in enumerate(trace.arm):
        there = arm_at(moving, (row + 1) * DT - lag)
        wanted = np.stack([there.wrist, there.elbow, there.shoulder])
        np.testing.assert_allclose(arm, wanted, atol=1e-9)
    np.testing.assert_array_equal(trace.arm[:, 2], shoulders)
    assert np.abs(trace.arm[-1] - trace.arm[0]).max() > 0.01
    assert len(trace[:10].arm) == 10


def test_arm_coordinate_windings_and_clearance_are_of_the_arm_as_it_is_then(swaying):
    moving, dressing, rows, _, cloths, _ = swaying
    trace, mesh = dressing.trace(), dressing.world.mesh
    for row in (0, 12, STEPS - 1):
        axis = ArmAxis.of(moving, trace.arm[row])
        rings = mesh.rings(cloths[row])
        middles = np.stack([rings[0].mean(axis=0), rings[-1].mean(axis=0)])
        assert axis.coordinate(middles) == pytest.approx([trace.armscye_s[row], trace.hem_s[row]])
        assert rows[row].armscye_s == trace.armscye_s[row]
        assert (axis.winding(rings) == 1).all() == trace.wound[row]
    # The clearance is that of a still arm at the same coordinates.
    last = arm_at(moving, STEPS * DT - dressing.world.model.opt.timestep)
    world = Dressing(last, BRIEF)
    world.reset()
    nearest = world.world.clearance(trace.tcp[-1:])
    np.testing.assert_allclose(trace.clearance[-1:], nearest, atol=1e-6)


def test_the_verdict_is_by_the_shoulder_as_it_is_then(swaying):
    moving, dressing, *_ = swaying
    trace = dressing.trace()
    distance = np.linalg.norm(trace.tcp[-1] - trace.arm[-1, 2])
    assert dressing.outcome().metrics["gripper_distance"] == pytest.approx(distance)
    assert abs(distance - np.linalg.norm(trace.tcp[-1] - moving.shoulder)) > 1e-3
    margin = dressing.margins()["stopped_short"]
    held = slice(-max(1, round(BRIEF.thresholds.hold_time / DT)), None)
    near = BRIEF.thresholds.gripper_distance - np.linalg.norm(trace.tcp - trace.arm[:, 2], axis=1)
    height = trace.tcp[:, 2] - trace.arm[:, 2, 2]
    assert margin == pytest.approx(np.minimum(near, height)[held].min())


def test_what_is_seen_is_the_arm_as_it_was_when_it_was_measured(swaying):
    moving, _, rows, seen, *_ = swaying
    for row, posture in zip(rows, seen, strict=True):
        number = int(np.floor(max(row.time - EXACT.latency, 0.0) * EXACT.rate + 1e-9))
        there = arm_at(moving, number / EXACT.rate)
        np.testing.assert_allclose(posture.coordinates, there.coordinates, atol=1e-6)
        assert posture.motion is None
    assert len({id(posture) for posture in seen}) == 11  # 25 a second, in 0.4 s, and the first


@pytest.mark.parametrize(
    "motion", [SWAY, replace(SWAY, compliance=Compliance())], ids=["led", "compliant"]
)
def test_from_a_snapshot_it_goes_on_with_the_same_bits(posture, motion):
    moving = replace(posture, name="again", motion=motion)
    config = replace(BRIEF, capture=CaptureConfig())
    whole = Dressing(moving, config)
    whole.reset()
    upwards(whole, 12)
    snapshot = whole.snapshot()

    def rest(dressing):
        rows = [dressing.step(np.add(dressing.start, [0.0, 1e-3 * n, 0.02])) for n in range(12)]
        return rows, dressing.trace(), dressing.seen

    rows, trace, seen = rest(whole)
    other = Dressing(moving, config)
    for dressing in (other, whole):
        dressing.restore(snapshot)
        np.testing.assert_array_equal(dressing.world.arm_joints, trace.arm[11])
        again, traced, looked = rest(dressing)
        for one in fields(Row):
            for a, b in zip(rows, again, strict=True):
                np.testing.assert_array_equal(getattr(a, one.name), getattr(b, one.name))
        for one in fields(type(trace)):
            np.testing.assert_array_equal(getattr(trace, one.name), getattr(traced, one.name))
        assert looked == seen


def test_cloth_moves_a_compliant_arm_and_a_softer_one_more(posture):
    """Both arms carry their own weight, so what moves them is the sleeve that hangs on them."""
    sunk = []
    for factor in (1.0, 0.25):
        stiffness = tuple(factor * k for k in Compliance().stiffness)
        motion = Motion(compliance=Compliance(stiffness))
        dressing = Dressing(replace(posture, motion=motion), BRIEF)
        dressing.reset()
        sunk.append(float((posture.wrist - dressing.world.arm_joints[0])[2]))
    assert 1e-5 < sunk[0] < sunk[1] < 0.02


def test_through_gymnasium_and_dm_env_it_is_the_same_dressing(posture):
    gymnasium = pytest.importorskip("gymnasium")
    from dressing_sim.envs import GYMNASIUM_ID

    moving = replace(posture, name="swaying", motion=SWAY)
    core = Dressing(moving, BRIEF)
    options = {"posture": moving, "control": "target", "finish": "arrival", "episode": BRIEF}
    env = gymnasium.make(GYMNASIUM_ID, **options)
    env.reset(seed=0)
    begin(core)
    for n in range(10):
        target = np.add(core.start, [0.0, 0.0, 1e-3 * n])
        row = core.step(target)
        seen, *_ = env.step(target)
        np.testing.assert_array_equal(seen["gripper"], row.tcp)
        frames = core.seen.frames()
        np.testing.assert_array_equal(seen["wrist_position"], frames[1].b)
    assert np.abs(frames[1].b - moving.wrist).max() > 1e-4  # it is told that the arm moves
    dm = pytest.importorskip("dressing_sim.envs.dm")
    environment = dm.load(**options)
    environment.reset()
    for n in range(10):
        told = environment.step(np.add(core.start, [0.0, 0.0, 1e-3 * n])).observation
    np.testing.assert_array_equal(told["gripper"], seen["gripper"])
    np.testing.assert_array_equal(told["wrist_position"], seen["wrist_position"])
