"""Data sets of others, read by their own libraries where these are installed."""

import json
import os
from dataclasses import replace

import h5py
import numpy as np
import pytest
from lab_recordings import TURN_DEG, columns

from dressing_sim.cli import main
from dressing_sim.datasets.columns import OBSERVED, actions, observations
from dressing_sim.datasets.prepare import ImportConfig, demonstration_of
from dressing_sim.datasets.recording import of_columns
from dressing_sim.datasets.replayed import Cameras, pictures
from dressing_sim.datasets.sources import read_source
from dressing_sim.episode.demonstration import (
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.suites.suites import load_suite

OUT = {"robomimic": "r.hdf5", "minari": "set-v0", "lerobot": "set"}
MODULE = {"robomimic": "h5py", "minari": "minari", "lerobot": "lerobot"}


def simulated():
    """Two demonstrations with commands, made up."""
    made = []
    for number, arm in enumerate(load_suite("case_a")):
        rng = np.random.default_rng(number)
        way = arm.wrist + np.cumsum(rng.normal(0.0, 0.002, (40 + number, 3)), axis=0)
        joints = rng.normal(size=(len(way), 7))
        made.append(Demonstration(way, 0.02, arm, number, joints, {"operator": {"speed": 0.1}}))
    return made


def recorded():
    """One of a lab, with orientations and forces."""
    return [demonstration_of(of_columns("r", columns()), ImportConfig(turn_deg=-TURN_DEG))]


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("HF_HUB_OFFLINE", "1")
    return tmp_path


def export(demonstrations, to, capsys=None):
    pytest.importorskip(MODULE[to])
    save_demonstrations("d.h5", demonstrations)
    main(["export", "d.h5", "--to", to, "--out", OUT[to]])
    return OUT[to]


@pytest.mark.parametrize("make", [simulated, recorded])
@pytest.mark.parametrize("to", OUT)
def test_what_was_written_is_read_again_to_the_bit(to, make, here):
    demonstrations = make()
    main(["import", export(demonstrations, to), "--out", "again.h5"])
    again = load_demonstrations("again.h5")
    for one, other in zip(demonstrations, again, strict=True):
        np.testing.assert_array_equal(one.positions, other.positions)
        assert one.optional.keys() == other.optional.keys()
        for name in one.optional:
            np.testing.assert_array_equal(one.optional[name], other.optional[name])
        for name in ("posture", "dt", "seed", "settings", "versions"):
            assert getattr(one, name) == getattr(other, name)


def test_actions_are_the_next_positions():
    (one,) = recorded()
    np.testing.assert_array_equal(actions(one)[:-1], one.positions[1:])
    seen = observations(one)
    assert {name: array.shape[1] for name, array in seen.items() if name in OBSERVED} == OBSERVED
    np.testing.assert_array_equal(
        seen["wrist_axes"][7].reshape(3, 3)[:, 0], one.frames.wrist.A[:, 0]
    )


def test_robomimic_reads_it(here):
    dataset = pytest.importorskip("robomimic.utils.dataset")
    from robomimic.utils.file_utils import get_env_metadata_from_dataset
    from robomimic.utils.obs_utils import initialize_obs_utils_with_obs_specs

    demonstrations = simulated()
    path = export(demonstrations, "robomimic")
    keys = [*OBSERVED]
    initialize_obs_utils_with_obs_specs({"obs": {"low_dim": keys}})
    data = dataset.SequenceDataset(path, keys, ["actions", "rewards", "dones"], seq_length=5)
    assert len(data) == sum(len(one.positions) for one in demonstrations)
    np.testing.assert_allclose(data[3]["actions"], actions(demonstrations[0])[3:8])
    np.testing.assert_allclose(
        data[3]["obs"]["gripper"], demonstrations[0].positions[3:8], atol=1e-6
    )
    assert get_env_metadata_from_dataset(path)["env_name"] == "dressing_sim/DressArm-v0"


def test_a_file_has_robomimics_form(here):
    with h5py.File(export(simulated(), "robomimic")) as file:
        assert json.loads(file["data"].attrs["env_args"])["type"] == 2
        assert file["data"].attrs["total"] == 81
        for group in file["data"].values():
            rows = group.attrs["num_samples"]
            parts = [group[name] for name in ("actions", "rewards", "dones", "states")]
            parts += [*group["obs"].values(), *group["next_obs"].values()]
            assert {len(part) for part in parts} == {rows}
            assert group["rewards"][()].sum() == group["dones"][()].sum() == 1
            np.testing.assert_array_equal(group["next_obs/gripper"][:-1], group["obs/gripper"][1:])


def test_minari_reads_it(here, monkeypatch):
    minari = pytest.importorskip("minari")
    demonstrations = simulated()
    os.makedirs("root/dressing-sim")
    save_demonstrations("d.h5", demonstrations)
    main(["export", "d.h5", "--to", "minari", "--out", "root/dressing-sim/case-a-v3"])
    monkeypatch.setenv("MINARI_DATASETS_PATH", str(here / "root"))
    data = minari.load_dataset("dressing-sim/case-a-v3")
    assert (data.total_episodes, data.total_steps) == (2, 79)
    assert "dressing-sim/case-a-v3" in minari.list_local_datasets()
    for episode, one in zip(data.iterate_episodes(), demonstrations, strict=True):
        np.testing.assert_array_equal(episode.observations["gripper"], one.positions)
        np.testing.assert_array_equal(episode.actions, one.positions[1:])
        assert data.observation_space.contains({k: v[0] for k, v in episode.observations.items()})
        assert episode.terminations[-1]
        assert episode.terminations.sum() == 1


def test_lerobot_reads_it(here):
    module = pytest.importorskip("lerobot.datasets.lerobot_dataset")
    demonstrations = simulated()
    data = module.LeRobotDataset("dressing-sim/set", root=export(demonstrations, "lerobot"))
    assert (data.num_episodes, data.num_frames, data.fps) == (2, 81, 50)
    row = data[45]
    np.testing.assert_allclose(row["observation.state"], demonstrations[1].positions[5])
    np.testing.assert_allclose(row["action"], demonstrations[1].positions[6])
    assert row["task"].startswith("Put the sleeve")
    assert not row["next.success"]
    assert data[39]["next.success"]


def test_lerobot_reads_pictures_without_loss(here, demonstration, opengl):
    module = pytest.importorskip("lerobot.datasets.lerobot_dataset")
    begun = demonstration.positions[:5], demonstration.commands[:5]
    short = replace(demonstration, positions=begun[0], commands=begun[1], outcome=None)
    save_demonstrations("d.h5", [short])
    size = "--width", "64", "--height", "48"
    main(["export", "d.h5", "--to", "lerobot", "--out", "set", "--cameras", "front,side", *size])
    data = module.LeRobotDataset("dressing-sim/set", root="set")
    assert data.meta.camera_keys == ["observation.images.front", "observation.images.side"]
    for row, seen in enumerate(pictures(short, Cameras(("front", "side"), 64, 48))):
        for camera, picture in seen.items():
            read = data[row][f"observation.images.{camera}"].numpy().transpose(1, 2, 0)
            np.testing.assert_array_equal(np.round(255 * read), picture)
    main(["import", "set", "--out", "again.h5"])
    (again,) = load_demonstrations("again.h5")
    np.testing.assert_array_equal(again.positions, short.positions)
    np.testing.assert_array_equal(again.commands, short.commands)


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (["minari", "--cameras", "front"], "valid is --to lerobot"),
        (["lerobot", "--cameras", "top"], "cameras must be one of front, close"),
        (["lerobot", "--cameras", "front", "--width", "0"], "cameras: width is 0"),
    ],
)
def test_pictures_that_cannot_be_had_are_refused_in_one_line(options, told, here, capsys):
    save_demonstrations("d.h5", simulated())
    with pytest.raises(SystemExit) as stopped:
        main(["export", "d.h5", "--out", "set", "--to", *options])
    assert stopped.value.code == 2
    assert told in capsys.readouterr().err
    assert not (here / "set").exists()


@pytest.mark.parametrize("to", OUT)
def test_nothing_is_replaced_and_nothing_half_written(to, here, capsys):
    path = here / export(simulated(), to)
    before = sorted(here.rglob("*"))
    with pytest.raises(SystemExit) as stopped:
        main(["export", "d.h5", "--to", to, "--out", path.name])
    assert stopped.value.code == 2
    assert "is there already" in (told := capsys.readouterr().err) or "is a folder" in told
    assert sorted(here.rglob("*")) == before


def test_demonstrations_of_two_kinds_are_one_robomimic_file_but_no_other(here):
    save_demonstrations("d.h5", [*simulated(), *recorded()])
    main(["export", "d.h5", "--to", "robomimic", "--out", "r.hdf5"])
    assert len(read_source(here / "r.hdf5")) == 3
    pytest.importorskip("minari")
    with pytest.raises(SystemExit):
        main(["export", "d.h5", "--to", "minari", "--out", "set-v0"])
    assert sorted(one.name for one in here.iterdir()) == ["d.h5", "r.hdf5"]


def test_a_file_of_others_with_our_observations_is_a_recording(here):
    (one,) = recorded()
    path = here / export([one], "robomimic")
    with h5py.File(path, "r+") as file:
        del file["data/demo_0"].attrs["dressing_sim"]
    (again,) = read_source(path)
    np.testing.assert_allclose(again.positions, one.positions, atol=1e-9)
    np.testing.assert_allclose(again.posture.elbow, one.posture.elbow, atol=1e-6)


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (lambda f: f.move("data", "date"), "no /data"),
        (lambda f: f["data"].move("demo_0", "demo"), "demo_0|first"),
        (lambda f: f["data/demo_0/obs"].move("gripper", "eef"), "no observation gripper"),
        (lambda f: f["data/demo_0"].move("obs", "seen"), "no /data/demo_0/obs"),
        (lambda f: f["data/demo_0"].attrs.modify("dressing_sim", b"{"), "not JSON"),
        (lambda f: f["data/demo_0"].attrs.modify("dressing_sim", b"[]"), "description is"),
        (lambda f: f["data/demo_0/obs/wrist_position"].write_direct(np.zeros((40, 3))), "off that"),
        (lambda f: f["data/demo_0/obs/gripper"].write_direct(np.full((40, 3), np.nan)), "finite"),
    ],
)
def test_damage_is_named_in_one_line(change, told, here):
    path = here / export(simulated()[:1], "robomimic")
    with h5py.File(path, "r+") as file:
        change(file)
    with pytest.raises(InvalidInputError, match=told) as refused:
        read_source(path)
    assert "\n" not in str(refused.value)


def test_an_extra_that_is_not_there_is_named(here, monkeypatch, capsys):
    import sys

    monkeypatch.setitem(sys.modules, "minari", None)
    save_demonstrations("d.h5", simulated())
    with pytest.raises(SystemExit):
        main(["export", "d.h5", "--to", "minari", "--out", "set-v0"])
    assert "pip install 'dressing-sim[minari]'" in capsys.readouterr().err


def test_damaged_folders_are_named_in_one_line(here):
    path = here / export(simulated(), "minari")
    (path / "data" / "main_data.hdf5").write_bytes(b"no HDF5")
    with pytest.raises(InvalidInputError, match="Minari") as refused:
        read_source(path)
    assert "\n" not in str(refused.value)
    (path / "data" / "metadata.json").write_text("{")
    with pytest.raises(InvalidInputError, match="Minari"):
        read_source(path)
