import inspect
import re
import subprocess
import sys
from pathlib import Path

import pytest

from dressing_sim import learning

DOCS = Path(__file__).resolve().parents[2] / "docs"


def test_the_examples_run():
    blocks = re.findall(r"```python\n(.*?)```", (DOCS / "learning.md").read_text(), re.DOTALL)
    assert [len(code.splitlines()) <= 16 for code in blocks] == [True, True, True]
    code = "\n".join(blocks)  # they go on with the first one's demonstrations
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert "candidates" in run.stdout
    assert "poses (100, 3) (100, 4)" in run.stdout
    assert "demonstration 1 was cut short" in run.stdout


@pytest.mark.parametrize("name", learning.__all__)
def test_every_public_name_exists_and_says_what_it_is(name):
    thing = getattr(learning, name)
    if inspect.isclass(thing) or inspect.isfunction(thing):
        assert (thing.__doc__ or "").strip()
