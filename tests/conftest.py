"""What several test files share: things that are slow to make, and a helper for error texts."""

import common_numerics  # noqa: F401  # isort: skip  # before numpy is loaded

import os
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from chromium import NAMES, Chromium, find_chromium
from hypothesis import settings

from dressing_sim.benchmark.run.cache import VARIABLE
from dressing_sim.episode.dressing import Dressing
from dressing_sim.episode.operator import Operator
from dressing_sim.episode.record import demonstrate, record
from dressing_sim.episode.recording import Recording
from dressing_sim.errors import DressingSimError
from dressing_sim.pictures.rendering import gl_backend
from dressing_sim.suites.suites import load_suite
from dressing_sim.world.simulation import World

# The same examples in every run, however long the machine takes for one.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.fixture(scope="session", autouse=True)
def _own_cache(tmp_path_factory):
    """Demonstrations are kept for the tests of one session alone."""
    os.environ[VARIABLE] = str(tmp_path_factory.mktemp("cache"))


@pytest.fixture(scope="session")
def posture():
    """An arm that is easy to dress."""
    return load_suite("paper5")[1]


@pytest.fixture(scope="session")
def demonstrated(posture):
    """The expert's demonstration on that arm with seed 0, and its outcome."""
    demonstration = demonstrate(posture, seed=0)
    return demonstration, demonstration.outcome


@pytest.fixture(scope="session")
def demonstration(demonstrated):
    return demonstrated[0]


class Watched(NamedTuple):
    """An episode, and the arm after each of its physics steps, each of shape (n, 7)."""

    recording: Recording
    positions: np.ndarray
    velocities: np.ndarray
    torques: np.ndarray


@pytest.fixture(scope="session")
def watched():
    """The expert with seed 0 on a posture of the suite paper5, by its name; dressed once."""
    postures = {posture.name: posture for posture in load_suite("paper5")}
    step = World.step

    @cache
    def dressed(name):
        rows = []

        def watch(world):
            step(world)
            rows.append((world.arm_configuration, world.arm_velocity, world.arm_torque))

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(World, "step", watch)
            recording = record(Operator(), postures[name], seed=0)
        return Watched(recording, *np.array(rows).transpose(1, 0, 2))

    return dressed


@pytest.fixture
def world(posture, tmp_path, monkeypatch):
    """A settled world of one's own."""
    monkeypatch.chdir(tmp_path)
    dressing = Dressing(posture)
    dressing.reset()
    return dressing.world


@pytest.fixture(scope="session")
def opengl():
    """Something to draw with: a test that asks for it is skipped without, or fails if it must."""
    try:
        return gl_backend()
    except DressingSimError as error:
        if os.environ.get("DRESSING_SIM_REQUIRE_GL") == "1":
            pytest.fail(f"DRESSING_SIM_REQUIRE_GL=1, but {error}")
        pytest.skip(str(error))


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """A headless browser: a test that asks for it is skipped without, or fails if it must."""
    if find_chromium() is None:
        told = f"no browser here: none of {', '.join(NAMES)}; apt install chromium"
        if os.environ.get("DRESSING_SIM_REQUIRE_BROWSER") == "1":
            pytest.fail(f"DRESSING_SIM_REQUIRE_BROWSER=1, but {told}")
        pytest.skip(told)
    browser = Chromium(tmp_path_factory.mktemp("chromium"))
    yield browser
    browser.close()


@pytest.fixture
def rng():
    return np.random.default_rng(0)
