"""What a world can have besides: contacts of the cloth with itself and the robot, drag of air."""

import mujoco
import numpy as np
import pytest

from dressing_sim.config import from_plain, to_plain
from dressing_sim.control import RobotKinematics, configuration_at
from dressing_sim.suites.robots import load_robot
from dressing_sim.world.garment import Garment
from dressing_sim.world.scene import WorldConfig, build_spec, grip_start
from dressing_sim.world.simulation import World
from dressing_sim.world.sleeve import SleeveConfig

GRAVITY = 9.81


def world_with(posture, **more):
    config = WorldConfig(sleeve=SleeveConfig(**more))
    q, _ = configuration_at(grip_start(posture, config.sleeve), RobotKinematics())
    return World(posture, config, q)


def place(world, vertices):
    """Put the cloth's vertices, (n, 3), where the caller wants them, and find contacts there."""
    slides = (np.asarray(vertices) - world.mesh.vertices).ravel()
    first = world.model.joint("sleeve_0_x").qposadr[0]
    world.data.qpos[first : first + slides.size] = slides
    mujoco.mj_forward(world.model, world.data)


def partners(world):
    """Of the cloth's contacts: what it touches, itself as None."""
    contacts = world.data.contact
    names = []
    for flex, geom in zip(contacts.flex, contacts.geom, strict=True):
        if (flex >= 0).any():
            touched = geom.max()
            body = world.model.geom_bodyid[touched]
            names.append(None if touched < 0 else world.model.body(body).name)
    return names


def test_files_have_what_is_left_out_only_where_it_is_in():
    names = {"self_contact", "robot_contact", "air_drag"}
    assert not names & set(to_plain(SleeveConfig()))
    more = SleeveConfig(self_contact=True, air_drag=True)
    assert names & set(to_plain(more)) == {"self_contact", "air_drag"}
    assert from_plain(SleeveConfig, to_plain(more)) == more


@pytest.mark.parametrize("touches", [False, True])
def test_layers_of_cloth_touch_if_they_may(posture, touches):
    world = world_with(posture, self_contact=touches)
    # The sleeve is pressed flat, away from everything: its two layers are 2 mm apart.
    flat = world.mesh.vertices - world.mesh.vertices.mean(axis=0)
    flat[:, 2] = 0.001 * np.sign(flat[:, 2])
    place(world, flat + [0.0, 0.0, 5.0])
    assert (None in partners(world)) is touches


def test_layers_that_touch_are_pushed_apart(posture):
    gaps = []
    for touches in (False, True):
        world = world_with(posture, self_contact=touches)
        world.release()
        flat = world.mesh.vertices - world.mesh.vertices.mean(axis=0)
        upper = flat[:, 2] > 0.0
        flat[:, 2] = np.where(upper, 0.0005, -0.0005)
        place(world, flat + [0.0, 0.0, 5.0])
        dofs = world.model.joint("sleeve_0_z").dofadr[0] + 3 * np.arange(len(upper))
        world.data.qvel[dofs] = np.where(upper, -0.05, 0.05)
        for _ in range(5):
            world.step()
        gaps.append(world.cloth[upper, 2].mean() - world.cloth[~upper, 2].mean())
    through, apart = gaps
    assert apart > through + 1e-3


@pytest.mark.parametrize("touches", [False, True])
def test_cloth_touches_the_robots_links_if_it_may_but_never_its_fingers(posture, touches):
    world = world_with(posture, robot_contact=touches)
    hand = world.data.body("panda_hand").xpos
    tip = world.data.body("panda_leftfinger").xpos
    for centre, link in ((hand, "panda_hand"), (tip, "panda_leftfinger")):
        small = 0.3 * (world.mesh.vertices - world.mesh.vertices.mean(axis=0))
        place(world, small + centre)
        found = {name for name in partners(world) if str(name).startswith("panda")}
        assert ("panda_hand" in found) is touches, link
        assert not {name for name in found if "finger" in name}


@pytest.mark.parametrize("name", ["panda", "ur10"])
def test_what_holds_the_cloth_is_never_touched(posture, name):
    robot = load_robot(name)
    config = WorldConfig(sleeve=SleeveConfig(robot_contact=True), robot=robot)
    spec, _ = build_spec(posture, config)
    model = spec.compile()
    (cloth,) = model.flex_conaffinity
    for geom in range(model.ngeom):
        name = model.body(model.geom_bodyid[geom]).name
        holds = "finger" in name or name == robot.tool
        mannequin = not model.geom_conaffinity[geom] & 1
        assert holds is (not mannequin and not model.geom_contype[geom] & cloth), name


def test_cloth_falls_in_air_as_a_plate_does(posture):
    """``m v' = m g - k v^2`` has the solution ``v = w tanh(g t / w)``, w the terminal velocity."""
    fabric = Garment().fabric
    terminal = np.sqrt(2.0 * fabric.areal_density * GRAVITY / (1.204 * 1.17))
    speeds = []
    for drag in (False, True):
        world = world_with(posture, air_drag=drag)
        world.release()
        place(world, world.mesh.vertices + [0.0, 0.0, 20.0])
        for _ in range(40):
            world.step()
        dofs = world.model.joint("sleeve_0_z").dofadr[0] + 3 * np.arange(len(world.cloth))
        speeds.append(-world.data.qvel[dofs])
    time = 40 * world.model.opt.timestep
    assert speeds[0] == pytest.approx(GRAVITY * time, rel=1e-6)
    # The drag of a step is that of the speed before it: an error of the step's first order.
    assert speeds[1] == pytest.approx(terminal * np.tanh(GRAVITY * time / terminal), rel=0.01)


def test_a_world_with_drag_goes_on_from_its_state(posture):
    world = world_with(posture, air_drag=True)
    for _ in range(20):
        world.step()
    state, other = world.state(), world_with(posture, air_drag=True)
    other.restore(state)
    for _ in range(5):
        world.step()
        other.step()
    assert np.array_equal(world.data.qpos, other.data.qpos)
