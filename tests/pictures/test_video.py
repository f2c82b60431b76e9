from types import SimpleNamespace

import imageio.v2 as imageio
import numpy as np
import pytest

from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.pictures import rendering
from dressing_sim.pictures.video import FORMATS, Film, check_format
from dressing_sim.world.scene import WorldConfig

SIZE = {"width": 160, "height": 128}


def fake_world(time):
    return SimpleNamespace(time=time, data=SimpleNamespace(qpos=np.array([time])))


@pytest.fixture
def film(world):
    film = Film(fps=25)
    world.release()  # the sleeve falls: a GIF keeps pictures that are alike only once
    for _ in range(round(0.2 / world.model.opt.timestep)):
        world.step()
        film.expose(world)
    return film


@pytest.mark.parametrize("fps", [10, 25, 30])
@pytest.mark.parametrize("dt", [0.005, 0.02])
def test_a_film_has_as_many_pictures_a_second_as_asked_for(fps, dt):
    film = Film(fps)
    for step in range(round(2.0 / dt)):
        film.expose(fake_world(1.0 + step * dt))
    assert abs(len(film) - 2.0 * fps) <= 1


def test_a_film_keeps_states_that_change_later():
    film, world = Film(), fake_world(1.0)
    film.expose(world)
    world.data.qpos[:] = 5.0
    np.testing.assert_array_equal(film._states[0], [1.0])


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_film_can_be_played(opengl, film, posture, tmp_path, suffix):
    path = tmp_path / "folder" / f"film{suffix}"
    film.write(path, posture, WorldConfig(), camera="close", **SIZE)
    assert list(path.parent.iterdir()) == [path]
    pictures = [np.asarray(picture)[..., :3] for picture in imageio.get_reader(path)]
    assert len(pictures) == len(film) == 5
    assert pictures[0].shape == (128, 160, 3)
    assert np.ptp(pictures[0]) > 100


@pytest.mark.parametrize("name", ["film.avi", "film", "film.mp4.txt", ".mp4"])
def test_an_unknown_format_is_an_error_that_says_which_are_valid(name, posture, tmp_path):
    with pytest.raises(InvalidInputError, match=r"valid is \.mp4, \.gif"):
        check_format(name, 640, 480)
    with pytest.raises(InvalidInputError):
        Film().write(tmp_path / name, posture, WorldConfig())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ["film.mp4", "FILM.MP4", "a.b.gif"])
def test_a_known_format_is_none(name):
    check_format(name, 640, 480)


@pytest.mark.parametrize(
    ("name", "size"), [("a.mp4", (641, 480)), ("a.mp4", (640, 0)), ("a.gif", (640, 100000))]
)
def test_a_size_that_no_film_can_have_is_an_error(name, size):
    with pytest.raises(InvalidInputError, match=f"{size[0]} x {size[1]} pixels"):
        check_format(name, *size)


@pytest.mark.parametrize("suffix", FORMATS)
def test_a_film_is_as_large_as_asked_for(opengl, film, posture, tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    film.write(path, posture, WorldConfig(), width=100, height=90)
    assert {np.asarray(picture).shape[:2] for picture in imageio.get_reader(path)} == {(90, 100)}


def test_a_film_without_a_picture_is_not_written(opengl, posture, tmp_path):
    with pytest.raises(DressingSimError):
        Film().write(tmp_path / "film.mp4", posture, WorldConfig(), **SIZE)
    assert list(tmp_path.iterdir()) == []


def test_a_film_that_fails_half_way_leaves_nothing(opengl, film, posture, tmp_path):
    film._states[-1] = np.zeros(3)  # of some other model
    with pytest.raises(ValueError, match="shape"):
        film.write(tmp_path / "film.mp4", posture, WorldConfig(), **SIZE)
    assert list(tmp_path.iterdir()) == []


def test_without_opengl_nothing_is_written(film, posture, tmp_path, monkeypatch):
    def missing():
        raise DressingSimError("no offscreen OpenGL works here")

    monkeypatch.setattr(rendering, "gl_backend", missing)
    folder = tmp_path / "films"
    folder.mkdir()
    with pytest.raises(DressingSimError, match="OpenGL"):
        film.write(folder / "film.mp4", posture, WorldConfig())
    assert list(folder.iterdir()) == []
