import json

import numpy as np
import pytest
from lab_recordings import TURN_DEG, columns, write_csv

from dressing_sim.cli import main
from dressing_sim.datasets.tables import read_table
from dressing_sim.episode.demonstration import load_demonstrations
from dressing_sim.errors import InvalidInputError

FIELDS = ("times", "gripper", "shoulder", "elbow", "wrist", "quaternion", "force")


def same(one, other):
    for name in FIELDS:
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=0, atol=1e-9)


@pytest.mark.parametrize(("length", "time"), [("m", "s"), ("mm", "ms"), ("cm", "s")])
def test_csv_and_npz_say_the_same_in_any_unit(length, time, tmp_path):
    values = columns()
    table = read_table(write_csv(tmp_path / "a.csv", values, length, time))
    arrays = {"time_s": values["time"], "force_n": values["force"], "unknown": np.array("x")}
    arrays |= {f"{name}_m": values[name] for name in ("gripper", "shoulder", "elbow", "wrist")}
    np.savez(tmp_path / "a.npz", quaternion=values["quaternion"], **arrays)
    same(table, read_table(tmp_path / "a.npz"))
    assert table.name == "a"


def test_nanoseconds_since_1970_keep_their_digits(tmp_path):
    values = columns()
    ticks = 1_764_000_000_000_000_000 + np.round(1e9 * values["time"]).astype(np.int64)
    arrays = {f"{name}_m": values[name] for name in ("gripper", "shoulder", "elbow", "wrist")}
    np.savez(tmp_path / "a.npz", time_ns=ticks, **arrays)
    times = read_table(tmp_path / "a.npz").times
    np.testing.assert_allclose(times, values["time"] - values["time"][0], atol=2e-9)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("time_s", "time", "'time' names no unit that is known; valid is time_s, time_ms"),
        ("time_s", "time_h", "'time_h' names no unit"),
        ("gripper_x_mm", "gripper_x", "no column gripper_y; valid is gripper_x, gripper_y"),
        ("gripper_y_mm", "gripper_y_m", "no column gripper_y_mm"),
        ("force_x_n", "force_x_lbf", "no column force_y_lbf"),
        ("shoulder_x_mm", "x", "no shoulder"),
        ("time_s", "gripper_x_mm", "another name for each column"),
        ("\n", "\nabc", "'time_s' in row 0 is 'abc"),
        ("\n", "\n1,2\n", "in row 0 is ''"),
    ],
)
def test_units_and_names_are_checked(old, new, told, tmp_path):
    file = write_csv(tmp_path / "a.csv", columns())
    file.write_text(file.read_text().replace(old, new, 1))
    with pytest.raises(InvalidInputError, match=told) as refused:
        read_table(file)
    assert "\n" not in str(refused.value)
    assert str(refused.value).startswith(str(file))


@pytest.mark.parametrize(
    "content", [b"", b"\xff\xfe\x00", b"time_s\n", b'"' * 200000, b"a,b\n\0,1"]
)
def test_what_is_no_table_is_refused(content, tmp_path):
    (tmp_path / "a.csv").write_bytes(content)
    with pytest.raises(InvalidInputError):
        read_table(tmp_path / "a.csv")


def test_the_command_writes_a_file_that_learn_takes(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for seed in range(2):
        write_csv(tmp_path / f"{seed}.csv", columns(seed))
    line = ["import", "0.csv", "1.csv", "--turn-deg", str(-TURN_DEG), "--out", "mine.h5", "--json"]
    main(line)
    told = json.loads(capsys.readouterr().out)
    assert [one["posture"]["name"] for one in told["demonstrations"]] == ["0", "1"]
    assert told["demonstrations"][0]["has"] == ["positions", "orientations", "forces"]
    assert len(load_demonstrations("mine.h5")) == 2
    main(["learn", "mine.h5", "--out", "p.npz"])
    assert (tmp_path / "p.npz").is_file()


@pytest.mark.parametrize(
    ("line", "told"),
    [
        (["0.csv", "--max-gap", "0.0001", "--out", "o.h5"], "0.csv: nothing for"),
        (["nothing.csv", "--out", "o.h5"], "nothing that can be imported"),
        (["0.csv", "--out", "0.csv", "--force"], "is read as well"),
        (["0.csv", "--dt", "0", "--out", "o.h5"], "dt"),
        (["0.csv", "--person", "nobody", "--out", "o.h5"], "unknown person"),
        ([".", "--out", "o.h5"], "nothing that can be imported"),
    ],
)
def test_the_command_ends_with_one_line_and_writes_nothing(
    line, told, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    content = write_csv(tmp_path / "0.csv", columns(turn_deg=120.0)).read_bytes()
    with pytest.raises(SystemExit) as stopped:
        main(["import", *line])
    error = capsys.readouterr().err
    assert (stopped.value.code, error.count("\n")) == (2, 1), error
    assert told in error
    assert {one.name for one in tmp_path.iterdir()} == {"0.csv"}
    assert (tmp_path / "0.csv").read_bytes() == content
