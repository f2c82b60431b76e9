"""What the pages on recordings and data sets say is so."""

import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import pytest
from lab_recordings import TURN_DEG, columns

from dressing_sim.cli import main
from dressing_sim.datasets.columns import OBSERVED, OPTIONAL
from dressing_sim.datasets.prepare import ImportConfig, demonstration_of
from dressing_sim.datasets.recording import of_columns
from dressing_sim.episode.demonstration import load_demonstrations, save_demonstrations

ROOT = Path(__file__).resolve().parents[2]
DATASETS = (ROOT / "docs" / "datasets.md").read_text(encoding="utf-8")
RECORDINGS = (ROOT / "docs" / "recordings.md").read_text(encoding="utf-8")


CODE = re.findall(r"```python\n(.*?)```", DATASETS, re.DOTALL)


@pytest.fixture
def file(demonstration, tmp_path):
    real = demonstration_of(of_columns("r", columns()), ImportConfig(turn_deg=-TURN_DEG))
    save_demonstrations(tmp_path / "case_a.h5", [demonstration, real])
    return tmp_path / "case_a.h5"


def test_h5py_alone_reads_a_file(file):
    code, _ = CODE
    assert not re.search(r"import dressing_sim|from dressing_sim", code)
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=file.parent, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert len(done.stdout.splitlines()) == 4


def test_lerobot_reads_a_folder(demonstration, tmp_path, monkeypatch, opengl):
    pytest.importorskip("lerobot", reason="LeRobot is not installed: it needs Python 3.12")
    begun = demonstration.positions[:3], demonstration.commands[:3]
    monkeypatch.chdir(tmp_path)
    save_demonstrations(
        "case_a.h5", [replace(demonstration, positions=begun[0], commands=begun[1])]
    )
    (line,) = re.findall(r"^ {4}dressing-sim (export .* --width 320 .*)$", DATASETS, re.MULTILINE)
    main(line.split())
    done = subprocess.run(
        [sys.executable, "-c", CODE[1]], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "'observation.images.close': (3, 240, 320)" in done.stdout


def test_the_page_names_every_field_and_no_other(file):
    documented = set(re.findall(r"^\| (`.*?`) \|", DATASETS, re.MULTILINE))
    named = {name for cell in documented for name in re.findall(r"`(\w+)`", cell)}
    with h5py.File(file) as content:
        fields = {*content.attrs}
        for group in content.values():
            fields |= {*group, *group.attrs}
    assert named == fields | {*OBSERVED} | {*OPTIONAL}


def test_the_recordings_that_come_along_are_read_as_the_page_says(tmp_path, monkeypatch, capsys):
    (line,) = re.findall(r"^ {4}dressing-sim (import examples.*)$", RECORDINGS, re.MULTILINE)
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples" / "recordings", tmp_path / "examples" / "recordings")
    main(line.split())
    made = load_demonstrations("mine.h5")
    assert [one.posture.name for one in made] == ["straight", "bent"]
    assert made[1].posture.elbow_deg > made[0].posture.elbow_deg + 10.0
    for one in made:
        # Rounded to hundredths of a millimetre, and by the lab to a frame of its own.
        assert one.posture.arm_size.forearm_length == pytest.approx(0.257, abs=2e-4)


def test_every_option_of_the_page_is_one(capsys):
    with pytest.raises(SystemExit):
        main(["import", "--help"])
    told = capsys.readouterr().out
    for option in re.findall(r"^\| `(--[a-z-]+)` \|", RECORDINGS, re.MULTILINE):
        assert option in told
