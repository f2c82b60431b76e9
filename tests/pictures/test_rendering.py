import numpy as np
import pytest

from dressing_sim.episode.dressing import Dressing
from dressing_sim.errors import DressingSimError
from dressing_sim.pictures import CAMERAS, rendering
from dressing_sim.pictures.overlays import Mark
from dressing_sim.pictures.rendering import BACKENDS, INSTALL_HINT, OffscreenRenderer
from dressing_sim.world.robot import PANDA
from dressing_sim.world.scene import WorldConfig

SIZE = {"width": 320, "height": 240}


@pytest.fixture(scope="module")
def renderer(opengl, posture):
    with OffscreenRenderer(posture, WorldConfig(), **SIZE) as renderer:
        yield renderer


def blue(picture):
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    return (blue > red + 40) & (blue > green + 20)


def skin(picture):
    red, green, blue = np.moveaxis(picture.astype(int), -1, 0)
    return (red > blue + 25) & (red > green + 8) & (green > blue)


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_picture_shows_sleeve_skin_and_robot(renderer, world, camera):
    picture = renderer.draw(world.data.qpos, camera)
    assert picture.shape == (240, 320, 3)
    assert picture.dtype == np.uint8
    assert 0.002 < blue(picture).mean() < 0.2
    assert 0.01 < skin(picture).mean() < 0.3
    # The robot is what changes if nothing but its joints does, and it is white, grey and black.
    elsewhere = world.data.qpos.copy()
    elsewhere[[world.model.joint(name).qposadr[0] for name in PANDA.joints]] = 0.3
    robot = np.abs(renderer.draw(elsewhere, camera).astype(int) - picture).max(axis=2) > 30
    # Over the person's shoulder, and of the whole room, it is farther away.
    assert robot.mean() > (0.04 if camera in ("person", "room") else 0.05)
    grey = np.ptp(picture[robot].astype(int), axis=1) < 15
    assert (grey & (picture[robot].max(axis=1) > 150)).sum() > 200
    assert (grey & (picture[robot].max(axis=1) < 60)).sum() > 200


def test_the_picture_follows_the_state_and_only_the_state(renderer, world):
    before = renderer.draw(world.data.qpos)
    moved = world.data.qpos.copy()
    moved[-len(world.cloth) * 3 :] += 0.1  # the cloth's slides
    after = renderer.draw(moved)
    assert blue(before).any()
    assert not np.array_equal(blue(before), blue(after))
    np.testing.assert_array_equal(renderer.draw(world.data.qpos), before)


@pytest.mark.usefixtures("opengl")
def test_a_film_whose_camera_stands_still_has_the_same_pictures(world, posture):
    """What does not move is drawn once, and what moves is put before it or behind it."""
    config = WorldConfig()
    line = Mark(posture.wrist, posture.shoulder + 0.1, 0.01, (0.9, 0.4, 0.1))
    moved = world.data.qpos.copy()
    moved[[world.model.joint(name).qposadr[0] for name in PANDA.joints]] += 0.1
    states = [(world.data.qpos, []), (moved, [line]), (world.data.qpos, [])]
    with OffscreenRenderer(posture, config, **SIZE, fine=False) as layered:
        drawn = [layered.draw(state, "front", marks) for state, marks in states]
        layered._whole = True
        whole = [layered.draw(state, "front", marks) for state, marks in states]
    np.testing.assert_array_equal(drawn, whole)
    assert not np.array_equal(drawn[0], drawn[1])


def test_drawing_does_not_change_the_physics(renderer, world, posture):
    dressing = Dressing(posture)
    dressing.reset()
    unseen = dressing.world
    for step in range(20):
        world.step()
        unseen.step()
        if step % 5 == 0:
            renderer.draw(world.data.qpos)
    assert world.data.qpos.tobytes() == unseen.data.qpos.tobytes()
    assert world.data.qvel.tobytes() == unseen.data.qvel.tobytes()
    assert world.data.efc_force.tobytes() == unseen.data.efc_force.tobytes()


def test_the_backend_that_is_used_works(opengl):
    assert opengl in BACKENDS
    assert rendering.probe(opengl) is None


@pytest.mark.parametrize(
    ("platform", "expected"),
    [
        ("linux", ("egl", "osmesa")),
        ("freebsd14", ("egl", "osmesa")),
        ("darwin", ("cgl", "glfw")),
        ("win32", ("glfw",)),
    ],
)
def test_each_operating_system_has_its_backends(platform, expected):
    assert rendering.backends(platform) == expected


def test_a_picture_that_is_too_large_to_draw_is_an_error(opengl, posture):
    with pytest.raises(DressingSimError):
        OffscreenRenderer(posture, WorldConfig(), width=10**5, height=10)


def test_a_backend_that_does_not_exist_has_a_reason():
    assert "nonsense" in rendering.probe("nonsense")


@pytest.mark.parametrize(
    ("works", "wanted", "expected"),
    [
        (BACKENDS, "", BACKENDS[0]),
        (BACKENDS[1:], "", BACKENDS[1]),
        (BACKENDS, BACKENDS[1], BACKENDS[1]),
        (BACKENDS, BACKENDS[1].upper(), BACKENDS[1]),
        (BACKENDS, "glfw", BACKENDS[0]),
    ],
)
def test_the_first_backend_that_works_is_used(monkeypatch, works, wanted, expected):
    monkeypatch.setattr(rendering, "probe", lambda name: None if name in works else "broken")
    monkeypatch.setenv("MUJOCO_GL", wanted)
    monkeypatch.setenv("PYOPENGL_PLATFORM", "")
    assert rendering.gl_backend.__wrapped__() == expected


def test_without_any_opengl_the_error_says_what_to_install(monkeypatch):
    monkeypatch.setattr(rendering, "probe", lambda name: "broken")
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    with pytest.raises(DressingSimError) as caught:
        rendering.gl_backend.__wrapped__()
    assert str(caught.value) == INSTALL_HINT
    assert "apt install" in INSTALL_HINT
    assert "\n" not in INSTALL_HINT


def test_a_backend_that_was_asked_for_is_named_when_it_does_not_work(monkeypatch):
    monkeypatch.setattr(rendering, "probe", lambda name: "no such library")
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    with pytest.raises(DressingSimError, match=r"MUJOCO_GL=osmesa .*no such library.* unset it"):
        rendering.gl_backend.__wrapped__()
