import numpy as np
import pytest

from dressing_sim.arm import Posture
from dressing_sim.episode.operator import Operator, OperatorConfig
from dressing_sim.errors import InvalidInputError
from dressing_sim.inputs import inputs_of
from dressing_sim.learning import Frame, SyntheticDemonstration, dtw_distance, rotation
from dressing_sim.policies.files import load_policy, save_policy
from dressing_sim.policies.registry import make_policy
from dressing_sim.policies.skeleton import Skeleton
from dressing_sim.policies.transported import ELBOW_OFFSETS, TransportConfig, TransportPolicy
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.scene import WorldConfig, grip_start

STEADY = OperatorConfig(
    speed_variation=0.0, height_variation=0.0, waypoint_variation=0.0, sway=0.0, tremor=0.0
)
VALIDATION = load_suite("val50")[:12]


def begin(posture):
    return grip_start(posture, WorldConfig().sleeve)


def demonstration(posture, seed=0, config=None):
    """Where the operator wants the gripper to go; nothing is simulated."""
    operator = Operator(config)
    path = operator.generate(posture, begin(posture), seed)
    return SyntheticDemonstration(path.positions, path.dt, posture.frames())


def fitted(suite="case_a", config=None, **operator):
    shown = [
        demonstration(posture, seed, **operator) for seed, posture in enumerate(load_suite(suite))
    ]
    return TransportPolicy(config).fit(shown), shown


@pytest.fixture(scope="module", params=["case_a", "case_b"])
def learned(request):
    return fitted(request.param)


@pytest.fixture(scope="module")
def policy():
    return fitted()[0]


def test_it_is_built_in_and_sees_frames_alone():
    made = make_policy("transport?slope_to_noise=3&clearance=false")
    assert isinstance(made, TransportPolicy)
    assert made.config == TransportConfig(slope_to_noise=3.0, clearance=False)
    assert inputs_of(made) == "frames"


def test_one_demonstration_is_reproduced_in_its_own_situation():
    for posture in load_suite("case_a"):
        shown = demonstration(posture)
        path = TransportPolicy().fit([shown]).generate(shown.frames, shown.positions[0])
        assert dtw_distance(path.positions, shown.positions) < 1e-3
        np.testing.assert_allclose(path.positions[[0, -1]], shown.positions[[0, -1]], atol=3e-3)
        assert len(path) * path.dt == pytest.approx(len(shown.positions) * shown.dt, rel=0.15)


def test_two_demonstrations_are_nearly_reproduced(learned):
    policy, shown = learned
    for one in shown:
        path = policy.generate(one.frames, one.positions[0])
        assert dtw_distance(path.positions, one.positions) < 5e-3


def test_the_answer_begins_at_the_gripper_and_ends_over_the_shoulder(learned):
    policy, _ = learned
    for posture in VALIDATION:
        start = begin(posture) + [0.01, -0.02, 0.005]
        path = policy.generate(posture.frames(), start)
        np.testing.assert_allclose(path.positions[0], start, atol=1e-12)
        end = path.positions[-1] - posture.shoulder
        assert 0.05 < end[2] < 0.12
        assert np.linalg.norm(end) < 0.13


@pytest.mark.parametrize("elbow_deg", [0, 0.5, 3, 30, 90, 120, 150])
def test_straight_and_strongly_bent_arms_get_a_path(learned, elbow_deg):
    policy, _ = learned
    posture = Posture("arm", 75, 20, 40, elbow_deg)
    path = policy.generate(posture.frames(), begin(posture))
    assert np.all(np.isfinite(path.positions))
    assert np.linalg.norm(np.diff(path.positions, axis=0), axis=1).max() / path.dt < 0.5
    assert 2.0 < len(path) * path.dt < 15.0


def test_the_answer_changes_little_with_the_arm(policy):
    """A degree more of any angle, the straight arm included, moves no phase by much."""
    for angles in ([70, 20, 30, 0], [70, 20, 30, 1], [60, 40, 45, 62]):
        arms = [Posture("arm", *(np.array(angles) + step)) for step in ([0] * 4, [1] * 4)]
        one, other = (policy.answer(arm.frames(), begin(arm)).points for arm in arms)
        assert np.linalg.norm(one - other, axis=1).max() < 0.03


def test_a_turn_about_the_vertical_and_a_shift_move_the_answer_along(learned):
    policy, _ = learned
    turn, shift = rotation([0.0, 0.0, 1.1]), np.array([0.2, -0.1, 0.3])
    for posture in VALIDATION[:4]:
        moved = [Frame(turn @ frame.A, turn @ frame.b + shift) for frame in posture.frames()]
        here = policy.answer(posture.frames(), begin(posture))
        there = policy.answer(moved, turn @ begin(posture) + shift)
        np.testing.assert_allclose(there.points, here.points @ turn.T + shift, atol=1e-6)
        np.testing.assert_allclose(there.deviation, here.deviation, atol=1e-6)
        np.testing.assert_allclose(there.times, here.times, rtol=1e-6)


def test_practised_offsets_move_the_path_where_it_passes_a_bent_elbow():
    straight = Posture("straight", 70.0, 20.0, 30.0, 0.0)
    plain, _ = fitted()
    for name in ELBOW_OFFSETS:
        moved, _ = fitted(config=TransportConfig(**{name: 0.1}))
        for posture in VALIDATION[:4]:
            here, there = (p.answer(posture.frames(), begin(posture)) for p in (plain, moved))
            skeleton = Skeleton.of(posture.frames())
            scale = float(plain._known().bones.sum())
            offset = np.linalg.norm(there.points - here.points, axis=1)
            bend = skeleton.sideways if name == "elbow_out" else skeleton.bend
            assert offset.max() == pytest.approx(0.1 * scale * bend, rel=0.01)
            assert abs(int(offset.argmax()) - len(offset) // 2) <= 1
            np.testing.assert_allclose(offset[[0, -1]], 0.0, atol=1e-12)
            np.testing.assert_array_equal(there.times, here.times)
        one, other = (p.answer(straight.frames(), begin(straight)).points for p in (plain, moved))
        np.testing.assert_allclose(one, other, atol=1e-6)


def test_offsets_turn_with_the_arm():
    policy, _ = fitted(config=TransportConfig(elbow_out=0.1, elbow_along=-0.1, elbow_up=0.05))
    turn, shift = rotation([0.0, 0.0, 1.1]), np.array([0.2, -0.1, 0.3])
    posture = VALIDATION[1]
    moved = [Frame(turn @ frame.A, turn @ frame.b + shift) for frame in posture.frames()]
    here = policy.answer(posture.frames(), begin(posture)).points
    there = policy.answer(moved, turn @ begin(posture) + shift).points
    np.testing.assert_allclose(there, here @ turn.T + shift, atol=1e-6)


def test_the_unit_of_length_does_not_matter():
    _, shown = fitted()
    posture = VALIDATION[0]
    large = [
        SyntheticDemonstration(
            1e3 * one.positions, one.dt, [Frame(frame.A, 1e3 * frame.b) for frame in one.frames]
        )
        for one in shown
    ]
    here = TransportPolicy().fit(shown).answer(posture.frames(), begin(posture))
    frames = [Frame(frame.A, 1e3 * frame.b) for frame in posture.frames()]
    there = TransportPolicy().fit(large).answer(frames, 1e3 * begin(posture))
    np.testing.assert_allclose(there.points, 1e3 * here.points, atol=1e-2)
    np.testing.assert_allclose(there.deviation, 1e3 * here.deviation, rtol=1e-3)


def test_pauses_and_the_sampling_rate_of_a_demonstration_hardly_matter():
    policy, shown = fitted()
    one = shown[0]
    still = np.concatenate(
        [np.tile(one.positions[0], (500, 1)), one.positions, np.tile(one.positions[-1], (250, 1))]
    )
    times = np.arange(len(one.positions)) * one.dt
    fine = np.arange(0.0, times[-1], 1e-3)
    dense = np.column_stack([np.interp(fine, times, column) for column in one.positions.T])
    for positions, dt in ((still, one.dt), (dense, 1e-3)):
        other = TransportPolicy().fit([SyntheticDemonstration(positions, dt, one.frames), shown[1]])
        for posture in VALIDATION[:3]:
            found = other.answer(posture.frames(), begin(posture))
            expected = policy.answer(posture.frames(), begin(posture))
            np.testing.assert_allclose(found.points, expected.points, atol=4e-3)
            assert found.times[-1] == pytest.approx(expected.times[-1], rel=0.1)


def test_the_path_keeps_the_demonstrated_distances(learned):
    policy, shown = learned
    skeletons = [Skeleton.of(one.frames) for one in shown]
    nearest = min(
        np.linalg.norm(skeleton.outward(one.positions), axis=1).min()
        for skeleton, one in zip(skeletons, shown, strict=True)
    )
    for posture in VALIDATION:
        skeleton = Skeleton.of(posture.frames())
        path = policy.generate(posture.frames(), begin(posture)).positions
        assert np.linalg.norm(skeleton.outward(path), axis=1).min() > nearest - 5e-3


@pytest.mark.parametrize("suite", ["case_a", "case_b"])
def test_held_out_paths_are_within_the_deviation(suite):
    """Two deviations hold most of an operator's paths, and are not held far too wide."""
    policy, _ = fitted(suite)
    scaled = []
    for number, posture in enumerate(VALIDATION):
        answer = policy.answer(posture.frames(), begin(posture))
        path = Operator().generate(posture, begin(posture), 100 + number).positions
        gaps = np.linalg.norm(answer.points[:, None] - path[None], axis=2).min(axis=1)
        scaled.append(gaps / (np.sqrt(3.0) * answer.deviation))
    scaled = np.array(scaled)
    assert np.mean(scaled < 2.0) > 0.8
    assert np.sqrt(np.mean(scaled**2)) > 0.2


def test_a_saved_policy_answers_with_the_same_bits(learned, tmp_path):
    policy, _ = learned
    loaded = load_policy(save_policy(policy, tmp_path / "policy.npz"))
    assert loaded.config == policy.config
    for posture in VALIDATION[:3]:
        one, other = (p.generate(posture.frames(), begin(posture)) for p in (policy, loaded))
        np.testing.assert_array_equal(one.positions, other.positions)
        assert one.dt == other.dt


def test_learning_twice_gives_the_same_bits(learned):
    policy, shown = learned
    again = TransportPolicy().fit(shown)
    for posture in VALIDATION[:3]:
        one, other = (p.generate(posture.frames(), begin(posture)) for p in (policy, again))
        np.testing.assert_array_equal(one.positions, other.positions)


def test_an_unfitted_policy_and_half_a_dressing_are_refused():
    posture = VALIDATION[0]
    with pytest.raises(InvalidInputError, match="fit"):
        TransportPolicy().generate(posture.frames(), begin(posture))
    whole = demonstration(posture)
    half = SyntheticDemonstration(whole.positions[:60], whole.dt, whole.frames)
    with pytest.raises(InvalidInputError, match="demonstration 1 does not pass the elbow"):
        TransportPolicy().fit([whole, half])


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("length", 0.0),
        ("slope_to_noise", -1.0),
        ("stations", 1),
        ("phases", 0),
        ("dip", np.nan),
        ("feature", "x"),
        ("elbow_up", 1.5),
    ],
)
def test_hyperparameters_that_mean_nothing_are_refused(name, value):
    with pytest.raises(InvalidInputError, match=name):
        TransportConfig(**{name: value})
