import mujoco
import numpy as np
import pytest

from dressing_sim.control import RobotKinematics, configuration_at
from dressing_sim.world.contacts import ContactReader
from dressing_sim.world.mannequin import LINKS
from dressing_sim.world.scene import WorldConfig
from dressing_sim.world.simulation import World


def read_one_by_one(model, data):
    """Forces on each link from cloth and robot, net and normal, by MuJoCo's own function."""
    net = {source: np.zeros((len(LINKS), 3)) for source in ("cloth", "robot")}
    normal = {source: np.zeros(len(LINKS)) for source in ("cloth", "robot")}
    for number in range(data.ncon):
        contact, force = data.contact[number], np.zeros(6)
        mujoco.mj_contactForce(model, data, number, force)
        # The frame's axes are its rows; the force is that on the second participant.
        world_force = contact.frame.reshape(3, 3).T @ force[:3]
        source = "cloth" if max(contact.flex) >= 0 else "robot"
        for side, sign in ((0, -1.0), (1, 1.0)):
            geom = contact.geom[side]
            name = model.body(model.geom_bodyid[geom]).name if geom >= 0 else ""
            if name in LINKS:
                net[source][LINKS.index(name)] += sign * world_force
                normal[source][LINKS.index(name)] += force[0]
    return net, normal


@pytest.fixture(scope="module")
def leaning(posture):
    """A robot whose gripper is in the forearm, with the sleeve falling on the arm."""
    kinematics = RobotKinematics()
    q, _ = configuration_at(0.5 * (posture.wrist + posture.elbow), kinematics)
    world = World(posture, WorldConfig(), q)
    for _ in range(30):
        world.step()
    return world


def test_all_contacts_at_once_are_mujocos_contacts_one_by_one(leaning):
    reader = ContactReader(leaning.model)
    seen = 0
    for _ in range(5):
        leaning.step()
        net, normal = read_one_by_one(leaning.model, leaning.data)
        cloth = reader.cloth(leaning.data)
        np.testing.assert_allclose(cloth.net, net["cloth"], atol=1e-12)
        np.testing.assert_allclose(cloth.normal, normal["cloth"], atol=1e-12)
        np.testing.assert_allclose(reader.robot(leaning.data), net["robot"], atol=1e-9)
        touched = np.zeros(len(LINKS))
        for touch in reader.touches(leaning.data):
            touched[touch.link] += touch.force
        np.testing.assert_allclose(touched, normal["robot"], atol=1e-9)
        seen += (normal["cloth"] > 0).sum() * (normal["robot"] > 0).sum()
    assert seen > 0


def test_a_touch_is_of_a_link_of_the_robot_and_pairs_are_told_once(leaning):
    touches = leaning.touches()
    assert touches
    names = [leaning.robot_links[touch.robot_link] for touch in touches]
    assert all(name.startswith("panda_") for name in names)
    assert {LINKS[touch.link] for touch in touches} <= {"hand", "forearm", "upper_arm"}
    assert len({(touch.robot_link, touch.link) for touch in touches}) == len(touches)


def test_links_that_nothing_touches_feel_nothing(leaning):
    cloth = leaning.cloth_forces()
    head = LINKS.index("head")
    np.testing.assert_array_equal(cloth.net[head], 0.0)
    assert cloth.normal[head] == 0.0


def test_without_contacts_all_is_zero(posture):
    world = World(posture, WorldConfig(), np.array([0.0, -0.8, 0.0, -2.4, 0.0, 1.6, 0.8]))
    world.data.qpos[9:] += 5.0  # the cloth is elsewhere
    mujoco.mj_forward(world.model, world.data)
    assert world.data.ncon == 0
    np.testing.assert_array_equal(world.cloth_forces().net, np.zeros((len(LINKS), 3)))
    np.testing.assert_array_equal(world.cloth_forces().normal, np.zeros(len(LINKS)))
    np.testing.assert_array_equal(world.link_force("forearm", "robot"), np.zeros(3))
    assert world.touches() == ()


def test_normal_forces_are_no_less_than_friction_and_weight_allow(world):
    """A net force is at most the normal forces times sqrt(1 + mu^2): the friction cone."""
    for _ in range(5):
        world.step()
        cloth = world.cloth_forces()
        mu = world.config.sleeve.garment.fabric.friction
        bound = np.sqrt(1.0 + mu**2) * cloth.normal
        assert np.all(np.linalg.norm(cloth.net, axis=1) <= bound + 1e-9)
    assert cloth.normal.max() > 0.0
