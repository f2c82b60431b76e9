import numpy as np
import pytest
from blended_frames import BlendedFrames

from dressing_sim.learning import Situation, SyntheticDemonstration
from dressing_sim.policies.registry import make_policy
from dressing_sim.suites.suites import load_suite

ARM = load_suite("paper5")[1]


@pytest.fixture
def demonstration():
    """A line from before the wrist to above the shoulder."""
    path = np.linspace(ARM.wrist + [0.0, 0.1, 0.1], ARM.shoulder + [0.0, 0.0, 0.1], 50)
    return SyntheticDemonstration(path, 0.1, ARM.frames())


def test_dressing_sim_knows_it_by_name():
    assert isinstance(make_policy("blended-frames?samples=30"), BlendedFrames)


def test_on_the_arm_of_its_demonstration_it_does_the_same(demonstration):
    policy = BlendedFrames(samples=50).fit([demonstration])
    path = policy.generate(ARM.frames(), demonstration.positions[0])
    np.testing.assert_allclose(path, demonstration.positions, atol=1e-9)
    assert policy.dt == pytest.approx(0.1)


def test_the_path_moves_with_the_arm(demonstration):
    policy = BlendedFrames().fit([demonstration])
    by, start = np.array([0.02, -0.03, 0.01]), demonstration.positions[0]
    moved = Situation.of([type(f)(f.A, f.b + by) for f in ARM.frames()], ARM.frames().names)
    still = policy.generate(ARM.frames(), start)
    np.testing.assert_allclose(policy.generate(moved, start + by), still + by, atol=1e-9)


def test_it_begins_where_the_gripper_is(demonstration):
    policy, start = BlendedFrames().fit([demonstration]), np.array([0.3, 0.2, 0.3])
    np.testing.assert_allclose(policy.generate(ARM.frames(), start)[0], start)
