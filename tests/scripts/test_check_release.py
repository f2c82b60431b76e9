import shutil
import sys
from pathlib import Path

import pytest
from check_release import VERSIONS, faults_of_texts, faults_of_wheel, versions

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def copy(tmp_path):
    """The files that name a version, with one section in the changelog."""
    for name in VERSIONS:
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    version = versions(ROOT)["pyproject.toml"]
    (tmp_path / "CHANGELOG.md").write_text(f"# Changelog\n\n## {version} - 2026-01-31\n")
    return tmp_path


def test_the_version_is_the_same_everywhere():
    assert len(set(versions(ROOT).values())) == 1


def test_nothing_is_wrong_where_all_is_said(copy):
    assert list(faults_of_texts(copy)) == []


@pytest.mark.parametrize("name", VERSIONS)
def test_another_version_in_any_file_is_told(copy, name):
    version = versions(ROOT)[name]
    text = (copy / name).read_text().replace(version, "9.9.9", 1)
    (copy / name).write_text(text)
    faults = list(faults_of_texts(copy))
    assert f"{name} says 9.9.9" in faults[0]


@pytest.mark.parametrize("changes", ["## Unreleased\n", "## 9.9.9 - 2026-01-31\n"])
def test_a_changelog_without_the_version_is_told(copy, changes):
    (copy / "CHANGELOG.md").write_text(changes)
    (fault,) = faults_of_texts(copy)
    assert "YYYY-MM-DD" in fault


def test_a_python_that_is_not_there_is_told(tmp_path):
    (fault,) = faults_of_wheel("none.whl", "no-such-python", tmp_path)
    assert "there is no no-such-python" in fault


def test_a_wheel_that_does_not_install_is_told(tmp_path):
    (fault,) = faults_of_wheel(str(tmp_path / "none.whl"), sys.executable, tmp_path)
    assert "-m pip install" in fault
