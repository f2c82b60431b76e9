import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from learning_tasks import reaching_demonstrations
from scipy.spatial.transform import Rotation

from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import (
    BoundsSampler,
    Frame,
    FrameBounds,
    SituationSampler,
    SyntheticDemonstration,
    euler_angles,
    rotation,
)
from dressing_sim.learning.sampling import arcs

angle = st.floats(-np.pi, np.pi)


@given(angle, angle, angle)
def test_rotations_about_the_fixed_axes(alpha, beta, gamma):
    angles = [alpha, beta, gamma]
    expected = Rotation.from_euler("xyz", angles).as_matrix()
    np.testing.assert_allclose(rotation(angles), expected, atol=1e-12)


@given(st.floats(-3.1, 3.1), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_angles_are_read_back(alpha, beta, gamma):
    angles = [alpha, beta, gamma]
    np.testing.assert_allclose(euler_angles(rotation(angles)), angles, atol=1e-6)
    np.testing.assert_allclose(euler_angles(rotation(alpha)), [alpha], atol=1e-12)


@given(st.floats(-3.1, 3.1), st.sampled_from([-0.5 * np.pi, 0.5 * np.pi]), st.floats(-3.1, 3.1))
def test_where_only_a_sum_of_angles_counts_they_are_still_those_of_the_rotation(alpha, beta, gamma):
    turned = rotation([alpha, beta, gamma])
    np.testing.assert_allclose(rotation(euler_angles(turned)), turned, atol=1e-9)


def test_samples_fill_their_bounds_and_stay_inside():
    base = 0.5 * np.diag([-1.0, 1.0])
    bounds = FrameBounds(base, ([0.2], [1.0]), ([-1, 0], [1, 3]))
    rng = np.random.default_rng(0)
    frames = [bounds.sample(rng) for _ in range(500)]
    angles = np.array([euler_angles(f.A @ np.linalg.inv(base)) for f in frames])[:, 0]
    origins = np.array([f.b for f in frames])
    assert 0.2 <= angles.min() < 0.22
    assert 0.98 < angles.max() <= 1.0
    assert (origins >= [-1, 0]).all()
    assert (origins <= [1, 3]).all()
    assert np.ptp(origins[:, 1]) > 2.9
    for frame in frames:
        assert np.linalg.det(frame.A) == pytest.approx(-0.25)


def test_a_fixed_frame_stays():
    frame = Frame(2 * rotation([1.0, 2.0, 0.3]), [1, 2, 3])
    sampled = FrameBounds.fixed(frame).sample(np.random.default_rng(0))
    np.testing.assert_allclose(sampled.A, frame.A)
    np.testing.assert_allclose(sampled.b, frame.b)


@pytest.mark.parametrize("turned", [0.0, np.pi])
def test_bounds_around_demonstrations_hold_them_wherever_the_angles_wrap(turned):
    turn = rotation([0, 0, turned])
    demonstrations = [
        type(d)(d.positions, d.dt, tuple(Frame(turn @ f.A, f.b) for f in d.frames))
        for d in reaching_demonstrations(4)
    ]
    sampler = BoundsSampler.around(demonstrations)
    assert isinstance(sampler, SituationSampler)
    for bounds, views in zip(
        sampler.bounds, zip(*[d.frames for d in demonstrations], strict=True), strict=True
    ):
        for view in views:
            angles = euler_angles(view.A @ bounds.base.T)
            assert (angles >= bounds.angles[0]).all()
            assert (angles <= bounds.angles[1]).all()
            assert (view.b >= bounds.translation[0]).all()
            assert (view.b <= bounds.translation[1]).all()
        assert (bounds.angles[1] - bounds.angles[0] < 2.0).all()


def test_a_frame_that_never_moves_is_kept_fixed():
    still = Frame(np.eye(3), np.zeros(3))
    demonstrations = [
        type(d)(d.positions, d.dt, (still, d.frames[1])) for d in reaching_demonstrations(3)
    ]
    rng = np.random.default_rng(0)
    frames = BoundsSampler.around(demonstrations).sample(rng)
    np.testing.assert_allclose(frames[0].A, still.A, atol=1e-12)
    np.testing.assert_allclose(frames[0].b, still.b, atol=1e-12)


def test_the_same_seed_gives_the_same_situation():
    sampler = BoundsSampler.around(reaching_demonstrations(3))
    a, b = (sampler.sample(np.random.default_rng(7)) for _ in range(2))
    assert a == b


@pytest.mark.parametrize(
    ("angles", "translation"),
    [
        (([1.0], [0.0]), ([0, 0], [1, 1])),
        (([0.0], [1.0]), ([0, 0], [-1, 1])),
        (([0.0], [np.inf]), ([0, 0], [1, 1])),
        (([0.0, 0, 0], [1.0, 1, 1]), ([0, 0], [1, 1])),
    ],
)
def test_unusable_bounds_are_errors(angles, translation):
    with pytest.raises(InvalidInputError):
        FrameBounds(np.eye(2), angles, translation)


def test_the_margins_are_ten_degrees_and_a_quarter_of_the_range():
    turns = [0.1, 0.5, 0.3]
    path = np.cumsum(np.ones((4, 3)), axis=0)
    demonstrations = [
        SyntheticDemonstration(path, 0.1, (Frame(rotation([0, 0, turn]), [turn, 1.0, -10 * turn]),))
        for turn in turns
    ]
    (bounds,) = BoundsSampler.around(demonstrations).bounds
    ten = np.deg2rad(10.0)
    np.testing.assert_allclose(bounds.angles, [[0, 0, -ten], [0, 0, 0.4 + ten]], atol=1e-9)
    np.testing.assert_allclose(bounds.translation, [[0.0, 1.0, -6.0], [0.6, 1.0, 0.0]], atol=1e-9)
    (bare,) = BoundsSampler.around(demonstrations, 0.0, 0.0).bounds
    np.testing.assert_allclose(bare.angles[1], [0, 0, 0.4], atol=1e-9)
    np.testing.assert_allclose(bare.translation, [[0.1, 1, -5], [0.5, 1, -1]], atol=1e-9)


@pytest.mark.parametrize("scale", [1.0, 0.2])
@pytest.mark.parametrize("mirror", [1.0, -1.0])
def test_scale_and_reflection_stay_in_the_basis(scale, mirror):
    base = scale * np.diag([1.0, mirror, 1.0])
    path = np.cumsum(np.ones((4, 3)), axis=0)
    turn = np.array([0.3, -0.2, 0.4])
    demonstrations = [
        SyntheticDemonstration(path, 0.1, (Frame(rotation(share * turn) @ base, np.zeros(3)),))
        for share in (0.0, 1.0)
    ]
    (bounds,) = BoundsSampler.around(demonstrations, 0.0).bounds
    np.testing.assert_allclose(bounds.base, base)
    np.testing.assert_allclose(bounds.angles[1] + bounds.angles[0], turn, atol=1e-9)


def test_a_plane_has_one_angle_and_a_line_has_none():
    frame = Frame(rotation(0.3), [1.0, 2.0])
    np.testing.assert_allclose(FrameBounds.fixed(frame).sample(np.random.default_rng(0)).A, frame.A)
    with pytest.raises(InvalidInputError, match="one angle in two dimensions"):
        FrameBounds.fixed(Frame(np.eye(1), [0.0]))
    for wrong in (rotation, euler_angles):
        with pytest.raises(InvalidInputError, match="a rotation"):
            wrong(np.zeros(2))
    with pytest.raises(InvalidInputError, match="a rotation"):
        euler_angles(np.eye(4))


def turned(angles, base=None):
    """Demonstrations in one frame that is turned by each of some angles."""
    path = np.cumsum(np.ones((4, 3 if np.ndim(angles[0]) else 2)), axis=0)
    origin = np.zeros(path.shape[1])
    base = np.eye(len(origin)) if base is None else base
    return [SyntheticDemonstration(path, 0.1, (Frame(rotation(a) @ base, origin),)) for a in angles]


@given(st.lists(st.floats(0.0, 3.5), min_size=2, max_size=6), st.floats(-10.0, 10.0))
def test_in_the_plane_bounds_are_the_shortest_arc_that_holds_the_frames(places, first):
    """However the first frame lies among the others, before or behind them or between."""
    places = np.array(places)
    (bounds,) = BoundsSampler.around(turned(first + places), 0.0).bounds
    low, high = bounds.angles
    # Gaps of the circle between neighbours: all but the widest are within the bounds.
    gaps = np.diff(np.sort(places), append=places.min() + 2 * np.pi)
    assert high[0] - low[0] == pytest.approx(2 * np.pi - gaps.max(), abs=1e-6)
    inside = (places - places[0] - low[0] + 1e-6) % (2 * np.pi)
    assert (inside <= high[0] - low[0] + 2e-6).all()


def test_frames_on_both_sides_of_the_first_one_s_back_are_held_by_a_short_arc():
    """0, 170 and 190 degrees: 190 wide, not all the way round."""
    demonstrations = turned(np.deg2rad([0.0, 170.0, -170.0]))
    (bounds,) = BoundsSampler.around(demonstrations).bounds
    np.testing.assert_allclose(np.rad2deg(bounds.angles), [[-10.0], [200.0]], atol=1e-6)
    (wide,) = BoundsSampler.around(demonstrations, np.pi).bounds
    assert wide.angles[1] - wide.angles[0] == pytest.approx(2 * np.pi)


@pytest.mark.parametrize("tilts", [(0.0, 1.4, 1.8), (0.0, -1.4, -1.8), (0.0, 1.7, 2.5, 1.0)])
def test_a_frame_that_tilts_past_the_vertical_tilts_and_does_no_more(tilts):
    """Its Euler angles leap by half a turn there; the rotation does not."""
    (bounds,) = BoundsSampler.around(turned([(0.0, tilt, 0.0) for tilt in tilts]), 0.0).bounds
    expected = [[0.0, min(tilts), 0.0], [0.0, max(tilts), 0.0]]
    np.testing.assert_allclose(bounds.angles, expected, atol=1e-9)


@given(seed=st.integers(0, 10_000), count=st.integers(2, 6))
def test_arcs_are_the_same_rotations_and_never_wider_than_their_plain_angles(seed, count):
    turns = Rotation.random(count, rng=np.random.default_rng(seed)).as_matrix()
    plain = np.array([euler_angles(turn) for turn in turns])
    angles = arcs(plain)
    for turn, one in zip(turns, angles, strict=True):
        np.testing.assert_allclose(rotation(one), turn, atol=1e-9)
    assert np.ptp(angles, axis=0).sum() <= np.ptp(plain, axis=0).sum() + 1e-9
