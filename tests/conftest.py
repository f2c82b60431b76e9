"""What several test files share: things that are slow to make, and a helper for error texts."""

import os

import numpy as np
import pytest
from hypothesis import settings

from dressing_sim.benchmark.suites import load_suite
from dressing_sim.episode import Episode, demonstrate
from dressing_sim.errors import DressingSimError
from dressing_sim.world.rendering import gl_backend

# The same examples in every run, however long the machine takes for one.
settings.register_profile("repeatable", deadline=None, derandomize=True)
settings.load_profile("repeatable")


@pytest.fixture(scope="session")
def posture():
    """An arm that is easy to dress."""
    return load_suite("paper5")[1]


@pytest.fixture(scope="session")
def demonstrated(posture):
    """The expert's demonstration on that arm with seed 0, and its outcome."""
    demonstration, outcome = demonstrate(posture, seed=0)
    assert demonstration is not None
    return demonstration, outcome


@pytest.fixture(scope="session")
def demonstration(demonstrated):
    return demonstrated[0]


@pytest.fixture
def world(posture, tmp_path, monkeypatch):
    """A settled world of one's own. MuJoCo leaves its log of warnings in the current folder."""
    monkeypatch.chdir(tmp_path)
    return Episode(posture).world


@pytest.fixture(scope="session")
def opengl():
    """Something to draw with: a test that asks for it is skipped without, or fails if it must."""
    try:
        return gl_backend()
    except DressingSimError as error:
        if os.environ.get("DRESSING_SIM_REQUIRE_GL") == "1":
            pytest.fail(f"DRESSING_SIM_REQUIRE_GL=1, but {error}")
        pytest.skip(str(error))


@pytest.fixture
def rng():
    return np.random.default_rng(0)
