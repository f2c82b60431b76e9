"""The cache of compiled loops never stands in the way, whatever has become of its files."""

import os
import subprocess
import sys

import pytest

# However fast the machine is, compiling says so.
SCRIPT = """
import numpy as np
from dressing_sim import compiled
compiled.PATIENCE = 0.0
from dressing_sim.learning import dtw_distance
a = np.linspace(0.0, 1.0, 30)[:, None] * [1.0, 2.0, 3.0]
print(repr(float(dtw_distance(a, a[::2] + 0.01))))
"""


def run(folder, **more):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder), **more}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT], env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr


@pytest.fixture(scope="module")
def filled(tmp_path_factory):
    folder = tmp_path_factory.mktemp("numba")
    answer, told = run(folder)
    assert "compiling" in told
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert files
    return answer, folder, files


def test_a_second_process_compiles_nothing(filled):
    answer, folder, _ = filled
    assert run(folder) == (answer, "")


@pytest.mark.parametrize(
    ("suffix", "damage"),
    [
        (".nbi", lambda content: content[: len(content) // 2]),
        (".nbc", lambda content: b""),
        (".nbi", lambda content: b"not what it was" * 100),
        (".nbc", lambda content: content[:-9] + bytes([content[-9] ^ 1]) + content[-8:]),
    ],
    ids=["cut", "emptied", "overwritten", "flipped"],
)
def test_damaged_files_are_made_anew_with_one_warning(filled, suffix, damage):
    answer, folder, files = filled
    for path in files:
        if path.suffix == suffix:
            path.write_bytes(damage(path.read_bytes()))
    again, told = run(folder)
    assert again == answer
    assert "Traceback" not in told
    assert told.count("compiled loops are ") == 1
    assert run(folder) == (answer, "")


def test_where_nothing_can_be_written_it_compiles_and_warns_once(tmp_path):
    folder = tmp_path / "taken"
    folder.write_text("a file")
    # Else numba would go on to the package's folder and the user's.
    answer, told = run(folder, NUMBA_CACHE_LOCATOR_CLASSES="UserProvidedCacheLocator")
    assert answer
    assert told.count("compiled loops are not kept") == 1
    assert "NUMBA_CACHE_DIR" in told


def test_several_processes_at_once_on_an_empty_cache(tmp_path, filled):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    running = [
        subprocess.Popen(
            [sys.executable, "-c", SCRIPT],
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(4)
    ]
    for process in running:
        answer, told = process.communicate()
        assert (process.returncode, answer) == (0, filled[0]), told
        assert "Traceback" not in told
    assert run(tmp_path) == (filled[0], "")
