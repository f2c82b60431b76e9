import contextlib
import os
import stat
import subprocess
import sys

import pytest

from dressing_sim.errors import InvalidInputError
from dressing_sim.files import check_writable, is_file, replacing, write_file


def test_a_file_is_written_with_its_folders(tmp_path):
    target = tmp_path / "a" / "b" / "text.txt"
    write_file(target, "grüezi\n")
    assert target.read_text(encoding="utf-8") == "grüezi\n"
    assert list(target.parent.iterdir()) == [target]


def test_the_old_file_is_there_until_the_new_one_is_whole(tmp_path):
    target = tmp_path / "text.txt"
    target.write_text("old")
    with replacing(target) as temporary:
        temporary.write_text("new")
        assert target.read_text() == "old"
        assert temporary.suffix == target.suffix
    assert target.read_text() == "new"


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_after_an_error_the_old_file_is_left_and_nothing_else(tmp_path, error):
    target = tmp_path / "text.txt"
    target.write_text("old")

    def fail():
        with replacing(target) as temporary:
            temporary.write_text("half")
            raise error

    with pytest.raises(error):
        fail()
    assert target.read_text() == "old"
    assert list(tmp_path.iterdir()) == [target]


def test_a_file_is_as_readable_as_any_new_one(tmp_path):
    other = tmp_path / "other.txt"
    other.touch()
    write_file(tmp_path / "text.txt", "")
    mode = os.stat(tmp_path / "text.txt").st_mode
    assert stat.S_IMODE(mode) == stat.S_IMODE(os.stat(other).st_mode)


def test_a_place_that_cannot_be_written_is_an_error_that_names_it(tmp_path):
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    for target in (tmp_path / "file" / "text.txt", tmp_path / "folder"):
        with pytest.raises(InvalidInputError, match=str(target)):
            write_file(target, "text")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["file", "folder"]


@pytest.mark.parametrize("name", ["x" * 300, "x" * 300 + "/file"])
def test_a_name_that_no_file_can_have_is_an_error_and_not_a_file(tmp_path, name):
    with pytest.raises(InvalidInputError, match="cannot be written"):
        check_writable(tmp_path / name)
    assert not is_file(tmp_path / name)


@pytest.mark.parametrize("write", [check_writable, lambda name: write_file(name, "text")])
@pytest.mark.parametrize("name", ["", "a\0b", "missing/../kept.txt", "kept.txt/../../kept.txt"])
def test_no_name_leads_to_another_file_once_its_folders_are_made(tmp_path, write, name):
    kept = tmp_path / "kept.txt"
    kept.write_text("mine")
    with contextlib.chdir(tmp_path), pytest.raises(InvalidInputError, match="cannot be written"):
        write(name)
    assert kept.read_text() == "mine"
    assert [path.name for path in tmp_path.iterdir()] == ["kept.txt"]


def test_a_full_disk_is_an_error_that_names_the_file_and_leaves_the_old_one(tmp_path):
    code = (
        "import resource, signal, sys; from dressing_sim.files import write_file;"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000));"
        "write_file(sys.argv[1], 'x' * 100000)"
    )
    path = tmp_path / "some.txt"
    path.write_text("old")
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=False
    )
    assert "InvalidInputError" in done.stderr
    assert "some.txt: cannot be written" in done.stderr
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
