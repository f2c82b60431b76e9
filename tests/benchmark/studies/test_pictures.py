from io import BytesIO
from types import SimpleNamespace

import imageio.v3 as imageio
import numpy as np
import pytest
from fake_benchmark import Threads, write_suite
from fake_results import HIT, SMALL, STUCK, UNREACHABLE, results_of

from dressing_sim.benchmark.records import Entry, Protocol
from dressing_sim.benchmark.run.plan import make_plan
from dressing_sim.benchmark.run.store import load_run, open_run
from dressing_sim.benchmark.studies import pictures
from dressing_sim.benchmark.studies.pictures import failure_picture, failure_pictures
from dressing_sim.benchmark.studies.study import run_jobs
from dressing_sim.benchmark.studies.success import Success
from dressing_sim.episode.config import EpisodeConfig
from dressing_sim.episode.thresholds import Thresholds
from dressing_sim.errors import DressingSimError

DT = EpisodeConfig().tracking.dt
N_STEPS = 200
SETTLED = -1.0
STUDY = Success()


class FakeRenderer:
    """Draws a state as a grey picture, as bright as the state's only coordinate."""

    def __init__(self, posture, config, width, height):
        self.shape = height, width, 3

    def __enter__(self):
        return self

    def __exit__(self, *_error):
        pass

    def draw(self, state, camera):
        return np.full(self.shape, 255 if state[0] == SETTLED else state[0], dtype=np.uint8)


class FakeEpisode:
    def __init__(self, posture, config):
        self.posture = posture

    def reset(self):
        self.world = SimpleNamespace(data=SimpleNamespace(qpos=np.array([SETTLED])))


@pytest.fixture
def without_physics(monkeypatch):
    """Episodes of so many steps with the number of the step as their state."""
    differences = []

    def replay(study, folder, index, observer):
        result = folder[index]
        world = SimpleNamespace(data=SimpleNamespace(qpos=np.zeros(1)))
        for step in range(0 if result.outcome is UNREACHABLE else N_STEPS):
            world.data.qpos[0] = step
            observer(world)
        return SimpleNamespace(
            result=result, differences=differences, posture=result.posture, config=EpisodeConfig()
        )

    monkeypatch.setattr(pictures, "replay_episode", replay)
    monkeypatch.setattr(pictures, "OffscreenRenderer", FakeRenderer)
    monkeypatch.setattr(pictures, "Dressing", FakeEpisode)
    monkeypatch.setattr(pictures, "gl_backend", lambda: "fake")
    return differences


def drawn(outcome, **options):
    """The brightness of the picture of an episode with this outcome, and its shape."""
    (result, *_) = results = results_of(SMALL, [[outcome], [HIT], [HIT]])
    file = failure_picture(STUDY, dict(enumerate(results)), result, **options)
    picture = imageio.imread(BytesIO(file), extension=".png")
    assert picture.min() == picture.max()
    return int(picture.max()), picture.shape


@pytest.mark.usefixtures("without_physics")
@pytest.mark.parametrize(("outcome", "time"), [(HIT, 2.0), (STUCK, 3.0)])
def test_the_picture_shows_the_end_of_the_step_in_which_the_first_thing_went_wrong(outcome, time):
    step, _ = drawn(outcome)
    assert (step + 1) * DT == pytest.approx(time)


@pytest.mark.usefixtures("without_physics")
def test_an_episode_that_was_over_sooner_is_shown_at_its_end(monkeypatch):
    monkeypatch.setattr(f"{__name__}.N_STEPS", 5)
    assert drawn(STUCK)[0] == 4


@pytest.mark.usefixtures("without_physics")
def test_a_robot_that_never_moved_is_shown_as_it_stood():
    assert drawn(UNREACHABLE)[0] == 255


@pytest.mark.usefixtures("without_physics")
def test_pictures_are_as_large_as_wanted():
    assert drawn(HIT, width=64, height=48)[1] == (48, 64, 3)


def test_an_episode_that_comes_out_otherwise_has_no_picture(without_physics):
    without_physics.append("success: recorded false, now true")
    (result, *_) = results = results_of(SMALL, [[HIT], [HIT], [HIT]])
    assert failure_picture(STUDY, dict(enumerate(results)), result) is None


def test_without_opengl_nothing_is_simulated(monkeypatch):
    def fails():
        raise DressingSimError("no offscreen OpenGL works here")

    monkeypatch.setattr(pictures, "gl_backend", fails)
    monkeypatch.setattr(pictures, "replay_episode", None)
    results = results_of(SMALL, [[HIT], [HIT], [HIT]])
    with pytest.raises(DressingSimError, match="no offscreen OpenGL"):
        failure_picture(STUDY, {}, results[0])
    drawn = failure_pictures(STUDY, {}, results)
    assert drawn.png == {}
    assert drawn.missing == "pictures left out: no offscreen OpenGL works here"


@pytest.mark.usefixtures("without_physics")
def test_a_failed_episode_of_each_of_the_hardest_postures_is_drawn():
    results = results_of(SMALL, [[HIT, HIT], [STUCK, HIT], [HIT, HIT]])
    drawn = failure_pictures(STUDY, dict(enumerate(results)), results)
    assert list(drawn.png) == [2, 3]


@pytest.mark.usefixtures("opengl")
def test_a_failed_episode_of_a_run_is_drawn_as_it_was(tmp_path):
    suite = write_suite(tmp_path / "suite.json", 1)
    # The least pull is too much, so that the robot stops as soon as it moves.
    config = EpisodeConfig(thresholds=Thresholds(grip_force=0.2))
    plan = make_plan(Protocol("tiny", suite, (Entry("expert"),)), 0, config)
    with Threads(1) as workers, open_run(tmp_path / "run", plan) as run:
        (result,) = run_jobs(STUDY, run, workers)
    assert "over_force" in result.outcome.reasons
    png = failure_picture(STUDY, load_run(tmp_path / "run"), result)
    picture = imageio.imread(BytesIO(png))
    assert picture.shape == (360, 480, 3)
    # A lit scene, neither black nor of one colour.
    assert 30.0 < picture.mean() < 225.0
    assert picture.std() > 20.0
