import logging
import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from dressing_sim.pictures import meshes
from dressing_sim.pictures.meshes import cache_folder, converted_meshes
from dressing_sim.world.description import addressed

COLLADA = addressed("package://example-robot-data/robots/panda_description/meshes/visual/hand.dae")


@pytest.fixture(autouse=True)
def empty(tmp_path, monkeypatch):
    """A user without a cache; warnings are told anew."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    meshes._told.clear()


@pytest.fixture
def kept():
    converted_meshes(COLLADA)
    (file,) = cache_folder().iterdir()
    return file


def test_a_link_has_a_mesh_of_each_colour(kept):
    found = converted_meshes(COLLADA)
    assert len(found) > 1
    for colour, content in found.items():
        assert len(bytes.fromhex(colour)) == 3
        assert content.count("\nf ") > 100


def test_what_is_kept_is_read_and_not_converted_again(kept, monkeypatch):
    expected = converted_meshes(COLLADA)
    monkeypatch.setattr(meshes, "_convert", lambda collada: pytest.fail("converted again"))
    assert converted_meshes(COLLADA) == expected


@pytest.mark.parametrize(
    "damage",
    [
        lambda content: b"",
        lambda content: content[:100],
        lambda content: content[:-1],
        lambda content: content[:500] + b"x" + content[501:],
        lambda content: b"nonsense",
    ],
)
def test_a_damaged_file_costs_a_warning_and_is_made_anew(kept, damage, caplog):
    good = kept.read_bytes()
    expected = converted_meshes(COLLADA)
    kept.write_bytes(damage(good))
    with caplog.at_level(logging.WARNING):
        assert converted_meshes(COLLADA) == expected
    assert len(caplog.messages) == 1
    assert str(kept) in caplog.messages[0]
    assert kept.read_bytes() == good


def test_without_a_folder_to_write_to_meshes_are_made_each_time(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    with caplog.at_level(logging.WARNING):
        first, second = converted_meshes(COLLADA), converted_meshes(COLLADA)
    assert first == second
    assert len(caplog.messages) == 1
    assert str(tmp_path / "file") in caplog.messages[0]


def test_many_at_once_find_a_whole_file():
    with ThreadPoolExecutor(8) as threads:
        found = list(threads.map(converted_meshes, [COLLADA] * 8))
    assert all(one == found[0] for one in found)
    assert [name for name in os.listdir(cache_folder()) if not name.endswith(".meshes")] == []
