"""The package to copy: installed, tested by its own tests, and with a row of its own."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from dressing_sim.episode.demonstration import save_demonstrations

pytest.importorskip("hatchling")
PACKAGE = Path(__file__).resolve().parents[2] / "examples" / "policy_package"
HERE = str(Path(__file__).resolve().parents[2])


@pytest.fixture(scope="module")
def installed(tmp_path_factory):
    """Where a copy of the package was installed to, and the copy."""
    folder = tmp_path_factory.mktemp("package")
    copy, target = folder / "my_policy", folder / "installed"
    for file in PACKAGE.rglob("*.*"):
        if file.suffix in (".py", ".toml", ".md"):
            kept = copy / file.relative_to(PACKAGE)
            kept.parent.mkdir(parents=True, exist_ok=True)
            kept.write_bytes(file.read_bytes())
    pip = [sys.executable, "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    options = ["--no-deps", "--no-build-isolation", "--no-index", "--target", str(target)]
    done = subprocess.run([*pip, *options, str(copy)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return target, copy


def run(installed, folder, *arguments):
    path = os.pathsep.join([str(installed[0]), HERE])
    done = subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=folder,
        env={**os.environ, "PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_its_own_tests_pass(installed):
    out = run(installed, installed[1], "pytest", "-q", "-p", "no:cacheprovider")
    assert "4 passed" in out


def test_it_has_a_row_of_its_own(installed, tmp_path, posture, demonstration):
    save_demonstrations(tmp_path / "mine.h5", [demonstration])
    (tmp_path / "one.json").write_text(json.dumps({"postures": [posture.to_dict()]}))
    evaluate = "dressing_sim evaluate --suite one.json --demonstrations mine.h5 --workers 1"
    more = "--policies blended-frames?samples=150 --out out --no-pictures"
    run(installed, tmp_path, *evaluate.split(), *more.split())
    (row,) = json.loads((tmp_path / "out" / "summary.json").read_text())["rows"]
    assert row["policy"] == "blended-frames?samples=150"
    assert row["n_episodes"] == 1
    assert not {"policy_error", "ik_unreachable"} & set(row["failures"])


def test_its_readme_names_what_there_is():
    text = (PACKAGE / "README.md").read_text(encoding="utf-8")
    assert "--policies blended-frames,default --suite random:5" in text
    assert "blended-frames?samples=100" in text
    assert 'blended-frames = "blended_frames:BlendedFrames"' in (
        PACKAGE / "pyproject.toml"
    ).read_text(encoding="utf-8")
