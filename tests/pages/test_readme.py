"""The README's example runs, and its commands are commands."""

import re
import shlex
from pathlib import Path

import pytest

from dressing_sim.cli import main

README = Path(__file__).resolve().parents[2] / "README.md"


def blocks(language: str) -> list[str]:
    return re.findall(rf"```{language}\n(.*?)```", README.read_text(encoding="utf-8"), re.DOTALL)


def test_the_example_runs_and_dresses(capsys: pytest.CaptureFixture[str]) -> None:
    (example,) = blocks("python")
    assert len(example.strip().splitlines()) == 12
    exec(compile(example, str(README), "exec"), {})
    assert capsys.readouterr().out.startswith("True ()")


def test_every_printed_command_exists(capsys: pytest.CaptureFixture[str]) -> None:
    text = README.read_text(encoding="utf-8")
    commands = set(re.findall(r"dressing-sim ([a-z]+)", text))
    assert {"evaluate", "dress", "doctor", "planar"} <= commands
    for command in commands:
        with pytest.raises(SystemExit) as stop:
            main([command, "--help"])
        assert stop.value.code == 0


def test_two_commands_install_into_an_environment_of_their_own() -> None:
    install = [line for block in blocks("sh") for line in block.splitlines() if "venv" in line]
    assert len(install) == 2
    for line in install:
        assert shlex.split(line)[:4] == ["python3", "-m", "venv", ".venv"]
