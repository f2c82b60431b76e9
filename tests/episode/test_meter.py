from types import SimpleNamespace

import numpy as np
import pytest

from dressing_sim.episode.meter import Meter
from dressing_sim.world.contacts import ClothForces, Touch
from dressing_sim.world.description import joint_limits
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.strain import StrainGauge

LOAD = np.zeros((len(LINKS), 3)), np.zeros(len(LINKS))
UNTOUCHED, TOUCHED = ClothForces(*LOAD, others=0), ClothForces(*LOAD, depth=0.002, others=2)


def test_a_row_is_what_the_instruments_read(world):
    meter = Meter(world, dt=0.02, strain_percentile=90.0)
    meter.read(np.add(world.tcp_position, [0.0, 3e-3, 4e-3]))
    world.step()
    meter.observe_physics()
    now = meter.read(world.tcp_position)
    trace = meter.trace()
    assert len(trace) == 2
    assert (trace.dt, trace.links, trace.robot_links) == (0.02, LINKS, world.robot_links)
    assert trace.tracking_error[0] == pytest.approx(5e-3)
    # The second row is of now.
    np.testing.assert_array_equal(trace.tcp[1], world.tcp_position)
    np.testing.assert_array_equal(trace.torque[1], world.arm_torque)
    np.testing.assert_array_equal(trace.joint_position[1], world.arm_configuration)
    np.testing.assert_array_equal(trace.joint_velocity[1], world.arm_velocity)
    np.testing.assert_array_equal(trace.clearance, world.clearance(trace.tcp))
    gauge = StrainGauge(world.mesh)
    strain = gauge.principal(world.cloth)
    assert trace.strain[1] == gauge.percentile(strain, 90.0)
    assert trace.strain_median[1] == gauge.percentile(strain, 50.0)
    assert trace.strain_max[1] == strain.max()
    assert trace.edge_strain[1] == gauge.edge_percentile(world.cloth, 90.0)
    assert trace.grip_force[1] == np.linalg.norm(world.grip_load)
    np.testing.assert_array_equal(trace.link_force[1], world.cloth_load.net)
    np.testing.assert_array_equal(trace.link_normal_force[1], world.cloth_load.normal)
    assert trace.holding.all()
    assert np.all(trace.hit_by == -1)
    axis, rings = ArmAxis.of(world.posture), world.mesh.rings(world.cloth)
    centres = rings.mean(axis=1)
    assert trace.armscye_s[1] == axis.coordinate(centres[:1])[0]
    assert trace.hem_s[1] == axis.coordinate(centres[-1:])[0]
    # What the protective stop looks at is the trace's last row.
    (*_, last) = trace.limited()
    assert now.limited() == last


def test_a_sleeve_that_is_on_winds_round_the_arm_and_one_that_is_off_does_not(world):
    meter = Meter(world, dt=0.02, strain_percentile=95.0)
    forearm = world.posture.elbow - world.posture.wrist
    for shift in ([0.01, 0.005, -0.02], 0.5 * forearm, [0.0, 0.0, 1.0]):
        world.data.flexvert_xpos[:] = world.mesh.vertices + np.array(shift)
        meter.read(world.tcp_position)
    trace = meter.trace()
    assert trace.wound.tolist() == [True, True, False]
    assert trace.line_triangle_on.tolist() == [True, True, False]
    lengths = ArmAxis.of(world.posture).lengths
    half = 0.5 * lengths[0] / lengths.sum()
    np.testing.assert_array_equal(trace.dressed_ratio[:, 0], 0.0)
    np.testing.assert_allclose(trace.dressed_ratio[1:, 1], [half, 0.0])
    np.testing.assert_allclose(trace.line_triangle_ratio[1:, 1], [half, 0.0], atol=1e-9)


def test_rows_do_not_depend_on_how_many_there_are(world):
    """Rings are followed in chunks of rows."""
    meter, rows = Meter(world, dt=0.02, strain_percentile=95.0), []
    for _ in range(130):
        world.data.flexvert_xpos[:] += [0.0, 0.0, 1e-3]
        single = Meter(world, dt=0.02, strain_percentile=95.0)
        for instrument in (meter, single):
            instrument.read(world.tcp_position)
        rows.append(single.trace())
    trace = meter.trace()
    for column in ("armscye_s", "hem_s", "wound", "dressed_ratio", "line_triangle_ratio"):
        expected = np.concatenate([getattr(row, column) for row in rows])
        np.testing.assert_allclose(getattr(trace, column), expected, atol=1e-12)


def test_the_nearest_to_a_limit_since_the_last_row_counts(world, monkeypatch):
    limits, meter = joint_limits(), Meter(world, dt=0.02, strain_percentile=95.0)
    middle = 0.5 * (limits.lower + limits.upper)
    third = np.eye(7)[3]
    for q, v, t in (
        (limits.upper, 0.5 * limits.velocity * third, -0.2 * limits.effort),
        (limits.lower + 0.25 * (limits.upper - limits.lower), -0.7 * limits.velocity, 0.0 * third),
        (middle, 0.1 * limits.velocity, 0.6 * limits.effort * third),
    ):
        fake = SimpleNamespace(
            arm_configuration=q, arm_velocity=v, arm_torque=t, cloth_load=UNTOUCHED
        )
        with monkeypatch.context() as patch:
            patch.setattr(meter, "_world", fake)
            meter.observe_physics()
        if np.all(v < 0.0):
            meter.read(world.tcp_position)
    meter.read(world.tcp_position)
    ratios = meter.trace().limit_ratio
    np.testing.assert_allclose(ratios, [[1.0, 0.7, 0.2], [0.0, 0.1, 0.6]], atol=1e-12)


def test_the_hardest_touch_since_the_last_row_counts(world, monkeypatch):
    meter = Meter(world, dt=0.02, strain_percentile=95.0)
    told = iter([[], [Touch(3, 1, 5.0), Touch(4, 1, 7.0), Touch(3, 2, 0.0)], [Touch(2, 1, 1.0)]])
    rest = dict.fromkeys(("arm_configuration", "arm_velocity", "arm_torque"), np.zeros(7))
    fake = SimpleNamespace(touches=lambda: next(told), cloth_load=TOUCHED, **rest)
    for _ in range(3):
        with monkeypatch.context() as patch:
            patch.setattr(meter, "_world", fake)
            meter.observe_physics()
    assert meter.read(world.tcp_position).hit
    assert not meter.read(world.tcp_position).hit
    trace = meter.trace()
    assert trace.hit_by.tolist() == [[-1, 4, 3, -1, -1], [-1] * 5]
    assert trace.hit_force.tolist() == [[0.0, 7.0, 0.0, 0.0, 0.0], [0.0] * 5]
