import json
import subprocess
import sys

import h5py
import numpy as np
import pytest
from learning_tasks import reaching_demonstrations

from dressing_sim import __version__, provenance
from dressing_sim.cli import main
from dressing_sim.episode.demonstration import save_demonstrations
from dressing_sim.learning import TPGMM, save_model
from dressing_sim.provenance import source_hash, versions

KEYS = ["version", "commit", "python", "versions", "numerics"]


def git(folder, *arguments):
    who = ("-c", "user.name=a", "-c", "user.email=a@b.c")
    told = subprocess.run(
        ["git", *who, *arguments], cwd=folder, check=True, capture_output=True, text=True
    )
    return told.stdout.strip()


@pytest.fixture
def checkout(tmp_path):
    folder = tmp_path / "checkout"
    folder.mkdir()
    git(folder, "init", "-q")
    git(folder, "commit", "-q", "--allow-empty", "-m", "first")
    return folder


def test_everything_that_numbers_depend_on_is_said():
    said = provenance.provenance()
    assert list(said) == KEYS
    assert said["version"] == __version__
    assert said["versions"].items() >= versions().items()
    assert said["versions"]["numba"]
    assert len(said["numerics"]["fingerprint"]) == 12
    assert provenance.provenance({"mine": "abc"})["sources"] == {"mine": "abc"}
    assert json.loads(json.dumps(said)) == said


def test_the_commit_is_read_without_git(checkout, monkeypatch):
    expected = git(checkout, "rev-parse", "HEAD")
    monkeypatch.setenv("PATH", "")
    assert provenance._checked_out(checkout / ".git") == expected


@pytest.mark.parametrize("state", ["packed", "detached", "worktree", "packed worktree"])
def test_the_commit_is_found_however_git_keeps_it(checkout, state):
    expected, folder = git(checkout, "rev-parse", "HEAD"), checkout
    if "worktree" in state:
        folder = checkout.parent / "other"
        git(checkout, "worktree", "add", "-q", "-b", "more", str(folder))
    if "packed" in state:
        git(folder, "pack-refs", "--all")
    if state == "detached":
        git(folder, "checkout", "-q", "--detach")
    assert provenance._checked_out(folder / ".git") == expected


def test_where_there_is_no_repository_there_is_no_commit(tmp_path, checkout):
    assert provenance._checked_out(tmp_path / ".git") is None
    empty = tmp_path / "empty"
    empty.mkdir()
    git(empty, "init", "-q")
    assert provenance._checked_out(empty / ".git") is None


@pytest.fixture
def others(tmp_path):
    """A folder with a module and a package of other people."""
    (tmp_path / "a_package").mkdir()
    files = {
        "a_module.py": "class Mine: pass\n",
        "a_package/__init__.py": "",
        "a_package/policy.py": "class Mine: pass\n",
        "a_package/helper.py": "ONE = 1\n",
    }
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    return tmp_path


@pytest.mark.parametrize(
    ("module", "own", "foreign"),
    [
        ("a_module", "a_module.py", "a_package/helper.py"),
        ("a_package.policy", "a_package/helper.py", "a_module.py"),
    ],
)
def test_a_source_s_hash_is_that_of_all_its_code_and_no_other(others, module, own, foreign):
    def hashed():
        code = f"from {module} import Mine; from dressing_sim.provenance import source_hash as h; "
        told = subprocess.run(
            [sys.executable, "-c", f"import sys; sys.path.insert(0, '.'); {code}print(h(Mine))"],
            cwd=others,
            capture_output=True,
            text=True,
            check=True,
        )
        return told.stdout.strip()

    before = hashed()
    assert len(before) == 64
    (others / foreign).write_text("other = 2\n")
    assert hashed() == before
    (others / own).write_text("class Mine: new = 1\n")
    assert hashed() != before


def test_what_has_no_source_has_no_hash():
    assert source_hash(len) is None


def test_a_file_of_demonstrations_says_where_it_is_from(demonstration, tmp_path):
    save_demonstrations(tmp_path / "one.h5", [demonstration])
    with h5py.File(tmp_path / "one.h5") as file:
        assert json.loads(file.attrs["provenance"]) == provenance.provenance()


def test_a_saved_model_says_where_it_is_from(tmp_path):
    save_model(TPGMM(2).fit(reaching_demonstrations(3)), tmp_path / "model.npz")
    with np.load(tmp_path / "model.npz", allow_pickle=False) as archive:
        assert json.loads(str(archive["header"]))["provenance"] == provenance.provenance()


def test_the_planar_study_says_where_it_is_from(tmp_path, capsys):
    main(["planar", "--runs", "1", "--method", "rf", "--max-iterations", "1", "--json"])
    assert list(json.loads(capsys.readouterr().out)["provenance"]) == KEYS
