from dataclasses import replace
from types import SimpleNamespace

import imageio.v2 as imageio
import numpy as np
import pytest

from dressing_sim.episode.outcome import Failure, Outcome
from dressing_sim.errors import DressingSimError, InvalidInputError
from dressing_sim.pictures import rendering
from dressing_sim.pictures.encoding import FORMATS, check_format, gif_delays
from dressing_sim.pictures.look import Look
from dressing_sim.pictures.story import Story
from dressing_sim.pictures.video import Film, Shot, write_stills, write_video
from dressing_sim.world.scene import WorldConfig

SIZE = {"width": 160, "height": 128}


def fake_world(time):
    return SimpleNamespace(
        time=time,
        data=SimpleNamespace(qpos=np.array([time])),
        cloth=np.zeros((1, 3)),
        grip_load=np.zeros(3),
        cloth_load=SimpleNamespace(net=np.zeros((5, 3))),
        person=None,
    )


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
    np.testing.assert_array_equal(film.moments[0].qpos, [1.0])


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
    film.moments[-1] = replace(film.moments[-1], qpos=np.zeros(3))  # of some other model
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


@pytest.mark.parametrize("fps", [7, 10, 25, 30, 50, 60, 100])
def test_a_gif_plays_in_real_time(fps):
    delays = gif_delays(3 * fps, fps)
    assert sum(delays) == 300
    assert min(delay for delay in delays if delay) >= 2  # less, and browsers show it for ten
    shown = sum(delay > 0 for delay in delays)
    assert shown == 3 * fps if fps <= 50 else shown > 100


def test_two_episodes_side_by_side_with_all_there_is_to_tell(opengl, film, posture, tmp_path):
    failed = Outcome(False, (Failure("strain", "too much", 0.1),))
    path = np.linspace(posture.wrist, posture.shoulder, 20)
    story = Story("a policy", failed, path, (path + 0.1,))
    short = Film(25)
    short.moments = film.moments[:2]
    config = WorldConfig()
    shots = [Shot(film, posture, config, story), Shot(short, posture, config, Story("other"))]
    look = Look("auto", 160, 128, ("frames", "path", "demonstrations", "strain", "forces"), True)
    write_video(tmp_path / "film.mp4", shots, look)
    pictures = [np.asarray(p) for p in imageio.get_reader(tmp_path / "film.mp4")]
    assert len(pictures) == len(film)
    assert pictures[0].shape == (128, 320, 3)
    write_stills(tmp_path / "still.png", shots, look, at=0.1)
    assert imageio.imread(tmp_path / "still.png").shape == (256, 160, 3)


def test_what_is_known_of_the_verdict_is_told_when_it_is_known():
    story = Story("t", Outcome(False, (Failure("strain", "too much", 3.0),)))
    assert [story.verdict(t, 8.0) for t in (1.0, 3.0, 7.9)] == ["", "strain", "failure: strain"]
    assert Story("t", Outcome(True)).verdict(8.0, 8.0) == "success"
    assert Story("t", Outcome(False, invalid="broke")).verdict(8.0, 8.0) == "void: broke"
    assert Story("t", Outcome(False, abstained="unsure")).verdict(8.0, 8.0) == "abstained"
