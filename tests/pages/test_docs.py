"""What the pages say is what the runs gave."""

import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PAGES = ("README.md", *(f"docs/{path.name}" for path in sorted((ROOT / "docs").glob("*.md"))))


def test_the_tables_are_those_of_the_measured_runs():
    script = ROOT / "scripts" / "fill_tables.py"
    done = subprocess.run(
        [sys.executable, script, "--check"], capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("page", PAGES)
def test_links_and_pictures_exist(page):
    path = ROOT / page
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", path.read_text(encoding="utf-8")):
        assert (path.parent / target).is_file(), target


@pytest.mark.parametrize("path", sorted((ROOT / "docs" / "results").glob("*.json")))
def test_a_measured_run_names_its_versions_but_no_machine(path):
    text = path.read_text(encoding="utf-8")
    assert json.loads(text)
    assert not re.search(r"/(home|root|tmp|work)/", text)


@pytest.mark.parametrize("page", PAGES)
def test_files_that_are_named_exist(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    folders = "tests|scripts|examples|docs|benchmarks|assets"
    for name in re.findall(rf"(?<![\w/.])((?:{folders}|dressing_sim)/[\w./*-]+\.\w+)", text):
        assert list(ROOT.glob(name)), name
