"""Demonstrations that were recorded before are the same bits, and a cache is never in the way."""

import numpy as np
import pytest

from dressing_sim.benchmark.run import cache
from dressing_sim.benchmark.run.cache import VARIABLE, cache_folder, cached_demonstration


@pytest.fixture
def made(demonstration):
    calls = []

    def make():
        calls.append(1)
        return demonstration

    make.calls = calls
    return make


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(tmp_path))
    return tmp_path / "demonstrations"


def test_what_depends_on_the_same_is_made_once_and_is_the_same_bits(made, folder):
    first = cached_demonstration(["a", 1], made)
    again = cached_demonstration(["a", 1], made)
    assert len(made.calls) == 1
    assert np.array_equal(first.positions, again.positions)
    assert np.array_equal(first.commands, again.commands)
    assert (first.dt, first.seed, first.posture) == (again.dt, again.seed, again.posture)
    cached_demonstration(["a", 2], made)
    assert len(made.calls) == 2


@pytest.mark.parametrize("content", [b"", b"not HDF5", None])
def test_a_damaged_file_is_made_anew(made, folder, content):
    cached_demonstration("x", made)
    (file,) = folder.iterdir()
    whole = file.read_bytes()
    file.write_bytes(whole[: len(whole) // 2] if content is None else content)
    cached_demonstration("x", made)
    assert len(made.calls) == 2
    cached_demonstration("x", made)
    assert len(made.calls) == 2


def test_a_cache_that_cannot_be_written_costs_a_warning(made, folder, caplog):
    folder.write_text("a file where the folder should be")
    cache._warn.cache_clear()
    for key in ("x", "y"):
        assert cached_demonstration(key, made) is made()
    assert len([r for r in caplog.records if "not kept" in r.message]) == 1


def test_an_empty_variable_keeps_nothing(made, monkeypatch):
    monkeypatch.setenv(VARIABLE, "")
    assert cache_folder() is None
    cached_demonstration("x", made)
    cached_demonstration("x", made)
    assert len(made.calls) == 2


def test_no_more_are_kept_than_that(made, folder, monkeypatch):
    monkeypatch.setattr(cache, "MOST", 3)
    for key in range(12):
        before = set(folder.glob("*.h5"))
        cached_demonstration(key, made)
        now = set(folder.glob("*.h5"))
        assert len(now) == min(3, key + 1)
        assert len(now - before) == 1  # the newest is always there
