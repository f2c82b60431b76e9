import json
import os
from dataclasses import replace

import h5py
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from dressing_sim.arm import Posture
from dressing_sim.episode.demonstration import (
    FORMAT,
    FORMAT_VERSION,
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.errors import InvalidInputError


def made_up(seed, rows=20):
    rng = np.random.default_rng(seed)
    posture = Posture(f"arm{seed}", *rng.uniform(10, 60, 4), size="female")
    return Demonstration(
        positions=rng.standard_normal((rows, 3)),
        dt=rng.uniform(0.01, 0.1),
        posture=posture,
        seed=seed,
        commands=rng.standard_normal((rows, 7)),
        settings={"episode": {"hold": 1.0, "names": ["a", "b"]}},
    )


def assert_same(one, other):
    assert one.positions.tobytes() == other.positions.tobytes()
    assert one.commands.tobytes() == other.commands.tobytes()
    assert (one.dt, one.posture, one.seed) == (other.dt, other.posture, other.seed)
    assert (one.settings, one.versions) == (other.settings, other.versions)
    assert one.frames == other.frames


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("saved") / "demonstrations.h5"
    save_demonstrations(path, [made_up(1)])
    return path


@pytest.fixture
def copy(saved, tmp_path):
    """A saved file of one demonstration to be spoilt."""
    path = tmp_path / "demonstrations.h5"
    path.write_bytes(saved.read_bytes())
    return path


def assert_invalid(path, part=""):
    with pytest.raises(InvalidInputError) as caught:
        load_demonstrations(path)
    message = str(caught.value)
    assert str(path) in message
    assert part in message
    assert "\n" not in message


def test_demonstrations_come_back_to_the_bit_and_in_their_order(tmp_path):
    # More than ten, so that an order by name would show.
    demonstrations = [made_up(seed) for seed in range(12)]
    save_demonstrations(tmp_path / "some.h5", demonstrations)
    loaded = load_demonstrations(tmp_path / "some.h5")
    for one, other in zip(demonstrations, loaded, strict=True):
        assert_same(one, other)


def test_a_recorded_demonstration_comes_back_to_the_bit(demonstration, tmp_path):
    save_demonstrations(tmp_path / "recorded.h5", [demonstration])
    assert_same(demonstration, load_demonstrations(tmp_path / "recorded.h5")[0])
    assert demonstration.versions["mujoco"]


@pytest.mark.parametrize(
    "change",
    [{"dt": 1}, {"dt": np.float32(0.5)}, {"seed": np.int64(3)}, {"positions": [[0, 0, 0]] * 5}],
)
def test_numbers_of_any_kind_come_back(change, tmp_path):
    made = made_up(1)
    short = {"positions": made.positions[:5], "commands": made.commands[:5]}
    demonstration = replace(made, **{**short, **change})
    save_demonstrations(tmp_path / "some.h5", [demonstration])
    assert_same(demonstration, load_demonstrations(tmp_path / "some.h5")[0])


def test_other_programs_find_positions_and_joints_in_the_file(saved):
    expected = made_up(1)
    with h5py.File(saved) as file:
        assert np.bytes_(file.attrs["format"]) == np.bytes_(FORMAT)
        np.testing.assert_array_equal(file["0/positions"], expected.positions)
        for joint in ("shoulder", "elbow", "wrist"):
            np.testing.assert_array_equal(file[f"0/{joint}"], getattr(expected.posture, joint))


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"positions": np.zeros((5, 2))}, "positions has shape (5, 2)"),
        ({"positions": np.zeros((1, 3))}, "positions has shape (1, 3)"),
        ({"commands": np.zeros(5)}, "commands has shape (5,)"),
        ({"positions": np.full((5, 3), np.nan)}, "not finite"),
        ({"commands": np.full((5, 7), np.inf)}, "not finite"),
        ({"dt": 0.0}, "dt is 0.0"),
        ({"dt": float("nan")}, "dt is nan"),
        ({"dt": float("inf")}, "dt is inf"),
        ({"positions": np.zeros((6, 3)), "commands": np.zeros((5, 7))}, "6 positions with 5"),
    ],
)
def test_a_demonstration_that_cannot_be_one_is_an_error(change, part):
    with pytest.raises(InvalidInputError) as caught:
        replace(made_up(1), **change)
    assert part in str(caught.value)
    assert "'arm1'" in str(caught.value)


def test_a_missing_a_foreign_and_an_empty_file_are_errors(tmp_path):
    assert_invalid(tmp_path / "none.h5", "no such file")
    assert_invalid(tmp_path, "no such file")
    for name, content in (("text.h5", b"not HDF5\n"), ("empty.h5", b"")):
        (tmp_path / name).write_bytes(content)
        assert_invalid(tmp_path / name, "not HDF5")
    with h5py.File(tmp_path / "foreign.h5", "w") as file:
        file["measurements"] = np.zeros(3)
    assert_invalid(tmp_path / "foreign.h5", "not a file of demonstrations")


@given(fraction=st.floats(0.0, 0.999))
def test_a_truncated_file_is_an_error(saved, tmp_path_factory, fraction):
    content = saved.read_bytes()
    path = tmp_path_factory.mktemp("cut") / "cut.h5"
    path.write_bytes(content[: int(fraction * len(content))])
    assert_invalid(path)


def test_damage_anywhere_is_an_error_or_does_no_harm(saved, tmp_path, rng):
    content = np.frombuffer(saved.read_bytes(), dtype=np.uint8)
    # Strings of variable length are in a global heap, the one part of a file without a checksum:
    # the HDF5 library reads a damaged one for ever.
    assert b"GCOL" not in content.tobytes()
    path = tmp_path / "damaged.h5"
    for _ in range(1000):
        damaged = content.copy()
        place = rng.integers(len(content))
        damaged[place : place + rng.integers(1, 64)] ^= rng.integers(1, 256, dtype=np.uint8)
        path.write_bytes(damaged.tobytes())
        try:
            loaded = load_demonstrations(path)
        except InvalidInputError as error:
            assert "\n" not in str(error)  # noqa: PT017
        else:
            assert_same(loaded[0], made_up(1))


@pytest.mark.parametrize("joint", ["shoulder", "elbow", "wrist"])
def test_joints_that_contradict_the_angles_are_an_error(copy, joint):
    with h5py.File(copy, "a") as file:
        file[f"0/{joint}"][1] += 1e-4
    assert_invalid(copy, "joints of posture 'arm1'")


@pytest.mark.parametrize("name", ["positions", "commands", "elbow"])
def test_a_missing_array_is_an_error(copy, name):
    with h5py.File(copy, "a") as file:
        del file[f"0/{name}"]
    assert_invalid(copy)


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("posture", "not JSON"),
        ("posture", json.dumps({"name": "half"})),
        ("posture", json.dumps([1, 2])),
        ("settings", "{"),
        ("settings", json.dumps(3)),
        ("dt", "long"),
        ("dt", -1.0),
        ("seed", "odd"),
    ],
)
def test_an_attribute_that_makes_no_sense_is_an_error(copy, name, value):
    with h5py.File(copy, "a") as file:
        file["0"].attrs[name] = value
    assert_invalid(copy)


def test_a_group_that_is_no_demonstration_is_an_error(copy):
    with h5py.File(copy, "a") as file:
        file["notes"] = "about the arm"
    assert_invalid(copy)


def test_another_format_version_is_an_error_that_says_which_is_valid(copy):
    with h5py.File(copy, "a") as file:
        file.attrs["format_version"] = FORMAT_VERSION + 1
    assert_invalid(copy, f"version {FORMAT_VERSION + 1}, valid is 1 to {FORMAT_VERSION}")


def test_a_failed_write_keeps_the_old_file_and_leaves_nothing_else(copy, monkeypatch):
    before = copy.read_bytes()
    unwritable = replace(made_up(2), settings={"config": object()})
    with pytest.raises(TypeError):
        save_demonstrations(copy, [made_up(3), unwritable])

    def fails(*_arguments):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fails)
    with pytest.raises(InvalidInputError, match="disk full"):
        save_demonstrations(copy, [made_up(3)])
    assert copy.read_bytes() == before
    assert list(copy.parent.iterdir()) == [copy]
