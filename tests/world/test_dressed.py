import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from dressing_sim.arm import ANGLE_LIMITS_DEG, Posture
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.scene import resting_sleeve
from dressing_sim.world.sleeve import SleeveConfig

LOOSE = np.array([0.0, 0.02, -0.03])
"""A sleeve hangs below the arm's axis, it is never quite round it."""

angles = {name: st.floats(*limits) for name, limits in ANGLE_LIMITS_DEG.items()}
# Bent further, the upper arm comes back through a ring that is round the forearm.
angles["elbow_deg"] = st.floats(0.0, 90.0)
postures = st.builds(Posture, name=st.just("any"), **angles)
along = st.floats(0.02, 1.98)
seeds = st.integers(0, 2**32 - 1)


def place(axis, s):
    """Point on the axis at an arm coordinate, and the direction towards the shoulder there."""
    segment = 0 if s < 1.0 else 1
    start, end = axis.joints[segment], axis.joints[segment + 1]
    return start + (s - segment) * (end - start), (end - start) / np.linalg.norm(end - start)


def ring(centre, direction, radius=0.07, n_around=18, turn=0.0):
    """A ring in the sleeve's own direction: right-handed about what points to the hand."""
    away = -direction
    up = np.cross(away, np.roll(away, 1) + np.array([0.1, 0.2, 0.3]))
    up /= np.linalg.norm(up)
    angle = turn + np.arange(n_around) * 2.0 * np.pi / n_around
    circle = np.outer(np.cos(angle), up) + np.outer(np.sin(angle), np.cross(away, up))
    return (centre + radius * circle)[None]


def off_axis(direction):
    """A small shift across a direction."""
    return LOOSE - (LOOSE @ direction) * direction


@given(postures)
def test_the_coordinate_is_0_1_2_at_wrist_elbow_and_shoulder(posture):
    axis = ArmAxis.of(posture)
    joints = np.stack([posture.wrist, posture.elbow, posture.shoulder])
    np.testing.assert_array_equal(axis.joints, joints)
    np.testing.assert_allclose(axis.coordinate(joints), [0.0, 1.0, 2.0], atol=1e-9)


@given(postures, along)
def test_the_coordinate_grows_evenly_along_the_arm(posture, s):
    axis = ArmAxis.of(posture)
    assert axis.coordinate(place(axis, s)[0][None])[0] == pytest.approx(s, abs=1e-9)


@given(postures)
def test_the_hand_is_below_0_and_the_trunk_beyond_2(posture):
    axis = ArmAxis.of(posture)
    fingers = posture.wrist + 0.5 * (posture.wrist - posture.elbow)
    trunk = posture.shoulder + 0.25 * (posture.shoulder - posture.elbow)
    np.testing.assert_allclose(axis.coordinate(np.stack([fingers, trunk])), [-0.5, 2.25])


def test_beside_the_arm_the_nearest_point_counts():
    axis = ArmAxis(np.array([[0.0, 0, 0], [1.0, 0, 0], [1.0, 2.0, 0]]))
    points = np.array([[0.25, -0.3, 0.1], [1.4, 0.5, 0.0], [1.2, -0.2, 0.0]])
    np.testing.assert_allclose(axis.coordinate(points), [0.25, 1.25, 1.0])


@given(postures, along, st.floats(0, 2 * np.pi))
def test_a_ring_round_the_arm_winds_once_and_backwards_if_reversed(posture, s, turn):
    axis = ArmAxis.of(posture)
    centre, direction = place(axis, s)
    around = ring(centre + off_axis(direction), direction, turn=turn)
    assert axis.winding(around).tolist() == [1]
    assert axis.winding(around[:, ::-1]).tolist() == [-1]


@given(postures, along, st.floats(0, 2 * np.pi))
def test_a_ring_that_is_centred_on_the_arm_winds_once_too(posture, s, turn):
    axis = ArmAxis.of(posture)
    assert axis.winding(ring(*place(axis, s), turn=turn)).tolist() == [1]


@given(postures)
def test_every_ring_of_the_sleeve_before_it_falls_is_on_the_arm(posture):
    config = SleeveConfig()
    mesh = resting_sleeve(posture, config)
    rings = mesh.rings(mesh.vertices)
    assert ArmAxis.of(posture).winding(rings).tolist() == [1] * config.vertices_along


@given(postures, st.floats(0.05, 0.95), st.sampled_from([0, 1]), st.floats(0.15, 0.3), seeds)
def test_a_ring_beside_the_arm_does_not_wind(posture, fraction, segment, distance, seed):
    axis = ArmAxis.of(posture)
    rng = np.random.default_rng(seed)
    # Away from both segments: across the plane of the arm.
    forearm, upper = np.diff(axis.joints, axis=0)
    across = np.cross(forearm, upper)
    if np.linalg.norm(across) < 1e-6:
        across = np.cross(forearm, rng.standard_normal(3))
    across /= np.linalg.norm(across)
    centre = place(axis, segment + fraction)[0] + distance * across
    direction = rng.standard_normal(3)
    off = ring(centre, direction / np.linalg.norm(direction))
    assert axis.winding(off).tolist() == [0]


def test_a_ring_may_be_tilted_and_folded_and_still_winds_once():
    axis = ArmAxis(np.array([[0.0, 0, 0], [0.25, 0, 0], [0.45, 0.2, 0]]))
    angle = np.arange(18) * 2.0 * np.pi / 18
    x = 0.1 + 0.08 * np.cos(angle) + 0.03 * np.sin(3 * angle)
    folded = np.column_stack([x, 0.05 * np.cos(angle), 0.02 * np.sin(angle) - 0.01])
    assert abs(axis.winding(folded[None])[0]) == 1


@given(postures, st.floats(-0.5, 2.3), seeds)
def test_the_verdict_is_the_same_in_a_world_that_is_turned_and_shifted(posture, s, seed):
    rng = np.random.default_rng(seed)
    turn, shift = Rotation.from_quat(rng.standard_normal(4)), rng.uniform(-1, 1, 3)
    axis = ArmAxis.of(posture)
    there = ArmAxis(turn.apply(axis.joints) + shift)
    centre, direction = place(axis, s)
    rings = np.concatenate(
        [ring(centre + off_axis(direction) + far * np.ones(3), direction) for far in (0.0, 0.3)]
    )
    rings_there = turn.apply(rings.reshape(-1, 3)).reshape(rings.shape) + shift
    np.testing.assert_array_equal(there.winding(rings_there), axis.winding(rings))
    np.testing.assert_allclose(
        there.coordinate(rings_there[:, 0]), axis.coordinate(rings[:, 0]), atol=1e-9
    )


@given(postures, along)
def test_dressed_ratios_are_shares_of_the_arm_s_length(posture, s):
    axis = ArmAxis.of(posture)
    size = posture.arm_size
    upper, whole = axis.dressed_ratios(np.array([s]))[0]
    here = place(axis, s)[0]
    if s >= 1.0:
        way = np.linalg.norm(here - posture.elbow)
        assert upper == pytest.approx(way / size.upper_arm_length, abs=1e-9)
        way += size.forearm_length
    else:
        way = np.linalg.norm(here - posture.wrist)
        assert upper == 0.0
    assert whole == pytest.approx(way / (size.forearm_length + size.upper_arm_length), abs=1e-9)


def test_dressed_ratios_end_at_the_wrist_and_the_shoulder(posture):
    ratios = ArmAxis.of(posture).dressed_ratios(np.array([-0.5, 0.0, 2.0, 2.3, np.nan]))
    np.testing.assert_array_equal(ratios, [[0, 0], [0, 0], [1, 1], [1, 1], [0, 0]])


@given(postures, st.floats(-0.3, 2.1), st.floats(0.0, 2.0 * np.pi))
def test_an_upright_ring_is_seen_by_the_line_triangle_test_where_it_is(posture, s, turn):
    axis = ArmAxis.of(posture)
    segment = 0 if s < 1.0 else 1
    direction = axis.joints[segment + 1] - axis.joints[segment]
    centre = axis.joints[segment] + (s - segment) * direction
    direction /= np.linalg.norm(direction)
    # A ring is wider than the arm; small ones only, so that the other segment stays out of them.
    around = ring(centre + 0.3 * off_axis(direction), direction, radius=0.03, turn=turn)
    assert axis.through_triangles(around)[0] == pytest.approx(s, abs=1e-9)
    far = around + 0.5 * np.cross(direction, [0.3, 0.5, 0.7])
    assert np.isnan(axis.through_triangles(far)[0])


@pytest.mark.parametrize("change", ["sagging", "turned", "folded"])
def test_the_line_triangle_test_jumps_where_whole_rings_hardly_move(change):
    """An opening round the upper arm changes in twenty small steps; it always is on the arm."""
    axis = ArmAxis(np.array([[0.0, 0, 0], [0.25, 0, 0], [0.5, 0, 0]]), (0.09, 0.04))
    angle, radius = np.arange(18) * 2.0 * np.pi / 18, 0.075
    by_rings, by_triangles = [], []
    for step in np.linspace(0.0, 1.0, 20):
        turn = 0.25 * np.pi * step if change == "turned" else 0.0
        y, z = -radius * np.sin(angle + turn), radius * np.cos(angle + turn) - 0.03
        x = np.full(18, 0.4)
        if change == "sagging":  # the arm comes to lie between two of the four vertices
            y, z = y + 0.045 * step, z - 0.015 * step
        elif change == "turned":
            y, z = y + 0.045, z - 0.015
        else:  # the opening's topmost vertex is tucked in, beside the arm
            tucked = np.arange(18) == 0
            y, z = y + 0.03 * step * tucked, z - 0.07 * step * tucked
        opening = np.column_stack([x, y, z])
        wound = abs(axis.winding(opening[None])) == 1
        s = np.where(wound, axis.coordinate(opening.mean(axis=0)[None]), np.nan)
        by_rings.append(axis.dressed_ratios(s)[0, 0])
        by_triangles.append(axis.dressed_ratios(axis.through_triangles(opening[None]))[0, 0])
    assert np.ptp(by_rings) < 0.01
    assert np.abs(np.diff(by_triangles)).max() > 0.5
