"""A person who moves: closed forms of the chain of joints, without cloth or robot."""

import mujoco
import numpy as np
import pytest

from dressing_sim.arm import ARM_SIZES, Posture
from dressing_sim.motion import COORDINATES, JOINTS, UNITS, Compliance, Drift, Motion, Sway
from dressing_sim.world.mannequin import LINKS, add_mannequin
from dressing_sim.world.person import Person, joint_name

#: Joints that are practically locked, and an elbow that gives way.
ELBOW_ALONE = (1e4, 1e4, 1e4, 8.67)
STILL = (1e4, 1e4, 1e4, 0.0)


def model_of(posture, timestep=0.01):
    spec = mujoco.MjSpec()
    spec.compiler.degree = False  # as in the scene, by the robot's URDF
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_DISCRETE
    spec.option.timestep = timestep
    add_mannequin(spec, posture, 0.3, contype=1, conaffinity=6)
    return spec.compile()


class Alone:
    """A mannequin by itself."""

    def __init__(self, posture, timestep=0.01):
        self.model = model_of(posture, timestep)
        self.data, self.person = mujoco.MjData(self.model), Person(self.model, posture)
        self.model.stat.meaninertia = 0.01  # of a whole scene: the solver's tolerance goes by it
        self.dofs = [self.model.joint(joint_name(name)).dofadr[0] for name in COORDINATES]
        self.hand = self.model.body("hand").id

    def step(self, time=None):
        self.person.lead(self.data, time)
        mujoco.mj_step(self.model, self.data)

    @property
    def coordinates(self):
        return self.data.qpos[self.person.positions]

    @property
    def speeds(self):
        return self.data.qvel[self.dofs]

    @property
    def inertia(self):
        full = np.zeros((self.model.nv, self.model.nv))
        mujoco.mj_fullM(self.model, self.data, full)
        return full[np.ix_(self.dofs, self.dofs)]

    def jacobian(self):
        """Of the wrist, (3, 7)."""
        columns = np.zeros((3, self.model.nv))
        mujoco.mj_jac(self.model, self.data, columns, None, self.data.xpos[self.hand], self.hand)
        return columns[:, self.dofs]


def arm(motion, angles=(70, 20, 30, 40), **more):
    return Posture("one", *angles, motion=motion, **more)


@pytest.mark.parametrize("size", list(ARM_SIZES)[:2])
@pytest.mark.parametrize("angles", [(0, 0, 0, 0), (66, 30, 48, 65), (-20, 100, -40, 150)])
def test_at_rest_it_is_the_still_mannequin(size, angles):
    still, moving = (model_of(arm(m, angles, size=size)) for m in (None, Motion()))
    places = []
    for model in (still, moving):
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        names = [model.geom(g).name for g in range(model.ngeom)]
        order = np.argsort(names)
        axes = data.geom_xmat.reshape(-1, 3, 3)[order][:, :, 2]
        places.append((sorted(names), data.geom_xpos[order], axes, model.geom_size[order]))
        assert all(model.body(link).id > 0 for link in LINKS)
    assert places[0][0] == places[1][0]
    for one, other in zip(places[0][1:], places[1][1:], strict=True):
        np.testing.assert_allclose(one, other, atol=1e-12)


@pytest.mark.parametrize("angles", [(66, 30, 48, 65), (10, 80, -30, 20)])
def test_a_sway_is_where_the_formula_says_and_the_skin_as_fast(angles):
    motion = Motion(
        tuple(Sway(name, 0.01 if name[-3:] != "deg" else 4.0, 0.3, 40.0) for name in COORDINATES),
        (Drift("flexion_deg", -8.0, 0.5, 2.0),),
    )
    posture = arm(motion, angles)
    alone, before, speeds = Alone(posture), None, np.zeros((3, 3))
    for number in range(120):
        time = 0.01 * number
        alone.step(time)
        there = posture.at(posture.coordinates + motion.offsets(time) / UNITS)
        wanted = np.stack([there.wrist, there.elbow, there.shoulder])
        np.testing.assert_allclose(alone.person.joints(alone.data), wanted, atol=1e-12)
        if before is not None:
            np.testing.assert_allclose((wanted - before) / 0.01, speeds, atol=2e-3)
        before = wanted
        for row, name in zip(speeds, ("hand", "forearm", "upper_arm"), strict=True):
            body = alone.model.body(name).id
            columns = np.zeros((3, alone.model.nv))
            mujoco.mj_jac(alone.model, alone.data, columns, None, alone.data.xpos[body], body)
            row[:] = columns @ alone.data.qvel


def test_what_is_led_no_force_moves():
    posture = arm(Motion((Sway("elbow_deg", 4.0, 0.5),)))
    free, pulled = Alone(posture), Alone(posture)
    pulled.data.xfrc_applied[pulled.hand, :3] = [5.0, -5.0, 5.0]
    for number in range(100):
        for one in (free, pulled):
            one.step(0.01 * number)
    free_at, pulled_at = (one.person.joints(one.data) for one in (free, pulled))
    np.testing.assert_allclose(pulled_at, free_at, atol=1e-12)
    assert np.abs(pulled.speeds - free.speeds).max() < 1e-3


@pytest.mark.parametrize("angles", [(0, 0, 0, 0), (66, 30, 48, 65), (-20, 80, -40, 140)])
def test_the_arm_s_own_weight_is_carried_in_every_posture(angles):
    alone = Alone(arm(Motion(compliance=Compliance()), angles))
    begin = alone.coordinates.copy()
    for _ in range(300):
        alone.step()
    np.testing.assert_allclose(alone.coordinates, begin, atol=1e-9)


@pytest.mark.parametrize("force", [[0.0, 0.0, -2.0], [1.0, 2.0, 0.5]])
def test_under_a_known_weight_it_rests_where_torques_balance(force):
    compliance = Compliance(damping=(4.0,) * 4)  # sooner at rest, and in the same place
    alone = Alone(arm(Motion(compliance=compliance)))
    rest = alone.coordinates.copy()
    alone.data.xfrc_applied[alone.hand, :3] = force
    for _ in range(1500):
        alone.step()
        # The force acts at the hand's centre of mass; its torque about the wrist is taken off.
        arm_of = alone.data.xpos[alone.hand] - alone.data.xipos[alone.hand]
        alone.data.xfrc_applied[alone.hand, 3:] = np.cross(arm_of, force)
    pushed = (alone.jacobian().T @ force)[3:]
    moved = (alone.coordinates - rest)[3:]
    np.testing.assert_allclose(np.array(compliance.stiffness) * moved, pushed, rtol=1e-5, atol=1e-7)
    assert np.abs(moved).max() > 0.03


def test_a_weight_on_the_wrist_bends_the_elbow_as_one_equation_says():
    """A level forearm and a weight straight down: k angle = weight length cos(angle)."""
    posture = arm(Motion(compliance=Compliance(ELBOW_ALONE)), (0, 0, 0, 90))
    alone, weight = Alone(posture), 3.0
    alone.data.xfrc_applied[alone.hand, 2] = -weight
    for _ in range(1500):
        alone.step()
        arm_of = alone.data.xpos[alone.hand] - alone.data.xipos[alone.hand]
        alone.data.xfrc_applied[alone.hand, 3:] = np.cross(arm_of, [0.0, 0.0, -weight])
    sunk = np.deg2rad(90.0) - alone.coordinates[-1]
    torque = weight * posture.arm_size.forearm_length * np.cos(sunk)
    assert 8.67 * sunk == pytest.approx(torque, rel=2e-3)


def swinging(damping, timestep, seconds=1.0):
    """Angle of an elbow that is let go 0.1 rad from rest [rad], and its inertia."""
    motion = Motion(compliance=Compliance(ELBOW_ALONE, damping))
    alone = Alone(arm(motion, (0, 0, 0, 90)), timestep)
    alone.data.qpos[alone.person.positions[-1]] += 0.1
    mujoco.mj_forward(alone.model, alone.data)
    angles, energies, lost = [], [], [0.0]
    for _ in range(round(seconds / timestep)):
        alone.step()
        away = (alone.coordinates - alone.person.wanted(0.0))[3:]
        speeds = alone.speeds
        mujoco.mj_forward(alone.model, alone.data)
        held = 0.5 * np.array(ELBOW_ALONE) @ away**2
        energies.append(held + 0.5 * speeds @ alone.inertia @ speeds)
        lost.append(lost[-1] + timestep * np.array(damping) @ speeds[3:] ** 2)
        angles.append(away[-1])
    return np.array(angles), alone.inertia[-1, -1], np.array(energies), np.array(lost[1:])


def test_a_swing_dies_away_as_the_formula_of_a_damped_oscillator_says():
    timestep, damping = 5e-4, 0.2
    angles, inertia, *_ = swinging((*STILL[:3], damping), timestep)
    decay = damping / (2.0 * inertia)
    natural = np.sqrt(8.67 / inertia)
    ringing = np.sqrt(natural**2 - decay**2)
    time = timestep * np.arange(1, len(angles) + 1)
    wanted = (
        0.1
        * np.exp(-decay * time)
        * (np.cos(ringing * time) + decay / ringing * np.sin(ringing * time))
    )
    np.testing.assert_allclose(angles, wanted, atol=5e-3)


def test_energy_never_grows_and_what_damping_takes_is_what_is_lost():
    _, _, energies, lost = swinging((0.0, 0.0, 0.0, 0.2), 5e-4, 0.3)
    begin = 0.5 * 8.67 * 0.1**2
    assert (np.diff(energies) <= 1e-9).all()
    assert begin - energies[-1] == pytest.approx(lost[-1], rel=0.1)
    # Without damping the implicit step loses a little, in proportion to the step.
    leaks = []
    for timestep in (2e-3, 5e-4):
        energies = swinging((0.0,) * 4, timestep, 0.3)[2]
        assert (np.diff(energies) <= 1e-9).all()
        leaks.append(begin - energies[-1])
    assert leaks[1] < 0.4 * leaks[0]


def test_shifting_the_person_shifts_its_answer_to_a_force():
    answers = []
    for shift in ([0.0, 0.0, 0.0], [0.05, -0.04, 0.03]):
        place = tuple(np.add([0.52, -0.26, 0.24], shift).tolist())
        alone = Alone(arm(Motion(compliance=Compliance()), shoulder_position=place))
        alone.data.xfrc_applied[alone.hand, :3] = [1.0, 0.0, -1.0]
        for _ in range(50):
            alone.step()
        answers.append(alone.person.joints(alone.data) - shift)
    np.testing.assert_allclose(answers[0], answers[1], atol=1e-12)


def test_no_joint_bends_beyond_what_an_arm_can():
    alone = Alone(arm(Motion(compliance=Compliance()), (60, 20, 30, 2)))
    alone.data.xfrc_applied[alone.hand, :3] = [0.0, 0.0, -60.0]
    for _ in range(300):
        alone.step()
    assert alone.coordinates[-1] > np.deg2rad(-6.0)  # the limit is a stiff spring


def test_masses_and_inertia_are_those_of_an_adult():
    """Masses: de Leva, J. Biomechanics 29 (1996), of a man of 73 kg. Inertia about each joint:
    Davidson and Charles (2017), an upper arm that hangs and an elbow at a right angle."""
    alone = Alone(arm(Motion(compliance=Compliance()), (0, 0, 0, 90)))
    mujoco.mj_forward(alone.model, alone.data)
    masses = [float(alone.model.body(name).mass[0]) for name in ("upper_arm", "forearm", "hand")]
    np.testing.assert_allclose(masses, [1.98, 1.18, 0.445], rtol=0.15)
    inertia = np.diag(alone.inertia)[-len(JOINTS) :]
    np.testing.assert_allclose(inertia, [0.269, 0.196, 0.079, 0.076], rtol=0.05)
