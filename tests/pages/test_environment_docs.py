"""What the page on environments says is so."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

from dressing_sim.envs.config import EnvConfig

PAGE = Path(__file__).resolve().parents[2] / "docs" / "environments.md"
TEXT = PAGE.read_text(encoding="utf-8")


@pytest.mark.parametrize("code", re.findall(r"```python\n(.*?)```", TEXT, re.DOTALL))
def test_its_code_runs(code):
    needed = {"dm_control": "envs import dm" in code, "lerobot": "lerobot" in code}
    pytest.importorskip(next((name for name, is_used in needed.items() if is_used), "gymnasium"))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def test_its_table_has_every_observation_and_shape():
    from dressing_sim.envs.config import EXTRAS

    for name, one in EnvConfig(observe=EXTRAS).observation_ranges.items():
        (line,) = [row for row in TEXT.splitlines() if row.startswith("| `") and f"`{name}`" in row]
        shape = "(n, 3)" if name == "cloth" else str(one.shape)
        assert f"| {shape} |" in line


def test_it_names_every_choice():
    named = set(re.findall(r"`(\w+)[=`]", TEXT))
    assert set(EnvConfig.__dataclass_fields__) - {"episode"} <= named | {"control"}
