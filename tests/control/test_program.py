"""The program of a move is pink's, to the bit, and so is what follows from it."""

import numpy as np
import pink
import pinocchio as pin
import pytest
from pink.limits.limit import Limit
from pink.tasks import FrameTask, PostureTask

from dressing_sim.control import HAND_DOWN, RobotKinematics, Tracker, TrackingConfig
from dressing_sim.control.limits import JointLimits
from dressing_sim.control.program import MoveProgram
from dressing_sim.world.robot import PANDA

MODEL = RobotKinematics().model
CONFIG = TrackingConfig()


class Bounds(Limit):
    """Given bounds of a move, as pink wants them."""

    def __init__(self, bounds):
        self.bounds = bounds

    def compute_qp_inequalities(self, configuration, dt):
        return np.vstack([np.eye(MODEL.nv), -np.eye(MODEL.nv)]), self.bounds


def pinks_move(q, target, tilts, bounds):
    hand = FrameTask(PANDA.tool, position_cost=CONFIG.position_cost, orientation_cost=tilts)
    hand.set_target(target)
    posture = PostureTask(cost=CONFIG.posture_cost)
    posture.set_target(np.array(PANDA.home))
    return pink.solve_ik(
        pink.Configuration(MODEL, MODEL.createData(), q),
        [hand, posture],
        CONFIG.dt,
        solver="daqp",
        damping=1e-9,
        limits=[Bounds(bounds)],
        safety_break=False,
    )


@pytest.mark.parametrize("turn", [0.0, CONFIG.tilt_cost])
@pytest.mark.parametrize("seed", range(8))
def test_a_move_is_pinks_to_the_bit(seed, turn):
    rng = np.random.default_rng(seed)
    program = MoveProgram(MODEL, PANDA, CONFIG.posture_cost)
    limits = JointLimits(MODEL, np.array(PANDA.acceleration))
    q = np.array(PANDA.home) + rng.uniform(-0.3, 0.3, 7)
    weight = np.diag([*[CONFIG.position_cost] * 3, *[CONFIG.tilt_cost] * 2, turn])
    target = pin.SE3(HAND_DOWN, rng.uniform([0.3, -0.4, 0.2], [0.6, 0.4, 0.7]))
    for _ in range(5):
        bounds = limits.bounds(q, CONFIG.dt)
        program.place(q)
        move = program.move(target, weight, bounds)
        velocity = pinks_move(q, target, [CONFIG.tilt_cost, CONFIG.tilt_cost, turn], bounds)
        np.testing.assert_array_equal(move / CONFIG.dt, velocity)
        after = limits.moved(q, move, CONFIG.dt)
        free = (after > limits.lower) & (after < limits.upper)
        np.testing.assert_array_equal(
            after[free], pin.integrate(MODEL, q, velocity * CONFIG.dt)[free]
        )
        q = after


def test_bounds_are_those_of_the_formula():
    rng = np.random.default_rng(3)
    limits, dt = JointLimits(MODEL, np.array(PANDA.acceleration)), CONFIG.dt
    a, speed = np.array(PANDA.acceleration), 0.5 * MODEL.velocityLimit
    for _ in range(50):
        q = rng.uniform(limits.lower - 0.05, limits.upper + 0.05)
        limits.velocity = rng.uniform(-speed, speed)
        sides = []
        for room, now in (
            (limits.upper - q, limits.velocity),
            (q - limits.lower, -limits.velocity),
        ):
            stopping = np.sqrt((a * dt) ** 2 + 2.0 * a * np.maximum(room, 0.0)) - a * dt
            stopping = np.where(room < 0.0, np.maximum(room / dt, -speed), stopping)
            fastest = np.minimum(np.minimum(speed, stopping), now + a * dt)
            sides.append(dt * np.maximum(fastest, now - a * dt))
        np.testing.assert_array_equal(limits.bounds(q, dt), np.concatenate(sides))


def test_a_tracker_that_is_set_somewhere_has_its_gripper_there():
    q = np.array(PANDA.home) + 0.1
    tracker = Tracker(RobotKinematics())
    tracker.reset(q)
    np.testing.assert_array_equal(tracker.target, RobotKinematics().tcp_pose(q)[0])
