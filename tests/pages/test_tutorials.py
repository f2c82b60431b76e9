"""The tutorials do what they say: every block is run, in their order, in one folder."""

import os
import re
import subprocess
import sys
from doctest import ELLIPSIS, NORMALIZE_WHITESPACE, OutputChecker
from pathlib import Path
from typing import NamedTuple

import pytest

from dressing_sim.errors import DressingSimError
from dressing_sim.pictures.rendering import gl_backend

ROOT = Path(__file__).resolve().parents[2]
PAGES = sorted((ROOT / "docs").glob("tutorial-*.md"))

#: A block, the name of the file to save it in if the sentence before gives one, and what it prints.
BLOCK = re.compile(
    r"(?:as\s`(?P<file>[\w.]+)`:\n\n)?^```(?P<language>\w+)\n(?P<code>.*?)^```$"
    r"(?:\n\n^```text\n(?P<says>.*?)^```$)?",
    re.DOTALL | re.MULTILINE,
)


class Block(NamedTuple):
    """A fenced block of a page."""

    file: str | None
    language: str
    code: str
    says: str | None


def blocks_of(page: Path) -> list[Block]:
    return [Block(**one.groupdict()) for one in BLOCK.finditer(page.read_text(encoding="utf-8"))]


def films() -> bool:
    try:
        return bool(gl_backend())
    except DressingSimError:
        return os.environ.get("DRESSING_SIM_REQUIRE_GL") == "1"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A reader's folder: the examples of the clone, and the command on the path."""
    place = tmp_path_factory.mktemp("tutorial")
    (place / "examples").symlink_to(ROOT / "examples")
    command = place / "bin" / "dressing-sim"
    command.parent.mkdir()
    command.write_text(f'#!/bin/sh\nexec "{sys.executable}" -m dressing_sim "$@"\n')
    command.chmod(0o755)
    return place


def run(block: Block, folder: Path) -> str:
    code = block.code
    if block.language == "sh" and not films():
        code = re.sub(r" --video \S+", "", code)
    command = {"sh": ["bash", "-euc", code], "python": [sys.executable, "-c", code]}
    done = subprocess.run(
        command[block.language],
        cwd=folder,
        env={
            **os.environ,
            "PATH": f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}",
            "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]),
            "COLUMNS": "120",
        },
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    # Said once on a machine, by whichever command is the first to need a loop.
    return re.sub(r"^compiling loops, once.*\n", "", done.stdout, flags=re.MULTILINE)


@pytest.mark.parametrize("page", PAGES, ids=lambda path: path.stem)
def test_a_page_does_what_it_says(page, folder):
    for block in blocks_of(page):
        if block.file:
            (folder / block.file).write_text(block.code, encoding="utf-8")
        elif "venv" not in block.code:
            said = run(block, folder)
            told = OutputChecker().check_output(
                block.says or "...\n", said, ELLIPSIS | NORMALIZE_WHITESPACE
            )
            assert told, f"{block.code}says\n{said}"


def test_there_are_tutorials_and_each_has_blocks_to_run():
    assert [page.name[:10] for page in PAGES] == [f"tutorial-{n}" for n in (1, 2, 3, 4)]
    for page in PAGES:
        fences = re.findall(r"^```(\w+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
        blocks = blocks_of(page)
        assert len(fences) == len(blocks) + sum(one.says is not None for one in blocks)
        assert {one.language for one in blocks} <= {"sh", "python", "json"}


def test_they_are_installed_as_the_readme_says():
    (install,) = [one for page in PAGES for one in blocks_of(page) if "venv" in one.code]
    command = install.code.splitlines()[0]
    assert command in (ROOT / "README.md").read_text(encoding="utf-8")


def test_they_read_as_they_should():
    for page in PAGES:
        text = page.read_text(encoding="utf-8")
        assert "After this page" in text
