"""Files from elsewhere: their sizes are known before anything is read."""

import json
import os
import tracemalloc
import zipfile

import h5py
import numpy as np
import pytest
from numpy.lib import format as npy
from scipy.io import savemat

from dressing_sim.archives import read_json, read_npz, to_json
from dressing_sim.arm import Posture
from dressing_sim.episode.demonstration import (
    Demonstration,
    load_demonstrations,
    save_demonstrations,
)
from dressing_sim.errors import InvalidInputError
from dressing_sim.learning import TrajectoryTPGMM, load_model, save_model
from dressing_sim.planar import files, matlab
from dressing_sim.planar.generator import generate
from dressing_sim.suites.suites import load_suite

DATA = generate(0)
LINE = np.linspace([0.3, 0.0, 0.5], [0.5, -0.2, 0.4], 20)
PLANAR = {
    "t": np.arange(200) * 0.01,
    "xy": np.array([d.positions for d in DATA.training]),
    "A": np.array([[f.A for f in d.frames] for d in DATA.training]),
    "b": np.array([[f.b for f in d.frames] for d in DATA.training]),
}


def one_line(error):
    message = str(error.value)
    assert "\n" not in message
    return message


def refused(read, path, part):
    """Refused in a line that names the file, without memory for what it asks for."""
    tracemalloc.start()
    try:
        with pytest.raises(InvalidInputError) as caught:
            read(path)
        assert tracemalloc.get_traced_memory()[1] < 32 * 2**20
    finally:
        tracemalloc.stop()
    assert str(path) in one_line(caught)
    assert part in one_line(caught)


def header(shape, kind="<f8"):
    """An array's file that has a header and no numbers."""
    from io import BytesIO

    stream = BytesIO()
    npy.write_array_header_1_0(
        stream, {"descr": kind, "fortran_order": False, "shape": tuple(shape)}
    )
    return stream.getvalue()


def packed(path, **members):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in members.items():
            archive.writestr(f"{name}.npy", content)
    return path


@pytest.mark.parametrize("read", [files.load, load_model, read_npz])
@pytest.mark.parametrize(
    ("content", "part"),
    [
        (header((10**6, 10**6)), "(1000000, 1000000)"),
        (header((10**12, 10**12, 10**12)), "bytes"),
        (header((-5,)), "array 't'"),
        (b"\x93NUMPY\x01\x00" + b"\xff\xff" + b"(" * 65535, "header"),
        (b"\x93NUMPY\x02\x00" + b"\xff\xff\xff\x7f" + b" ", "header"),
        (b"\x93NUMPY\x03\x00" + bytes(100), "version (3, 0)"),
        (b"\x93NUMPY\x01\x00\x0c\x00{'descr': (\n", "header"),
        (b"nothing of the kind", "header"),
        (b"", "header"),
        (header((1,), "|O") + bytes(8), "valid are numbers"),
    ],
)
def test_a_header_that_asks_for_too_much_is_refused(tmp_path, read, content, part):
    refused(read, packed(tmp_path / "bad.npz", t=content, xy=b"", A=b"", b=b""), part)


@pytest.mark.parametrize("read", [files.load, load_model, read_npz])
def test_an_archive_that_unpacks_to_too_much_is_refused(tmp_path, read):
    bomb = header((300, 2**20), "|u1") + bytes(300 * 2**20)
    path = packed(tmp_path / "bomb.npz", t=bomb)
    del bomb
    assert path.stat().st_size < 2**20
    refused(read, path, "valid is at most")


@pytest.mark.parametrize("changed", [0xFF, 0x80, 0x0E, 0x00])
def test_whatever_byte_of_an_archive_is_changed_it_is_read_or_refused(tmp_path, changed):
    path = packed(tmp_path / "some.npz", t=header((4,)) + bytes(32), xy=header((2,)) + bytes(16))
    sound = path.read_bytes()
    told = []
    for place in range(len(sound)):
        path.write_bytes(sound[:place] + bytes([sound[place] ^ changed]) + sound[place + 1 :])
        try:
            read_npz(path)
        except InvalidInputError as error:
            told.append(str(error))
    assert bool(told) == (changed > 0)
    assert not any("\n" in one for one in told)


def test_a_name_that_is_no_text_is_damage(tmp_path):
    path = packed(tmp_path / "some.npz", name=header((4,)) + bytes(32))
    content = bytearray(path.read_bytes())
    directory = content.rfind(b"PK\x01\x02")
    content[directory + 9] |= 0x08  # the name is UTF-8, it says
    content[directory + 46] = 0xFB
    path.write_bytes(content)
    refused(read_npz, path, "damaged")


def test_an_encrypted_and_a_damaged_archive_are_refused(tmp_path):
    path = packed(tmp_path / "some.npz", t=header((4,)) + bytes(32))
    content = bytearray(path.read_bytes())
    content[6] |= 1  # encrypted, it says
    content[content.rfind(b"PK\x01\x02") + 8] |= 1
    path.write_bytes(content)
    refused(read_npz, path, "damaged")
    np.savez(path, t=np.arange(1000.0))
    content = bytearray(path.read_bytes())
    content[600] ^= 255
    path.write_bytes(content)
    refused(read_npz, path, "damaged")


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"t": None}, "no array t"),
        ({"A": None}, "no array A"),
        ({"t": PLANAR["t"][::-1]}, "times do not increase"),
        ({"t": PLANAR["t"] * 0}, "times do not increase"),
        ({"t": PLANAR["t"] * 1j}, "t has complex"),
        ({"t": PLANAR["t"][:50]}, "t has 50 times where xy has 200"),
        ({"t": np.array([])}, "t"),
        ({"t": np.array("now")}, "'now'"),
        ({"xy": PLANAR["xy"].transpose(0, 2, 1)}, "xy has shape (3, 2, 200)"),
        ({"xy": PLANAR["xy"] + 1j}, "xy has complex"),
        ({"xy": PLANAR["xy"] * np.nan}, "not finite"),
        ({"xy": PLANAR["xy"] * 1e200}, "as large as"),
        ({"xy": PLANAR["xy"][:0]}, "with M of 1 or more"),
        ({"A": PLANAR["A"][:, :1]}, "A has 1 frames and b has 2"),
        ({"b": PLANAR["b"][:2]}, "b has shape (2, 2, 2)"),
        ({"validation_xy": PLANAR["xy"]}, "no array validation_A"),
    ],
)
def test_planar_demonstrations_that_cannot_be_are_named(tmp_path, change, part):
    arrays = {name: array for name, array in {**PLANAR, **change}.items() if array is not None}
    np.savez(tmp_path / "planar.npz", **arrays)
    refused(files.load, tmp_path / "planar.npz", part)


def structs(**change):
    entries = []
    for d in DATA.training:
        frames = np.empty(2, dtype=[("A", object), ("b", object)])
        frames[:] = [(np.eye(3), np.zeros(3))] * 2
        entries.append((frames, np.vstack([PLANAR["t"], d.positions.T])))
    s = np.empty(3, dtype=[("p", object), ("Data0", object)])
    s[:] = entries
    for name, value in change.items():
        s[name][0] = value
    return s


@pytest.mark.parametrize(
    ("contents", "part"),
    [
        ({"other": 3.0}, "no array s"),
        ({"s": 3.0}, "no array s of structs"),
        ({"s": np.array([(1.0,)], dtype=[("p", object)])}, "s(1) has no field Data0"),
        ({"s": structs(Data0=np.zeros((200, 3)))}, "s(1).Data0 has shape (200, 3) (is it transp"),
        ({"s": structs(Data0=np.full((3, 200), np.nan))}, "not finite"),
        ({"s": structs(Data0=np.full((3, 200), 1j))}, "complex"),
        ({"s": structs(p=5.0)}, "s(1).p has no field A"),
    ],
)
def test_a_mat_file_of_another_layout_is_named(tmp_path, contents, part):
    savemat(tmp_path / "s.mat", contents)
    refused(files.load, tmp_path / "s.mat", part)


def test_a_mat_file_that_unpacks_to_too_much_or_is_another_version_is_refused(
    tmp_path, monkeypatch
):
    path = tmp_path / "s.mat"
    savemat(path, {"s": structs(Data0=np.zeros((3, 10**6)))}, do_compression=True)
    assert path.stat().st_size < 2**20
    monkeypatch.setattr(matlab, "MOST_BYTES", 2**20)
    refused(files.load, path, "once it is unpacked")
    savemat(path, {"s": 3.0}, format="4")
    refused(files.load, path, "not a file of MATLAB, version 5 to 7")
    with h5py.File(path, "w") as file:
        file["s"] = 3.0
    refused(files.load, path, "MATLAB 7.3")


@pytest.fixture
def recorded(tmp_path):
    path = tmp_path / "some.h5"
    posture = Posture("arm", 70, 20, 30, 40)
    save_demonstrations(path, [Demonstration(LINE, 0.1, posture, 0, np.zeros((20, 7)))])
    return path


def bomb(file):
    del file["0/positions"]
    file.create_dataset("0/positions", (10**10, 3), "f8", compression="gzip", chunks=(1000, 3))


def complex_positions(file):
    del file["0/positions"]
    file["0/positions"] = LINE + 0j


def elsewhere(file):
    del file["0/positions"]
    file["0/positions"] = h5py.ExternalLink("/etc/passwd", "/")


def transposed(file):
    del file["0/positions"]
    file["0/positions"] = LINE.T


def without(name):
    def change(file):
        del file["0"].attrs[name]

    change.__name__ = f"without_{name}"
    return change


@pytest.mark.parametrize(
    ("change", "part"),
    [
        (bomb, "/0/positions has shape (10000000000, 3)"),
        (complex_positions, "real numbers"),
        (elsewhere, "/0/positions is a link"),
        (transposed, "(is it transposed?)"),
        (lambda file: file.pop("0/positions"), "no /0/positions"),
        (without("dt"), "no attribute dt of /0"),
        (without("posture"), "no attribute posture of /0"),
        (without("sha256"), "no attribute sha256 of /0"),
        (lambda file: file.attrs.pop("format_version"), "no attribute format_version"),
        (lambda file: file.attrs.update(format_version=9), "of a newer dressing_sim"),
        (lambda file: file["0"].attrs.update(dt=[0.1, 0.2]), "dt is array"),
        (lambda file: file["0"].attrs.update(posture="[" * 9999), "posture of /0 is not JSON"),
    ],
)
def test_a_file_of_demonstrations_says_what_is_wrong_and_is_not_called_damaged(
    recorded, change, part
):
    with h5py.File(recorded, "a") as file:
        change(file)
    refused(load_demonstrations, recorded, part)
    with pytest.raises(InvalidInputError) as caught:
        load_demonstrations(recorded)
    assert "damaged" not in str(caught.value)


def test_a_locked_file_is_called_locked(recorded):
    with h5py.File(recorded, "a"):
        import subprocess
        import sys

        code = (
            "import sys; from dressing_sim import load_demonstrations\n"
            "try: load_demonstrations(sys.argv[1])\n"
            "except ValueError as error: print(error)"
        )
        run = subprocess.run(
            [sys.executable, "-c", code, str(recorded)], capture_output=True, text=True, check=True
        )
    assert "locked by another process" in run.stdout
    assert run.stdout.count("\n") == 1


@pytest.mark.skipif(os.name == "nt" or os.geteuid() == 0, reason="root may read everything")
def test_a_file_that_is_closed_to_us_is_called_that(recorded):
    recorded.chmod(0)
    refused(load_demonstrations, recorded, "permission denied")


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"header": None}, "no array header"),
        ({"means": None}, "it has no 'means'"),
        ({"means": 1j}, "means of the mixture has complex"),
        ({"end_means": np.zeros((1, 3))}, "different shapes"),
        ({"priors": np.ones((2, 2))}, "mixture"),
    ],
)
def test_a_saved_model_without_or_with_another_array_is_named(tmp_path, change, part):
    from learning_tasks import reaching_demonstrations

    path = save_model(TrajectoryTPGMM().fit(reaching_demonstrations(3)), tmp_path / "policy.npz")
    arrays = read_npz(path)
    for name, value in change.items():
        arrays[name] = arrays[name] * value if isinstance(value, complex) else value
    np.savez(path, **{name: array for name, array in arrays.items() if array is not None})
    refused(load_model, path, part)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"version": None}, "no version"),
        ({"version": 2}, "of a newer dressing_sim"),
        ({"settings": []}, "no settings"),
        ({"kind": 5}, "no kind"),
        ({"format": "x" * 5000}, "has format"),
    ],
)
def test_a_saved_model_with_another_header_is_named(tmp_path, change, part):
    values = {"format": "dressing_sim.learning", "version": 1, "kind": "tpgmm", "settings": {}}
    np.savez(tmp_path / "model.npz", header=np.array(json.dumps(values | change)))
    refused(load_model, tmp_path / "model.npz", part)


@pytest.mark.parametrize(
    ("content", "part"),
    [
        ("[" * 100_000, "nested too deeply"),
        ("{", "not JSON"),
        (b"\xff\xfe", "not JSON"),
        ("9" * 5000, "not JSON"),
        ({"postures": [{"name": "a", "flexion_deg": 1e200}]}, "missing"),
        ({"posture": []}, "no postures"),
        ({"postures": [], "colour": 3}, "no postures"),
    ],
)
def test_a_suite_that_is_none_is_named(tmp_path, content, part):
    path = tmp_path / "suite.json"
    if isinstance(content, bytes):
        path.write_bytes(content)
    else:
        path.write_text(content if isinstance(content, str) else json.dumps(content))
    with pytest.raises(InvalidInputError) as caught:
        load_suite(str(path))
    assert part in one_line(caught)


@pytest.mark.parametrize(
    ("change", "part"),
    [
        ({"colour": "red"}, "unknown key 'colour'; valid are description"),
        ({"name": ""}, "name is ''"),
        ({"name": "x" * 5000}, "(5000 letters)"),
        ({"name": "a\x1bb"}, "printable"),
        ({"postures": [Posture("a\nb", 70, 20, 30, 40).to_dict()]}, "printable"),
        ({"postures": [Posture("", 70, 20, 30, 40).to_dict()]}, "the name of a posture is ''"),
        ({"postures": [Posture("y" * 5000, 70, 20, 30, 40).to_dict()]}, "(5000 letters)"),
    ],
)
def test_names_and_keys_of_a_suite_are_checked(tmp_path, change, part):
    path = tmp_path / "suite.json"
    good = {"postures": [Posture("arm", 70, 20, 30, 40).to_dict()]}
    path.write_text(json.dumps(good))
    assert len(load_suite(str(path))) == 1
    path.write_text(json.dumps(good | change))
    with pytest.raises(InvalidInputError) as caught:
        load_suite(str(path))
    assert part in one_line(caught)
    assert str(caught.value).isprintable()


def test_a_json_file_that_is_too_large_is_not_read(tmp_path):
    path = tmp_path / "large.json"
    path.write_text("[]" + " " * 100)
    assert read_json(path) == []
    refused(lambda file: read_json(file, most=50), path, "valid is at most 50")


def test_json_has_no_infinite_numbers():
    assert json.loads(to_json({"a": 1.5}, "it")) == {"a": 1.5}
    for value in (np.inf, -np.inf, np.nan):
        with pytest.raises(InvalidInputError, match="it: a number is NaN or infinite"):
            to_json({"a": [value]}, "it")
