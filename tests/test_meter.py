import numpy as np
import pytest

from dressing_sim.meter import Meter
from dressing_sim.world.dressed import ArmAxis
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.strain import StrainGauge


def test_a_row_is_what_the_instruments_read(world):
    meter = Meter(world, strain_percentile=90.0)
    meter.read(np.add(world.tcp_position, [0.0, 3e-3, 4e-3]), np.array([0.0, 3.0, 4.0]))
    world.step()
    meter.read(world.tcp_position, np.zeros(3))
    trace = meter.trace(0.02)
    assert len(trace) == 2
    assert (trace.dt, trace.links) == (0.02, LINKS)
    assert trace.tracking_error[0] == pytest.approx(5e-3)
    assert trace.grip_force.tolist() == [5.0, 0.0]
    # The second row is of now.
    np.testing.assert_array_equal(trace.tcp[1], world.tcp_position)
    np.testing.assert_array_equal(trace.torque[1], world.arm_torque)
    gauge = StrainGauge(world.mesh)
    strain = gauge.principal(world.cloth)
    assert trace.strain[1] == gauge.percentile(strain, 90.0)
    assert trace.strain_max[1] == strain.max()
    armscye = world.cloth[: world.config.sleeve.vertices_around].mean(axis=0)
    assert trace.armscye_s[1] == ArmAxis.of(world.posture).coordinate(armscye[None])[0]
    forces = [np.linalg.norm(world.link_force(link)) for link in LINKS]
    np.testing.assert_allclose(trace.link_force[1], forces)
    assert not trace.hit.any()


def test_a_sleeve_that_is_on_winds_round_the_arm_and_one_that_is_off_does_not(world):
    meter = Meter(world, strain_percentile=95.0)
    for shift in ([0.01, 0.005, -0.02], [0.0, 0.0, 1.0]):
        world.data.flexvert_xpos[:] = world.mesh.vertices + np.array(shift)
        meter.read(world.tcp_position, np.zeros(3))
    assert meter.trace(0.02).wound.tolist() == [True, False]
